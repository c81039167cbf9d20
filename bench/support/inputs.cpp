#include "bench/support/inputs.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/random.hpp"

namespace isopach::bench {
namespace {

Points in_rectangle(std::size_t n, std::uint64_t seed, const Point2& min, const Point2& size) {
  const RandomStream x(seed, 1), y(seed, 2);
  Points points(n);
  for (std::size_t i = 0; i < n; ++i) points[i] = {min.x + size.x * x.uniform(i), min.y + size.y * y.uniform(i)};
  return points;
}

double rounded(double x, double steps) { return std::round(x * steps) / steps; }

}  // namespace

Points uniform(std::size_t n, std::uint64_t seed) { return in_rectangle(n, seed, {0, 0}, {1, 1}); }

Points scan_lines(std::size_t n, std::uint64_t seed) {
  const RandomStream noise(seed, 3);
  const auto per_line = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(n))));
  const double step = 1000.0 / static_cast<double>(per_line);
  Points points(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (i % 100 == 99) {
      points[i] = points[i - 1];
      continue;
    }
    const double along = static_cast<double>(i % per_line) + 0.2 * noise.uniform(2 * i);
    const double across = static_cast<double>(i / per_line) + 0.2 * noise.uniform(2 * i + 1);
    points[i] = {rounded(along * step, 100), rounded(across * step, 100)};
  }
  return points;
}

Points grid(std::size_t n, std::uint64_t) {
  const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(n)));
  Points points(side * side);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {static_cast<double>(i % side), static_cast<double>(i / side)};
  return points;
}

Points clustered(std::size_t n, std::uint64_t seed) {
  constexpr std::size_t bells = 100;
  const RandomStream centre(seed, 4), which(seed, 5), x(seed, 6), y(seed, 7);
  Points points(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint64_t bell = which.bits(i) % bells;
    const double sigma = 1e-4 * std::pow(300.0, static_cast<double>(bell) / (bells - 1));
    points[i] = {centre.uniform(2 * bell) + sigma * x.normal(i), centre.uniform(2 * bell + 1) + sigma * y.normal(i)};
  }
  return points;
}

Points rotated_grid(std::size_t n, std::uint64_t seed) {
  Points points = grid(n, seed);
  const double c = std::sqrt(3.0) / 2, s = 0.5;
  for (Point2& p : points) p = {c * p.x - s * p.y, s * p.x + c * p.y};
  return points;
}

Points utm(std::size_t n, std::uint64_t seed) {
  Points points = in_rectangle(n, seed, {600000, 5000000}, {1000, 1000});
  for (Point2& p : points) p = {rounded(p.x, 1000), rounded(p.y, 1000)};
  return points;
}

Points strip(std::size_t n, std::uint64_t seed) { return in_rectangle(n, seed, {0, 0}, {1000, 1}); }

Points outlier(std::size_t n, std::uint64_t seed) {
  Points points = uniform(n, seed);
  points.back() = {1e6, 1e6};
  return points;
}

Points sorted_by_x(std::size_t n, std::uint64_t seed) {
  Points points = uniform(n, seed);
  std::sort(points.begin(), points.end(), lexicographic_less);
  return points;
}

Points few_lines(std::size_t n, std::uint64_t seed) {
  const RandomStream x(seed, 8);
  Points points(n);
  for (std::size_t i = 0; i < n; ++i) points[i] = {x.uniform(i), 0.1 * static_cast<double>(i % 10)};
  return points;
}

Points doubled(std::size_t n, std::uint64_t seed) {
  Points points = uniform(n, seed);
  for (std::size_t i = 99; i < n; i += 100) points[i] = points[i - 50];
  return points;
}

const std::vector<Family>& main_families() {
  static const std::vector<Family> families = {
      {"uniform", uniform}, {"scan lines", scan_lines}, {"regular grid", grid}, {"clustered", clustered}};
  return families;
}

const std::vector<Family>& cliff_families() {
  static const std::vector<Family> families = {{"grid turned by 30°", rotated_grid},
                                               {"UTM, millimetres", utm},
                                               {"strip 1:1000", strip},
                                               {"outlier 10⁶ extents away", outlier},
                                               {"sorted by x", sorted_by_x},
                                               {"1 % duplicates", doubled},
                                               {"on ten lines", few_lines}};
  return families;
}

Cloud surface_scan(std::size_t n, std::uint64_t seed, int epoch) {
  const Points xy = uniform(n, seed);
  Cloud cloud;
  cloud.points.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double base = 0.02 * std::sin(17 * xy[i].x) * std::cos(12 * xy[i].y);
    cloud.points[i] = {xy[i].x, xy[i].y, base + (epoch == 2 ? 0.01 * (xy[i].x - 0.25) : 0)};
  }
  return cloud;
}

}  // namespace isopach::bench
