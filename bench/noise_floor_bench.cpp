// What the noise floor says where the truth is known: noise_floor_bench [LARGEST], writes the table of
// docs/evidence/noise-floor.md. Scenes of `simulate`, 10⁴ to LARGEST points, three seeds (one from 10⁶ on): means, and
// the worst seed. Share of time: CPU time of the comparison with the floor over that without it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "isopach/compare/compare.hpp"
#include "isopach/simulate/scene.hpp"

namespace {

using namespace isopach;

struct Case {
  std::string scene, variant;
  double share_b, noise;  // points of B as a share of those of A; standard deviation of the heights
};

const std::vector<Case> cases{{"relief", "unchanged", 1, 0},
                              {"relief", "unchanged", 1, 0.05},
                              {"relief", "unchanged", 0.3, 0},
                              {"relief", "unchanged", 3, 0.05},
                              {"relief", "rough", 1, 0},
                              {"relief", "rough", 1, 0.05},
                              {"relief", "rough", 0.3, 0},
                              {"relief", "rough", 3, 0.05},
                              {"relief", "smooth", 1, 0},
                              {"relief", "smooth", 1, 0.05},
                              {"relief", "smooth", 1, 0.5},
                              {"terrain", "", 1, 0.03},
                              {"face", "", 1, 0.1},
                              {"cone", "", 1, 0.05},
                              {"plane", "tilted", 1, 0.05}};

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Row {
  double raw = 0, floor = 0, debiased = 0, truth = 0, worst = 0, time = 0;
};

Row run(const Case& c, double n, int seeds) {
  Row row;
  for (int seed = 1; seed <= seeds; ++seed) {
    Context context;
    context.seed = static_cast<std::uint64_t>(seed);
    SceneOptions o;
    o.points_a = static_cast<std::size_t>(n), o.points_b = static_cast<std::size_t>(c.share_b * n);
    o.noise_a = o.noise_b = c.noise;
    o.variant = c.variant;
    const Scene scene = make_scene(c.scene, o, context);
    CompareOptions options;
    const double start = seconds();
    (void)compare(scene.a, scene.b, options, context);
    const double middle = seconds();
    options.noise_floor = true;
    const Comparison found = compare(scene.a, scene.b, options, context);
    row.time += (seconds() - middle) / (middle - start) / seeds;
    const double floor = found.noise_floor->above + found.noise_floor->below;
    const double truth = scene.truth.above + scene.truth.below, debiased = found.noise_floor->debiased.absolute;
    row.raw += found.measures.volume.absolute / seeds;
    row.floor += floor / seeds;
    row.debiased += debiased / seeds;
    row.truth = truth;
    const double off = truth > 0 ? debiased / truth - 1 : floor / found.measures.volume.absolute - 1;
    if (std::fabs(off) > std::fabs(row.worst)) row.worst = off;
  }
  return row;
}

std::string percent(double part, double whole) {
  return whole > 0 ? fmt::format("{:+.2f} %", 100 * (part / whole - 1)) : "–";
}

}  // namespace

int main(int argc, char** argv) {
  const double largest = argc > 1 ? std::atof(argv[1]) : 1e6;
  fmt::print(
      "| scene | nodes of A, of B | noise | raw gross | floor / raw | debiased gross | worst seed | time |\n"
      "|---|---|---|---|---|---|---|---|\n");
  for (double n = 1e4; n <= largest; n *= 10)
    for (const Case& c : cases) {
      const bool is_large = n > 3e5;
      if (is_large && (c.scene != "relief" || c.share_b > 1)) continue;
      const Row row = run(c, n, is_large ? 1 : 3);
      fmt::print("| {} | {:.0e}, {:.0e} | {:g} | {} | {:.3f} | {} | {:+.2f} % | {:.1f} |\n",
                 c.scene + (c.variant.empty() ? "" : " " + c.variant), n, c.share_b * n, c.noise,
                 percent(row.raw, row.truth), row.floor / row.raw, percent(row.debiased, row.truth), 100 * row.worst,
                 row.time);
      std::fflush(stdout);
    }
  return 0;
}
