#include "tests/support/points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

std::size_t square_side(std::size_t n) {
  std::size_t side = static_cast<std::size_t>(std::sqrt(static_cast<double>(n)));
  while (side * side > n) --side;
  return side;
}

Points in_rectangle(std::size_t n, std::uint64_t seed, Point2 min, Point2 size) {
  Random random(seed);
  Points points(n);
  for (Point2& p : points) {
    p.x = min.x + size.x * random.uniform();
    p.y = min.y + size.y * random.uniform();
  }
  return points;
}

/// Distinct integers in random order: random gaps, then a shuffle.
std::vector<double> random_integers(std::size_t n, Random& random) {
  std::vector<double> values(n);
  double value = 0;
  for (double& v : values) v = value += static_cast<double>(1 + random.below(4));
  random.shuffle(values);
  return values;
}

struct Gaussian {
  std::int64_t re, im;
};
Gaussian operator*(Gaussian a, Gaussian b) { return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }

/// All integer points at distance p1·p2·…·pk from the origin, where p_i = |z_i|² are primes of the form 4m + 1: the
/// products of z_i², z_i·z̄_i, z̄_i² and a unit. 4·3^k of them.
Points circle_points(int primes) {
  constexpr Gaussian roots[7] = {{2, 1}, {3, 2}, {4, 1}, {5, 2}, {6, 1}, {5, 4}, {7, 2}};  // 5 13 17 29 37 41 53
  std::vector<Gaussian> found = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  for (int i = 0; i < primes; ++i) {
    const Gaussian z = roots[i], conjugate = {z.re, -z.im};
    std::vector<Gaussian> next;
    for (const Gaussian g : found)
      for (const Gaussian factor : {z * z, z * conjugate, conjugate * conjugate}) next.push_back(g * factor);
    found = std::move(next);
  }
  Points points;
  for (const Gaussian g : found) points.push_back({static_cast<double>(g.re), static_cast<double>(g.im)});
  return points;
}

}  // namespace

Points uniform(std::size_t n, std::uint64_t seed) { return in_rectangle(n, seed, {0, 0}, {1, 1}); }

Points sorted_by_x(std::size_t n, std::uint64_t seed) {
  Points points = uniform(n, seed);
  std::sort(points.begin(), points.end(), lexicographic_less);
  return points;
}

Points grid(std::size_t n, std::uint64_t) {
  const std::size_t side = square_side(n);
  Points points;
  for (std::size_t row = 0; row < side; ++row)
    for (std::size_t column = 0; column < side; ++column)
      points.push_back({static_cast<double>(column), static_cast<double>(row)});
  return points;
}

Points rotated_grid(std::size_t n, std::uint64_t seed) {
  Points points = grid(n, seed);
  const double c = std::sqrt(3.0) / 2, s = 0.5;
  for (Point2& p : points) p = {c * p.x - s * p.y, s * p.x + c * p.y};
  return points;
}

Points near_degenerate(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Points points = grid(n, seed);
  const auto nudge = [&](double x) {
    const std::size_t way = random.below(3);
    if (way == 0) return x;
    return std::nextafter(x, way == 1 ? x - 1 : x + 1);
  };
  for (Point2& p : points) p = {nudge(p.x + 1), nudge(p.y + 1)};
  return points;
}

Points horizontal(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Points points(n);
  for (Point2& p : points) p = {random.uniform(), 0.3};
  return points;
}

Points vertical(std::size_t n, std::uint64_t seed) {
  Points points = horizontal(n, seed);
  for (Point2& p : points) p = {p.y, p.x};
  return points;
}

Points diagonal(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Points points;
  for (const double x : random_integers(n, random)) points.push_back({x, 3 * x});
  return points;
}

Points nearly_diagonal(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Points points;
  for (const double x : random_integers(n, random)) points.push_back({x, x / 3});
  return points;
}

Points few_lines(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Points points;
  const std::vector<double> along = random_integers(n, random);
  for (std::size_t i = 0; i < n; ++i) {
    const double t = along[i];
    points.push_back(i % 4 == 3 ? Point2{0, t} : Point2{t, static_cast<double>(7 * (i % 4))});
  }
  return points;
}

Points cocircular(std::size_t n, std::uint64_t seed) {
  int primes = 1;
  for (std::size_t count = 12; count < n && primes < 7; count *= 3) ++primes;
  Points points = circle_points(primes);
  Random random(seed);
  random.shuffle(points);
  points.resize(std::min(n, points.size()));
  return points;
}

Points concentric(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  const Points circle = circle_points(n > 2000 ? 3 : 1);
  Points points;
  for (std::size_t k = 1; points.size() < n; ++k)
    for (const Point2& p : circle) points.push_back({static_cast<double>(k) * p.x, static_cast<double>(k) * p.y});
  points.resize(n);
  random.shuffle(points);
  return points;
}

Points clustered(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Points centres = in_rectangle(10, seed + 1, {0, 0}, {1000, 1000});
  Points points(n);
  for (Point2& p : points) {
    const std::size_t k = random.below(centres.size());
    const double width = std::ldexp(64.0, -3 * static_cast<int>(k));
    p.x = centres[k].x + width * random.bell();
    p.y = centres[k].y + width * random.bell();
  }
  return points;
}

Points scan_lines(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  const std::size_t per_line = 1 + square_side(n);
  const auto rounded = [](double x) { return std::round(x * 100) / 100; };
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0 && random.below(100) == 0) {
      points.push_back(points[random.below(i)]);
      continue;
    }
    const std::size_t line = i / per_line, step = i % per_line;
    const double across = static_cast<double>(line % 2 == 0 ? step : per_line - 1 - step) * 0.5;
    points.push_back({rounded(1000 + across + 0.02 * random.bell()),
                      rounded(2000 + static_cast<double>(line) * 0.7 + across * 0.05 + 0.02 * random.bell())});
  }
  return points;
}

Points far_outlier(std::size_t n, std::uint64_t seed) {
  Points points = uniform(n, seed);
  if (!points.empty()) points[n / 2] = {1e6, 1e6};
  return points;
}

Points utm(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Points points(n);
  for (Point2& p : points) {
    p.x = (6e8 + static_cast<double>(random.below(1000000))) / 1000;
    p.y = (5e9 + static_cast<double>(random.below(1000000))) / 1000;
  }
  return points;
}

Points thin_strip(std::size_t n, std::uint64_t seed) { return in_rectangle(n, seed, {-500, 3}, {1000, 1}); }
Points huge(std::size_t n, std::uint64_t seed) { return in_rectangle(n, seed, {-5e5, -5e5}, {1e6, 1e6}); }
Points tiny(std::size_t n, std::uint64_t seed) { return in_rectangle(n, seed, {0, 0}, {1e-6, 1e-6}); }

Points coarse_lattice(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  const std::size_t side = 2 + square_side(n);
  Points points(n);
  for (Point2& p : points) {
    p.x = static_cast<double>(random.below(side));
    p.y = static_cast<double>(random.below(side));
  }
  return points;
}

const std::vector<Family>& families() {
  static const std::vector<Family> all = {{"uniform", uniform},
                                          {"sorted_by_x", sorted_by_x},
                                          {"grid", grid},
                                          {"rotated_grid", rotated_grid},
                                          {"near_degenerate", near_degenerate},
                                          {"horizontal", horizontal, true},
                                          {"vertical", vertical, true},
                                          {"diagonal", diagonal, true},
                                          {"nearly_diagonal", nearly_diagonal},
                                          {"few_lines", few_lines},
                                          {"cocircular", cocircular},
                                          {"concentric", concentric},
                                          {"clustered", clustered},
                                          {"scan_lines", scan_lines},
                                          {"far_outlier", far_outlier},
                                          {"utm", utm},
                                          {"thin_strip", thin_strip},
                                          {"huge", huge},
                                          {"tiny", tiny},
                                          {"coarse_lattice", coarse_lattice}};
  return all;
}

Points distinct(Points points) {
  std::sort(points.begin(), points.end(), lexicographic_less);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

}  // namespace isopach::test
