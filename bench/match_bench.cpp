// What matching costs: match_bench [POINTS]. See docs/use/match.md.
//   stages: of a face (5 degrees, 3 % of its extent, 30 % of each scan unmatched), medians of five runs, two threads;
//   iteration: one evaluation of all residuals after a small step, one thread, per node of the moving scan.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "isopach/base/parallel.hpp"
#include "isopach/match/match.hpp"
#include "isopach/match/surface/residuals.hpp"
#include "isopach/match/surface/surface.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/match/poses.hpp"

namespace isopach {
namespace {

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

Scene face(std::size_t n) {
  SceneOptions o;
  o.points_a = o.points_b = n;
  o.noise_a = o.noise_b = 0.05;
  return make_scene("face", o, {});
}

struct Extent {
  double min, max;
};
Extent extent_x(const Cloud& cloud) {
  Extent e{1e300, -1e300};
  for (const Point3& p : cloud.points) e.min = std::min(e.min, p.x), e.max = std::max(e.max, p.x);
  return e;
}

Cloud between(const Cloud& cloud, double from, double to) {
  Cloud part;
  for (const Point3& p : cloud.points)
    if (p.x >= from && p.x <= to) part.points.push_back(p);
  return part;
}

void time_stages(std::size_t n, bool judge) {
  Scene s = face(n);
  const Extent e = extent_x(s.a);
  const double length = 236;  // of the face
  s.a = between(s.a, e.min, e.min + 0.77 * (e.max - e.min));
  s.b = between(s.b, e.max - 0.77 * (e.max - e.min), e.max);
  const Point3 middle = test::middle_of(s.b);
  const Pose away = test::turn_and_shift({1, 2, 3}, 5, middle, {0.02 * length, 0.02 * length, 0.01 * length});
  const Cloud moving = test::posed(s.b, away);
  MatchOptions options;
  options.compare.check_layers = false;
  options.judge = judge;
  std::vector<Timing> runs;
  std::vector<double> totals, processor;
  test::PoseError error{};
  int iterations = 0;
  for (int i = 0; i < 5; ++i) {
    Context context;
    context.threads = 2;
    const double start = seconds();
    const Matching m = match(moving, s.a, options, context);
    processor.push_back(seconds() - start);
    runs.push_back(m.timing);
    totals.push_back(m.timing.total);
    error = test::off_identity(test::chained(m.pose, away), middle);
    iterations = m.iterations;
  }
  fmt::print(
      "face, {} and {} points: {:.3f} s ({:.3f} s of the processor), {} steps, error {:.5f} degrees, {:.2e} of the "
      "extent\n",
      moving.points.size(), s.a.points.size(), median(totals), median(processor), iterations, error.degrees,
      error.shift / length);
  for (std::size_t k = 0; k < runs[0].stages.size(); ++k) {
    std::vector<double> times;
    for (const Timing& t : runs) times.push_back(t.stages[k].second);
    fmt::print("  {:<10} {:.3f} s\n", runs[0].stages[k].first, median(times));
  }
}

MatchSurface surface_of(const Cloud& cloud, const Frame& frame) {
  HeightField f = project(cloud, Pose{}, frame, ProjectOptions{}, Context{});
  return make_surface(std::move(f.xy), std::move(f.z), frame.curve, true, 0, Context{});
}

void time_iterations(const std::string& name, const Cloud& a, const Cloud& b, const Context& context) {
  const Frame frame = choose_frame(a, b, Pose{}, ProjectOptions{}, context);
  const MatchSurface fixed = surface_of(a, frame), moving = surface_of(b, frame);
  Residuals residuals(moving, fixed, Point3{0, 0, 0}, 50);
  const Loss loss{Loss::Kind::tukey, 0.1};
  (void)residuals.evaluate(Motion{}, loss, context);
  std::vector<double> times;
  std::uint64_t visited = 0;
  double fitted = 0;
  for (int i = 1; i <= 9; ++i) {
    Motion motion;
    motion.shift = Point3{0.02 * i, -0.01 * i, 0.001 * i};
    const double start = seconds();
    const ResidualSums sums = residuals.evaluate(motion, loss, context);
    times.push_back(seconds() - start);
    visited = sums.visited;
    fitted = sums.fitted / sums.area;
  }
  const auto nodes = static_cast<double>(moving.xy.size()), all = nodes + static_cast<double>(fixed.xy.size());
  fmt::print(
      "{}: {:.0f} ns per moving node and iteration ({} moving, {} fixed nodes, {:.2f} triangles a node, {:.2f} "
      "fitted)\n",
      name, 1e9 * median(times) / nodes, moving.xy.size(), fixed.xy.size(), static_cast<double>(visited) / all, fitted);
}

void iteration(const std::string& name, const Cloud& a, const Cloud& b) {
  Context one;
  one.threads = 1;
  const std::function<void()> work = std::bind(time_iterations, name, std::cref(a), std::cref(b), std::cref(one));
  run_with_threads(1, work);
}

}  // namespace
}  // namespace isopach

int main(int argc, char** argv) {
  using namespace isopach;
  const auto n = static_cast<std::size_t>(argc > 1 ? std::atof(argv[1]) : 2e5);
  const Scene s = face(n);
  iteration("face", s.a, s.b);
  SceneOptions o;
  o.points_a = o.points_b = n;
  o.noise_a = o.noise_b = 0.07, o.variant = "unchanged";
  const Scene r = make_scene("relief", o, {});
  iteration("relief", r.a, r.b);
  time_stages(n, true);
  time_stages(n, false);
  return 0;
}
