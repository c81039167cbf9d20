// What cubic interpolation is worth and what it costs: smooth_bench [LARGEST] writes the table of
// docs/method/smooth.md. Scenes of `simulate relief` with known volumes, N points a scan, no noise, seed 1. Errors
// against the truth, over the hulls, whose nodes are as dense as those inside. Time: CPU time of one thread, medians of
// three, over that of linear.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <string>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/simulate/scene.hpp"

namespace {

using namespace isopach;

struct Run {
  Comparison c;
  double seconds = 0;
};

Run run(const Scene& scene, Interpolation interpolation) {
  CompareOptions options;
  options.border = BorderRule::hull;
  options.interpolation = interpolation;
  Run r;
  std::array<double, 3> times{};
  for (double& time : times) {
    const std::clock_t start = std::clock();
    r.c = compare(scene.a, scene.b, options, {});
    time = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  }
  std::sort(times.begin(), times.end());
  r.seconds = times[1];
  return r;
}

void table(const std::string& variant, std::size_t n) {
  SceneOptions o;
  o.points_a = o.points_b = n;
  o.noise_a = o.noise_b = 0;
  o.variant = variant;
  const Scene scene = make_scene("relief", o, {});
  const Truth& truth = scene.truth;
  const double gross = truth.above + truth.below;
  const Run linear = run(scene, Interpolation::linear), cubic = run(scene, Interpolation::cubic);
  for (const auto& [name, r] : {std::pair{"linear", &linear}, std::pair{"cubic", &cubic}}) {
    const Volume& v = r->c.measures.volume;
    const double integral = r->c.measures.error_estimate * r->c.domain_area / gross;
    fmt::print("| `{}` | {} | {} | {:+.1e} | {:+.1e} | {:+.1e} | {:+.1e} | {} | {:.1f} |\n", variant, n, name,
               v.above / truth.above - 1, v.below / truth.below - 1, v.net / truth.net - 1, v.absolute / gross - 1,
               integral > 0 ? fmt::format("{:.0e}", integral) : "0", r->seconds / linear.seconds);
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t largest = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1'000'000;
  fmt::print(
      "| variant | N | interpolation | gained | lost | net | gross | `error_estimate` / gross | time |\n"
      "|---|--:|---|--:|--:|--:|--:|--:|--:|\n");
  run_with_threads(1, [&] {
    for (const char* variant : {"smooth", "rough", "cliff"})
      for (const std::size_t n : {10'000, 100'000, 1'000'000})
        if (n <= largest) table(variant, n);
  });
  return 0;
}
