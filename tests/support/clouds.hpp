// Clouds made of points in the plane and a height over each.
#pragma once
#include <functional>
#include <span>

#include "isopach/cloud/cloud.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {

using Height = std::function<double(const Point2&)>;

[[nodiscard]] inline Cloud cloud_over(const Points& xy, const Height& z) {
  Cloud cloud;
  for (const Point2& p : xy) cloud.points.push_back({p.x, p.y, z(p)});
  return cloud;
}

/// Heights in [−1, 1), a new one for every point.
[[nodiscard]] inline Cloud rough_cloud(const Points& xy, std::uint64_t seed) {
  Random random(seed);
  return cloud_over(xy, [&](const Point2&) { return random.uniform(-1, 1); });
}

/// n uniform points in the unit square and a frame of points along its border, so that the hull is the square.
[[nodiscard]] inline Points framed_square(std::size_t n, std::uint64_t seed) {
  Points points = uniform(n, seed);
  const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(n)));
  for (std::size_t i = 0; i < side; ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(side);
    points.insert(points.end(), {{s, 0}, {1, s}, {1 - s, 1}, {0, 1 - s}});
  }
  return points;
}

[[nodiscard]] inline Cloud shifted(Cloud cloud, const Point3& by) {
  for (Point3& p : cloud.points) p = {p.x + by.x, p.y + by.y, p.z + by.z};
  return cloud;
}

[[nodiscard]] inline Cloud shuffled(Cloud cloud, std::uint64_t seed) {
  std::vector<Point3> points(cloud.points.begin(), cloud.points.end());
  Random(seed).shuffle(points);
  cloud.points.assign(points.begin(), points.end());
  return cloud;
}

}  // namespace isopach::test
