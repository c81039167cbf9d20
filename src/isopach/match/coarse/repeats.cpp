#include "isopach/match/coarse/repeats.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/coarse/consensus.hpp"
#include "isopach/match/pairs/least_squares.hpp"
#include "isopach/match/verdict/another.hpp"

namespace isopach {
namespace {

constexpr std::size_t landmark_count = 700;
constexpr std::size_t points_of_one = 4;  // at least
constexpr std::size_t asked_count = 175;  // landmarks that look for others
constexpr std::size_t row_block = 16;
constexpr std::size_t fitted_count = 300;  // points that are moved and looked at
constexpr int fitting_steps = 8;
constexpr double same_side = 0.7;       // cosine of the normals of a pair
constexpr double within_noises = 4.5;   // 3 standard deviations of two points' noise
constexpr double least_seen = 0.25;     // of the points that are moved, on the scan again
constexpr double least_fitting = 0.6;   // of these within noise
constexpr std::size_t most_cells = 64;  // of the raster of heights, along its longer side
constexpr double least_correlation = 0.7, least_shift = 0.06, least_common = 0.3;

/// For some landmarks the one that looks most alike of those beyond the support, which shares no point with it.
std::vector<Likeness> likenesses_elsewhere(const Landmarks& marks, const Context& context) {
  context.check();
  const std::size_t n = marks.places.size(), stride = std::max<std::size_t>(1, n / asked_count);
  std::vector<std::optional<Likeness>> found((n + stride - 1) / stride);
  const double beyond = support_sides * marks.side;
  for_blocks(found.size(), row_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const std::size_t i = row * stride;
      if (squared_length(marks.normals[i]) == 0) continue;
      std::size_t best = n;
      float least = std::numeric_limits<float>::infinity();
      for (std::size_t k = 0; k < n; ++k) {
        if (squared_length(marks.normals[k]) == 0) continue;
        if (squared_length(marks.places[k] - marks.places[i]) <= beyond * beyond) continue;
        const float d = image_distance(marks.images[i], marks.images[k]);
        if (d < least) best = k, least = d;
      }
      if (best < n) found[row] = {marks.places[i], marks.places[best], marks.normals[i], marks.normals[best], least};
    }
  });
  std::vector<Likeness> kept;
  for (const std::optional<Likeness>& likeness : found)
    if (likeness) kept.push_back(*likeness);
  return kept;
}

std::vector<Motion> by_landmarks(const JudgedScan& scan, double side, const Context& context) {
  Landmarks marks = landmarks(scan.points, side, context), none;
  none.side = side;
  describe(marks, none, context);
  std::vector<Motion> motions;
  for (const Agreement& a : agreements(likenesses_elsewhere(marks, context), side, most_repeats, context))
    motions.push_back(a.motion);
  return motions;
}

/// Mean heights over the plane through the scan, by square cells; NaN where there is no point.
struct Heights {
  Eigen::Matrix3d axes;  ///< columns u, v in the plane, w across
  double side = 1;
  std::size_t columns = 0, rows = 0;
  std::vector<double> z;

  [[nodiscard]] double at(std::size_t column, std::size_t row) const { return z[row * columns + column]; }
};

Heights heights_of(const JudgedScan& scan) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const auto vector = [](const Point3& p) { return Eigen::Vector3d(p.x, p.y, p.z); };
  for (const Point3& p : scan.points) mean += vector(p);
  mean /= static_cast<double>(scan.points.size());
  for (const Point3& p : scan.points) scatter += (vector(p) - mean) * (vector(p) - mean).transpose();
  const Spectrum<3> s = spectrum(scatter);
  Heights h;
  h.axes.col(0) = s.vectors.col(2), h.axes.col(1) = s.vectors.col(1), h.axes.col(2) = s.vectors.col(0);
  std::vector<Eigen::Vector3d> local;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Point3& p : scan.points) {
    local.emplace_back(h.axes.transpose() * (vector(p) - mean));
    low = low.cwiseMin(local.back()), high = high.cwiseMax(local.back());
  }
  const auto wanted = std::sqrt(static_cast<double>(scan.points.size()) / 2);
  h.side = std::max(high(0) - low(0), high(1) - low(1)) / std::clamp(wanted, 1.0, static_cast<double>(most_cells));
  if (!(h.side > 0)) return h;
  h.columns = static_cast<std::size_t>((high(0) - low(0)) / h.side) + 1;
  h.rows = static_cast<std::size_t>((high(1) - low(1)) / h.side) + 1;
  std::vector<double> count(h.columns * h.rows, 0);
  h.z.assign(h.columns * h.rows, 0);
  for (const Eigen::Vector3d& p : local) {
    const auto cell = static_cast<std::size_t>((p(1) - low(1)) / h.side) * h.columns +
                      static_cast<std::size_t>((p(0) - low(0)) / h.side);
    h.z[cell] += p(2), count[cell] += 1;
  }
  for (std::size_t i = 0; i < h.z.size(); ++i)
    h.z[i] = count[i] > 0 ? h.z[i] / count[i] : std::numeric_limits<double>::quiet_NaN();
  return h;
}

/// Correlation of the heights with themselves, shifted by whole cells; −1 where too little is in common.
double correlation(const Heights& h, std::ptrdiff_t right, std::ptrdiff_t up) {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  const auto columns = static_cast<std::ptrdiff_t>(h.columns), rows = static_cast<std::ptrdiff_t>(h.rows);
  for (std::ptrdiff_t row = std::max<std::ptrdiff_t>(0, -up); row < std::min(rows, rows - up); ++row)
    for (std::ptrdiff_t column = std::max<std::ptrdiff_t>(0, -right); column < std::min(columns, columns - right);
         ++column) {
      const double a = h.at(static_cast<std::size_t>(column), static_cast<std::size_t>(row)),
                   b = h.at(static_cast<std::size_t>(column + right), static_cast<std::size_t>(row + up));
      if (std::isnan(a) || std::isnan(b)) continue;
      n += 1, x += a, y += b, xx += a * a, yy += b * b, xy += a * b;
    }
  if (n < least_common * static_cast<double>(h.z.size())) return -1;
  const double spread = (xx - x * x / n) * (yy - y * y / n);
  return spread > 0 ? (xy - x * y / n) / std::sqrt(spread) : -1;
}

std::vector<Motion> by_shifts(const JudgedScan& scan, const Context& context) {
  const Heights h = heights_of(scan);
  const auto right = static_cast<std::ptrdiff_t>(h.columns / 2), up = static_cast<std::ptrdiff_t>(h.rows / 2);
  const std::ptrdiff_t width = 2 * right + 1;
  std::vector<double> all(static_cast<std::size_t>(width * (2 * up + 1)), -1);
  const auto at = [&](std::ptrdiff_t i, std::ptrdiff_t j) -> double& {
    return all[static_cast<std::size_t>((j + up) * width + i + right)];
  };
  for_blocks(static_cast<std::size_t>(up + 1), 1, [&](std::size_t begin, std::size_t end) {
    context.check();
    for (auto j = static_cast<std::ptrdiff_t>(begin); j < static_cast<std::ptrdiff_t>(end); ++j)
      for (std::ptrdiff_t i = -right; i <= right; ++i) at(i, j) = at(-i, -j) = correlation(h, i, j);
  });
  std::vector<std::pair<double, Motion>> peaks;
  const double least = least_shift * scan.extent / h.side;
  for (std::ptrdiff_t j = 0; j < up; ++j)
    for (std::ptrdiff_t i = 1 - right; i < right; ++i) {
      const double c = at(i, j);
      if (c < least_correlation || std::hypot(i, j) < least) continue;
      bool is_peak = true;
      for (std::ptrdiff_t b = -1; b <= 1; ++b)
        for (std::ptrdiff_t a = -1; a <= 1; ++a) is_peak = is_peak && at(i + a, j + b) <= c;
      if (!is_peak) continue;
      Motion m;
      const Eigen::Vector3d shift =
          h.side * (static_cast<double>(i) * h.axes.col(0) + static_cast<double>(j) * h.axes.col(1));
      m.shift = {shift(0), shift(1), shift(2)};
      peaks.emplace_back(c, m);
    }
  std::stable_sort(peaks.begin(), peaks.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Motion> motions;
  for (std::size_t k = 0; k < std::min(most_repeats, peaks.size()); ++k) motions.push_back(peaks[k].second);
  return motions;
}

/// How the scan lies on itself once it is moved and has settled there.
struct SelfFit {
  Motion motion;
  double seen = 0, fits = 0;  ///< share of the points that come to lie on the scan; of these, within its noise
};

SelfFit settled(const JudgedScan& scan, Motion motion, double reach) {
  const std::size_t stride = std::max<std::size_t>(1, scan.queries.size() / fitted_count);
  for (int step = 0;; ++step) {
    Array<Link> links;
    double asked = 0, fits = 0;
    for (std::size_t i = 0; i < scan.queries.size(); i += stride) {
      const Index query = scan.queries[i];
      const Point3 q = motion.apply(scan.points[query]);
      const PointTree::Two two = scan.tree->nearest_two(q);
      asked += 1;
      const Point3 &p = scan.points[two.first], &normal = scan.normals[two.first];
      if (two.first2 > reach * reach || dot(motion.turn(scan.normals[query]), normal) < same_side) continue;
      links.push_back({q, p, normal, 1, 0});
      fits += std::fabs(dot(q - p, normal)) <= within_noises * scan.noise ? 1 : 0;
    }
    const auto seen = static_cast<double>(links.size());
    if (seen < least_seen * asked) return {motion, 0, 0};
    if (step == fitting_steps) return {motion, seen / asked, fits / seen};
    const PairInformation in = pair_information(links, PairKind::plane);
    constexpr double held = 1e-9;
    motion = moved(motion, plane_step(in, Freedom{}, held), in.centre);
  }
}

Pose pose_in_scan(const Motion& m) { return pose_of(m, Frame{}, Pose{}); }

}  // namespace

std::vector<Motion> repeats(const JudgedScan& scan, const Context& context) {
  if (!scan.usable()) return {};
  const std::size_t target = std::clamp<std::size_t>(scan.points.size() / points_of_one, 50, landmark_count);
  const double side = landmark_side(scan.points, {}, target);
  std::vector<Motion> starts = by_shifts(scan, context);
  for (const Motion& m : by_landmarks(scan, side, context)) starts.push_back(m);
  std::vector<std::pair<double, Motion>> found;
  std::vector<Pose> known{Pose{}};
  for (const Motion& start : starts) {
    context.check();
    const SelfFit fit = settled(scan, start, side);
    if (fit.seen < least_seen || fit.fits < least_fitting) continue;
    const Pose pose = pose_in_scan(fit.motion);
    const bool is_new = std::all_of(known.begin(), known.end(), [&](const Pose& other) {
      return is_another(other, pose, {0, 0, 0}, scan.extent);
    });
    if (!is_new) continue;
    known.push_back(pose);
    found.emplace_back(fit.seen * fit.fits, fit.motion);
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Motion> motions;
  for (const auto& [share, motion] : found) motions.push_back(motion);
  return motions;
}

}  // namespace isopach
