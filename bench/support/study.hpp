// The study of scans of different detail: a surface with a texture of 3 to 4 m, a fine scanner at three levels of
// noise, a coarse one at four densities, one lifted against the other. What detail_bench and scanners_bench share.
#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/simulate/sampling.hpp"

namespace isopach::bench {

using Relief = std::function<double(double, double)>;

inline constexpr double side = 300, bias = 0.1;
inline constexpr std::size_t fine_points = 200000;
inline constexpr std::array<std::size_t, 4> coarse_points{40000, 10000, 2500, 625};
inline constexpr std::array<double, 3> noises{0, 0.1, 0.3};

/// Broad shapes of more than 1 km, a texture of waves of 3 to 4 m, and nothing between.
inline double textured(double x, double y) {
  double z = 5 * std::sin(x / 200) * std::cos(y / 240);
  for (int i = 0; i < 8; ++i) {
    const double direction = i * std::numbers::pi * (3 - std::sqrt(5.0)), k = 2 * std::numbers::pi / (3 + i / 8.0);
    z += 0.1 * std::sin(k * (std::cos(direction) * x + std::sin(direction) * y) + i * i);
  }
  return z;
}

/// Of the disc that has the area that one of n points stands for.
inline double spot_radius(std::size_t n) { return side / std::sqrt(static_cast<double>(n) * std::numbers::pi); }

/// How a scanner makes one height: at a point, or as the mean over a spot as wide as its points are apart.
enum class Beam { point, spot };

inline double height(const Relief& f, const Point2& p, double radius) {
  if (radius == 0) return f(p.x, p.y);
  constexpr int rings = 96;  // sunflower: equal areas
  double sum = 0;
  for (int i = 0; i < rings; ++i) {
    const double r = radius * std::sqrt((i + 0.5) / rings), angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    sum += f(p.x + r * std::cos(angle), p.y + r * std::sin(angle));
  }
  return sum / rings;
}

inline Cloud scan(const Relief& f, std::size_t n, Beam beam, double noise, double lift, std::uint64_t number) {
  const double radius = beam == Beam::spot ? spot_radius(n) : 0;
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

}  // namespace isopach::bench
