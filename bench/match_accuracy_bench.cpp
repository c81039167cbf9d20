// How often matching ends where it should: match_accuracy_bench [STARTS [POINTS [PART]]] prints
// docs/evidence/matching-benchmark.md; PART: starts, change, basin, coarse or times, or the name of a pair for its row
// alone.
//
// Every start has scans of its own (seed of the noise and of the sampling), cut to an overlap of its own, moved by a
// rotation and a shift of its own. Beside what matching reaches stands what no method could better: the Cramér-Rao
// bound of the rigid motion, from the slopes of the surface itself, the number of points and the noise.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "isopach/base/median.hpp"
#include "isopach/base/random.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/match/match.hpp"
#include "isopach/simulate/bump.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/match/poses.hpp"

namespace isopach {
namespace {

constexpr double degree_target = 0.005, shift_target = 2e-5;
constexpr int time_runs = 5;

struct Pair {
  std::string name, scene, variant;
  double extent, noise;  // noise: a thousandth of the relief
  double share_b;        // points of B over points of A
  double changed = 0;    // share of the area under a hill that only B has
  double degrees = 10;   // largest rotation
  bool about_axis = false;
  bool swollen = false;  // the face of the scene's second epoch, one cheek of which is swollen by 6 mm
  bool coarse = false;
};

const std::vector<Pair> pairs{{"terrain", "relief", "unchanged", 1000, 0.07, 1},
                              {"terrain, B half as dense", "relief", "unchanged", 1000, 0.07, 0.5},
                              {"face", "face", "", 236, 0.1, 1},
                              {"face, B half as dense", "face", "", 236, 0.1, 0.5},
                              {"face, one cheek swollen in B", "face", "", 236, 0.1, 1, 0, 10, false, true}};

struct Numbers {
  RandomStream random;
  std::uint64_t next = 0;
  explicit Numbers(std::uint64_t seed) : random(seed, 77) {}
  double uniform(double from, double to) { return from + (to - from) * random.uniform(next++); }
  double normal() { return random.normal(1000 + next++); }
};

Point3 direction(Numbers& numbers) {
  const double z = numbers.uniform(-1, 1), angle = numbers.uniform(0, 2 * std::numbers::pi), r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

// The part of a cloud below the quantile `share` of its places along (c, s), or above that of 1 − share.
Cloud part(const Cloud& cloud, double c, double s, double share, bool lower) {
  std::vector<double> along;
  for (const Point3& p : cloud.points) along.push_back(c * p.x + s * p.y);
  std::vector<double> sorted = along;
  const double q = lower ? share : 1 - share;
  const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), at, sorted.end());
  Cloud out;
  for (std::size_t i = 0; i < along.size(); ++i)
    if (lower ? along[i] <= *at : along[i] >= *at) out.points.push_back(cloud.points[i]);
  return out;
}

struct Start {
  Cloud fixed, still, moving;  // still: MOVING where it belongs
  Pose away;
  Point3 middle;
  double volume = 0;  // of the hill
  Point2 cut{1, 0};   // both are cut across this direction
};

Start make_start(const Pair& pair, std::size_t n, std::uint64_t seed, double least_overlap) {
  Context context;
  context.seed = seed;
  SceneOptions o;
  o.points_a = n, o.points_b = static_cast<std::size_t>(pair.share_b * static_cast<double>(n));
  o.noise_a = o.noise_b = pair.noise;
  o.variant = pair.variant;
  Scene scene = make_scene(pair.scene, o, context);
  if (pair.scene == "face" && !pair.swollen) {
    const auto first = scene_surface("face", "", 1), second = scene_surface("face", "", 2);
    for (Point3& p : scene.b.points) p.z += first(p.x, p.y) - second(p.x, p.y);
  }
  Numbers numbers(seed);
  const double overlap = numbers.uniform(least_overlap, 1), share = 1 / (2 - overlap);
  const double angle = numbers.uniform(0, 2 * std::numbers::pi), c = std::cos(angle), s = std::sin(angle);
  Start start;
  if (pair.changed > 0) {  // a hill of ellipse π a b, so high that it is no noise: a hundredth of the extent
    const Point3 m = test::middle_of(scene.b);
    Bump hill{{m.x + 0.1 * pair.extent, m.y - 0.05 * pair.extent}, 0.01 * pair.extent, 0, 0, {c, s}, 0, 0.5};
    hill.b = pair.extent * std::sqrt(pair.changed / (2 * std::numbers::pi)), hill.a = 2 * hill.b;
    for (Point3& p : scene.b.points) p.z += hill.at(p.x, p.y);
    start.volume = hill.volume();
  }
  start.fixed = part(scene.a, c, s, share, true);
  start.still = part(scene.b, c, s, share, false);
  start.cut = {c, s};
  start.middle = test::middle_of(start.still);
  const Point3 along = direction(numbers), axis = pair.about_axis ? Point3{0, 0, 1} : direction(numbers);
  const double far = numbers.uniform(0, 0.05) * pair.extent;
  start.away = test::turn_and_shift(axis, numbers.uniform(-pair.degrees, pair.degrees), start.middle,
                                    {far * along.x, far * along.y, far * along.z});
  start.moving = test::posed(start.still, start.away);
  return start;
}

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Covariance of the motion of the best unbiased estimator: differences of heights of the two scans, as many as points
// of both allow, with the slopes of the surface itself.
Matrix6 bound(const Pair& pair, const Start& start) {
  const auto surface = scene_surface(pair.scene, pair.variant, 1);
  const auto along = [&](const Point3& p) { return start.cut.x * p.x + start.cut.y * p.y; };
  double end = -std::numeric_limits<double>::infinity();  // of FIXED
  for (const Point3& p : start.fixed.points) end = std::max(end, along(p));
  const double per_difference = pair.noise * pair.noise * (1 + pair.share_b);
  Matrix6 information = Matrix6::Zero();
  const double h = 1e-4 * pair.extent;
  for (const Point3& p : start.still.points) {
    if (along(p) > end) continue;
    const double gx = (surface(p.x + h, p.y) - surface(p.x - h, p.y)) / (2 * h),
                 gy = (surface(p.x, p.y + h) - surface(p.x, p.y - h)) / (2 * h);
    if (!std::isfinite(gx) || !std::isfinite(gy)) continue;
    const Eigen::Vector3d arm(p.x - start.middle.x, p.y - start.middle.y, p.z - start.middle.z), up(-gx, -gy, 1);
    Eigen::Matrix<double, 6, 1> j;
    j << arm.cross(up), up;
    information += j * j.transpose() / per_difference;
  }
  return information.inverse();
}

// Turn about the middle (rad) and its shift.
Eigen::Matrix<double, 6, 1> errors_of(const Pose& p, const Point3& middle) {
  Eigen::Matrix3d r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = p.m[static_cast<std::size_t>(4 * i + j)];
  const Eigen::AngleAxisd turn(r);
  const Point3 there = p.apply(middle);
  Eigen::Matrix<double, 6, 1> e;
  e << turn.angle() * turn.axis(), there.x - middle.x, there.y - middle.y, there.z - middle.z;
  return e;
}

struct Found {
  double degrees = 0, shift = 0;  // shift as a share of the extent
  bool converged = false;
  double bound_degrees = 0, bound_shift = 0, bound_reached = 0;
  double own_degrees = 0;  // what matching says of itself
  double deviations = 0;   // root mean square of the six errors, in standard deviations of the bound
  bool reached() const { return degrees <= degree_target && shift <= shift_target; }
};

// How often a normal error with this covariance is within the targets.
double share_within(const Matrix6& covariance, double extent) {
  const Eigen::Matrix<double, 6, 6> root = covariance.llt().matrixL();
  Numbers numbers(5);
  constexpr int draws = 400;
  int within = 0;
  for (int i = 0; i < draws; ++i) {
    Eigen::Matrix<double, 6, 1> z;
    for (int k = 0; k < 6; ++k) z(k) = numbers.normal();
    const Eigen::Matrix<double, 6, 1> e = root * z;
    if (e.head<3>().norm() * 180 / std::numbers::pi <= degree_target && e.tail<3>().norm() <= shift_target * extent)
      ++within;
  }
  return static_cast<double>(within) / draws;
}

Found try_start(const Pair& pair, const Start& start, bool with_bound) {
  MatchOptions options;
  options.compare.check_layers = false;
  options.judge = false;
  options.coarse = pair.coarse;
  const Matching m = match(start.moving, start.fixed, options, {});
  const test::PoseError error = test::off_identity(test::chained(m.pose, start.away), start.middle);
  Found f;
  f.degrees = error.degrees, f.shift = error.shift / pair.extent, f.converged = m.converged;
  double own = 0;
  for (std::size_t k = 0; k < 3; ++k) own += m.covariance[7 * k];
  f.own_degrees = std::sqrt(own) * 180 / std::numbers::pi;
  if (!with_bound) return f;
  const Matrix6 c = bound(pair, start);
  const Eigen::Matrix<double, 6, 1> e = errors_of(test::chained(m.pose, start.away), start.middle);
  f.deviations = std::sqrt(e.dot(c.ldlt().solve(e)) / 6);
  f.bound_degrees = std::sqrt(c.topLeftCorner<3, 3>().trace()) * 180 / std::numbers::pi;
  f.bound_shift = std::sqrt(c.bottomRightCorner<3, 3>().trace()) / pair.extent;
  f.bound_reached = share_within(c, pair.extent);
  return f;
}

double rms(const std::vector<Found>& all, double Found::*what) {
  double sum = 0;
  for (const Found& f : all) sum += f.*what * (f.*what);
  return std::sqrt(sum / static_cast<double>(all.size()));
}

double quantile(std::vector<Found> all, double Found::*what, double q) {
  std::sort(all.begin(), all.end(), [&](const Found& a, const Found& b) { return a.*what < b.*what; });
  return all[static_cast<std::size_t>(q * static_cast<double>(all.size() - 1))].*what;
}

void rows(std::size_t starts, std::size_t n, const std::string& only) {
  for (const Pair& pair : pairs) {
    if (!only.empty() && pair.name != only) continue;
    std::vector<Found> all;
    double reached = 0, possible = 0;
    for (std::size_t i = 0; i < starts; ++i) {
      all.push_back(try_start(pair, make_start(pair, n, 1 + i, 0.6), true));
      reached += all.back().reached(), possible += all.back().bound_reached;
    }
    const auto count = static_cast<double>(starts);
    fmt::print(
        "| {} | {} | {} | {:.1f} % | {:.1f} % | {:.4f}°, {:.4f}°, {:.4f}° | {:.1e}, {:.1e}, {:.1e} | {:.4f}°, {:.4f}°, "
        "{:.4f}° | {:.2f} |\n",
        pair.name, n, starts, 100 * reached / count, 100 * possible / count, quantile(all, &Found::degrees, 0.5),
        quantile(all, &Found::degrees, 0.95), quantile(all, &Found::degrees, 1), quantile(all, &Found::shift, 0.5),
        quantile(all, &Found::shift, 0.95), quantile(all, &Found::shift, 1), rms(all, &Found::degrees),
        rms(all, &Found::own_degrees), rms(all, &Found::bound_degrees), rms(all, &Found::deviations));
    std::fflush(stdout);
  }
}

void accuracy(std::size_t starts, std::size_t n) {
  fmt::print(
      "## Random starts\n\n"
      "Every start: scans with noise and sampling of their own, cut to an overlap between 60 % and 100 %, turned by up "
      "to "
      "10 degrees about any axis, shifted by up to 5 % of the extent. Noise: a thousandth of the relief. Reached: "
      "rotation "
      "within {}° and shift of the middle within {:.0e} of the extent. By the bound: how often normal errors with the "
      "smallest covariance that any unbiased method can have (Cramér-Rao: slopes of the true surface, noise, points in "
      "the common area; no error of interpolation) are within both. Said: the standard deviation that the matching "
      "gives. In deviations: root mean square of the six errors of turn and shift, each start's in standard deviations "
      "of its bound; 1: none is better.\n\n"
      "| pair | points of A | starts | reached | by the bound | rotation: median, 95 %, worst | shift: median, 95 %, "
      "worst | rotation, rms: found, said, bound | in deviations |\n|---|---|---|---|---|---|---|---|---|\n",
      degree_target, shift_target);
  rows(starts, n, "");
  rows(std::max<std::size_t>(4, starts / 10), 10 * n, "");
}

// A fifth of the area is truly different: what it does to the pose, and what is then measured of it.
void change(std::size_t starts, std::size_t n) {
  fmt::print(
      "\n## A fifth of the area changed\n\n"
      "{} points. A hill of known volume over 20 % of the terrain, in B alone; both scans whole, turned and shifted as "
      "above. "
      "Volume: "
      "net volume of the comparison at the found pose over the true one.\n\n"
      "| | starts | rotation, rms | shift, rms | volume, largest error |\n|---|---|---|---|---|\n",
      n);
  for (const double changed : {0.0, 0.2}) {
    Pair pair = pairs[0];
    pair.changed = changed;
    std::vector<Found> all;
    double worst = 0;
    for (std::size_t i = 0; i < starts; ++i) {
      const Start start = make_start(pair, n, 1 + i, 1);
      MatchOptions options;
      options.compare.check_layers = false;
      options.judge = changed > 0;
      options.keep_comparisons = true;
      const Matching m = match(start.moving, start.fixed, options, {});
      const test::PoseError error = test::off_identity(test::chained(m.pose, start.away), start.middle);
      Found f;
      f.degrees = error.degrees, f.shift = error.shift / pair.extent;
      all.push_back(f);
      if (changed > 0) worst = std::max(worst, std::fabs(m.comparison_after->measures.volume.net / start.volume - 1));
    }
    fmt::print("| {} | {} | {:.5f}° | {:.1e} | {} |\n", changed > 0 ? "with the hill" : "without", starts,
               rms(all, &Found::degrees), rms(all, &Found::shift),
               changed > 0 ? fmt::format("{:.2f} %", 100 * worst) : "–");
    std::fflush(stdout);
  }
}

// From how far about the axis it still comes back.
void basin(std::size_t n) {
  fmt::print(
      "\n## Basin about the axis\n\n{} points. Shift of up to 5 % of the extent, whole scans; four starts of each "
      "angle, half of "
      "them the other way. Back: as above.\n\n| pair | 15° | 30° | 45° |\n|---|---|---|---|\n",
      n);
  for (Pair pair : {pairs[0], pairs[2]}) {
    pair.about_axis = true;
    fmt::print("| {} |", pair.name);
    for (const double angle : {15.0, 30.0, 45.0}) {
      int back = 0;
      for (std::uint64_t i = 0; i < 4; ++i) {
        pair.degrees = 0;
        Start start = make_start(pair, n, 1 + i, 1);
        const Pose turn = test::turn_and_shift({0, 0, 1}, i % 2 == 0 ? angle : -angle, start.middle, {0, 0, 0});
        start.away = test::chained(start.away, turn);
        start.moving = test::posed(start.still, start.away);
        back += try_start(pair, start, false).reached();
      }
      fmt::print(" {} of 4 |", back);
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}

// From any turn about the axis.
void coarse(std::size_t starts, std::size_t n) {
  fmt::print(
      "\n## Any turn about the axis, with --coarse\n\n{} points. Overlap and shift as in the first table. Found: "
      "within 0.1° and "
      "a "
      "thousandth of the extent. Reached: as above.\n\n| pair | starts | found | reached | rotation: median, 95 %, "
      "worst "
      "|\n|---|---|---|---|---|\n",
      n);
  for (Pair pair : {pairs[0], pairs[2]}) {
    pair.about_axis = pair.coarse = true;
    pair.degrees = 180;
    std::vector<Found> all;
    double found = 0, reached = 0;
    for (std::size_t i = 0; i < starts; ++i) {
      all.push_back(try_start(pair, make_start(pair, n, 101 + i, 0.6), false));
      found += all.back().degrees < 0.1 && all.back().shift < 1e-3, reached += all.back().reached();
    }
    const auto count = static_cast<double>(starts);
    fmt::print("| {} | {} | {:.1f} % | {:.1f} % | {:.4f}°, {:.4f}°, {:.4f}° |\n", pair.name, starts,
               100 * found / count, 100 * reached / count, quantile(all, &Found::degrees, 0.5),
               quantile(all, &Found::degrees, 0.95), quantile(all, &Found::degrees, 1));
    std::fflush(stdout);
  }
}

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Time of the processor, all threads together: what else runs on the machine hardly changes it.
void times(const std::vector<std::size_t>& sizes) {
  fmt::print(
      "\n## Time\n\nThe first start of the face, medians of {}, one thread, time of the processor: reading and the "
      "two comparisons not counted. Per point of both scans: all of it, then its stages.\n\n| points of A | to the "
      "pose | per point | project | triangulate | border | "
      "facets | search | rotation error |\n|---|---|---|---|---|---|---|---|---|\n",
      time_runs);
  for (const std::size_t n : sizes) {
    const Start start = make_start(pairs[2], n, 1, 0.6);
    const auto points = static_cast<double>(start.moving.points.size() + start.fixed.points.size());
    std::vector<double> totals;
    std::array<std::vector<double>, 5> stages;
    double degrees = 0;
    for (int i = 0; i < time_runs; ++i) {
      MatchOptions options;
      options.compare.check_layers = false;
      options.judge = false;
      Context context;
      context.threads = 1;
      const double before = seconds();
      const Matching m = match(start.moving, start.fixed, options, context);
      const double used = seconds() - before;
      degrees = test::off_identity(test::chained(m.pose, start.away), start.middle).degrees;
      totals.push_back(used);
      for (std::size_t k = 0; k < stages.size(); ++k)
        stages[k].push_back(1e9 * used / points * m.timing.stages.at(k).second / m.timing.total);
    }
    fmt::print("| {} | {:.3f} s | {:.0f} ns |", n, median(totals), 1e9 * median(totals) / points);
    for (std::vector<double>& stage : stages) fmt::print(" {:.0f} ns |", median(stage));
    fmt::print(" {:.4f}° |\n", degrees);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace isopach

int main(int argc, char** argv) {
  using namespace isopach;
  const auto starts = static_cast<std::size_t>(argc > 1 ? std::atof(argv[1]) : 200);
  const auto n = static_cast<std::size_t>(argc > 2 ? std::atof(argv[2]) : 1e5);
  const std::string part = argc > 3 ? argv[3] : "";
  const auto is_asked = [&](const std::string& name) { return part.empty() || part == name; };
  if (part.empty())
    fmt::print(
        "# Matching: accuracy\n\nWritten by `match_accuracy_bench` (release build with ISOPACH_BENCH), each table with "
        "its starts and points: scenes of `isopach simulate`, `isopach match --pose-only` from each start, without "
        "--coarse but in its own table.\n\n");
  const bool is_pair = std::any_of(pairs.begin(), pairs.end(), [&](const Pair& p) { return p.name == part; });
  if (is_pair) rows(starts, n, part);
  if (is_asked("starts")) accuracy(starts, n);
  if (is_asked("change")) change(std::max<std::size_t>(4, starts / 5), n);
  if (is_asked("basin")) basin(n);
  if (is_asked("coarse")) coarse(starts, n);
  if (is_asked("times")) times({n / 2, n, 2 * n});
  if (part.empty())
    fmt::print(
        "\n## Aims\n\nReached: 99 % of the starts in every row of the first table, 95 % with --coarse. Any row below "
        "that is missed; what noise alone would miss of it is in the column of the bound.\n");
  return 0;
}
