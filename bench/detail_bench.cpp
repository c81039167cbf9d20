// When ρ_V misleads and ρ_dV does not: detail_bench, writes the tables of docs/method/different-detail.md. One surface
// is scanned by a fine scanner (200 000 points) at three levels of noise and by a coarse one at four densities, once in
// place and once with the fine scan lifted by `bias`. Two surfaces: broad shapes with a texture, and the relief of
// `simulate`, which has waves of every length.
#include <fmt/format.h>

#include <cstdio>

#include "bench/support/study.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/simulate/scene.hpp"

namespace {

using namespace isopach;
using namespace isopach::bench;

struct Found {
  double rho, rho_dv, mean;
};
Found compared(const Cloud& coarse, const Cloud& fine) {
  CompareOptions options;
  options.check_layers = false;
  const Comparison c = compare(coarse, fine, options, {});
  return {c.measures.rho, c.detail->rho, c.detail->mean};
}

void table(const Relief& f, Beam beam) {
  fmt::print(
      "| points of the coarse scan | noise of the fine scan | ρ_V unchanged | ρ_V lifted | ratio | ρ_dV unchanged | "
      "ρ_dV "
      "lifted | ratio |\n|---|---|---|---|---|---|---|---|\n");
  for (const std::size_t n : coarse_points)
    for (const double noise : noises) {
      const Cloud coarse = scan(f, n, beam, 0, 0, 1);
      const Found same = compared(coarse, scan(f, fine_points, Beam::point, noise, 0, 2));
      const Found lifted = compared(coarse, scan(f, fine_points, Beam::point, noise, bias, 2));
      fmt::print("| {} | {:g} m | {:.3f} m | {:.3f} m | {:.2f} | {:.3f} m | {:.3f} m | {:.2f} |\n", n, noise, same.rho,
                 lifted.rho, lifted.rho / same.rho, same.rho_dv, lifted.rho_dv, lifted.rho_dv / same.rho_dv);
      std::fflush(stdout);
    }
}

}  // namespace

int main() {
  fmt::print("The fine scan is lifted by {:g} m.\n\nTextured, each coarse height the mean over a spot:\n\n", bias);
  table(textured, Beam::spot);
  fmt::print("\nTextured, each coarse height that of one point:\n\n");
  table(textured, Beam::point);
  fmt::print("\nRelief with waves of every length from 22 m to 1 km, each coarse height the mean over a spot:\n\n");
  table(scene_surface("relief", "unchanged", 1), Beam::spot);
  return 0;
}
