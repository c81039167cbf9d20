// When ρ_V misleads and ρ_dV does not: detail_bench, writes the tables of docs/different-detail.md. One surface is
// scanned by a fine scanner (200 000 points) at three levels of noise and by a coarse one at four densities, once in
// place and once with the fine scan lifted by `bias`. Two surfaces: broad shapes with a texture, and the relief of
// `simulate`, which has waves of every length.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/simulate/sampling.hpp"
#include "isopach/simulate/scene.hpp"

namespace {

using namespace isopach;
using Relief = std::function<double(double, double)>;

constexpr double side = 300, bias = 0.1;
constexpr std::size_t fine_points = 200000;
constexpr std::array<std::size_t, 4> coarse_points{40000, 10000, 2500, 625};
constexpr std::array<double, 3> noises{0, 0.1, 0.3};

/// Broad shapes of more than 1 km, a texture of waves of 3 to 4 m, and nothing between.
double textured(double x, double y) {
  double z = 5 * std::sin(x / 200) * std::cos(y / 240);
  for (int i = 0; i < 8; ++i) {
    const double direction = i * std::numbers::pi * (3 - std::sqrt(5.0)), k = 2 * std::numbers::pi / (3 + i / 8.0);
    z += 0.1 * std::sin(k * (std::cos(direction) * x + std::sin(direction) * y) + i * i);
  }
  return z;
}

/// How a scanner makes one height: at a point, or as the mean over a spot as wide as its points are apart.
enum class Beam { point, spot };

double height(const Relief& f, const Point2& p, double radius) {
  if (radius == 0) return f(p.x, p.y);
  constexpr int rings = 96;  // sunflower: equal areas
  double sum = 0;
  for (int i = 0; i < rings; ++i) {
    const double r = radius * std::sqrt((i + 0.5) / rings), angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    sum += f(p.x + r * std::cos(angle), p.y + r * std::sin(angle));
  }
  return sum / rings;
}

Cloud scan(const Relief& f, std::size_t n, Beam beam, double noise, double lift, std::uint64_t number) {
  const double radius = beam == Beam::spot ? side / std::sqrt(static_cast<double>(n) * std::numbers::pi) : 0;
  const Array<Point2> nodes = bordered_nodes(rectangle({0, 0}, {side, side}), n, {1, number});
  const RandomStream random(1, 100 + number);
  Cloud cloud;
  cloud.unit = "m";
  cloud.points.resize(nodes.size());
  for_each_index(nodes.size(), [&](std::size_t i) {
    cloud.points[i] = {nodes[i].x, nodes[i].y, height(f, nodes[i], radius) + lift + noise * random.normal(i)};
  });
  return cloud;
}

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
