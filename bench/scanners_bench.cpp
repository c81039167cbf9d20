// What `scanners` finds of two scanners whose errors are known: scanners_bench, writes the table of
// docs/use/scanners.md. The study of scans of different detail (detail_bench): a surface with a texture of 3 to 4 m. A
// is the fine scanner (200 000 points), B a coarse one at four densities; both have the noise of the row, B is lifted
// by `bias`. B's heights are means over a spot as wide as its points are apart, or those of points. The reference has
// 400 000 points and no noise.
#include <fmt/format.h>

#include <cstdio>

#include "bench/support/study.hpp"
#include "isopach/apps/scanners.hpp"

namespace {

using namespace isopach;
using namespace isopach::bench;

void table(Beam beam) {
  const Cloud reference = scan(textured, 400000, Beam::point, 0, 0, 3);
  ScannersOptions options;
  options.align = false;
  options.match.compare.check_layers = false;
  fmt::print(
      "| points of B | noise of both | noise found, A | noise found, B | without its spot | spot of B | spot found | "
      "bias of B found | A resolves | B resolves |\n|---|---|---|---|---|---|---|---|---|---|\n");
  const auto resolved = [](const Scanner& s) {
    return s.resolved > 0 ? fmt::format("{:.2g} m", s.resolved) : std::string("–");
  };
  for (const std::size_t n : coarse_points)
    for (const double noise : noises) {
      const Cloud a = scan(textured, fine_points, Beam::point, noise, 0, 2),
                  b = scan(textured, n, beam, noise, bias, 1);
      const Scanners s = scanners(a, b, reference, options, {});
      const double width = beam == Beam::spot ? 2 * spot_radius(n) : 0;
      fmt::print("| {} | {:g} m | {:.3f} m | {:.3f} m | {:.3f} m | {:.2f} m | {:.2f} m | {:+.3f} m | {} | {} |\n", n,
                 noise, s.scan[0].spot.noise, s.scan[1].spot.noise, s.scan[1].residuals.noise, width,
                 s.scan[1].spot.width, s.scan[1].residuals.bias, resolved(s.scan[0]), resolved(s.scan[1]));
      std::fflush(stdout);
    }
}

}  // namespace

int main() {
  fmt::print("B is lifted by {:g} m. Each height of B the mean over a spot:\n\n", bias);
  table(Beam::spot);
  fmt::print("\nEach height of B that of one point:\n\n");
  table(Beam::point);
  return 0;
}
