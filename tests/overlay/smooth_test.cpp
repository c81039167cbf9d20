// The smooth surface reproduces cubics, is C1 across edges, passes through its nodes and does not swing at a cliff.
#include "isopach/overlay/smooth.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/overlay/localise.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

template <class F>
Array<double> heights(const Points& nodes, const Points& asked, F f, Points* order = nullptr, bool smooth = true) {
  const SortedTriangulation mesh = triangulate_unsorted(nodes, {}), points = triangulate_unsorted(asked, {});
  const Locations where = localise_in_order(points.xy, mesh.triangulation, mesh.xy, {});
  Array<double> z;
  for (const Point2& p : mesh.xy) z.push_back(f(p.x, p.y));
  if (order != nullptr) order->assign(points.xy.begin(), points.xy.end());
  const auto how = smooth ? interpolate_smooth : interpolate;
  return how(where, points.xy, mesh.triangulation, mesh.xy, z, {});
}

Points square(std::size_t n, std::uint64_t seed, double low, double high) {
  Random random(seed);
  Points points;
  for (std::size_t i = 0; i < n; ++i) points.push_back({random.uniform(low, high), random.uniform(low, high)});
  return points;
}

double cubic(double x, double y) {
  return 1 + x - 2 * y + 3 * x * x - x * y + y * y + 2 * x * x * x - x * x * y - y * y * y;
}
double wavy(double x, double y) { return std::sin(7 * x) * std::cos(5 * y + 1); }

TEST(Smooth, ReproducesCubicsInside) {
  Points order;
  const Array<double> z = heights(square(3000, 1, 0, 1), square(2000, 2, 0.15, 0.85), cubic, &order);
  for (std::size_t i = 0; i < z.size(); ++i) EXPECT_NEAR(z[i], cubic(order[i].x, order[i].y), 1e-10);
}

TEST(Smooth, ErrorFallsWithTheFourthPowerOfTheSpacing) {
  const auto error = [](std::size_t n, bool smooth) {
    Points order;
    const Array<double> z = heights(square(n, 3, 0, 1), square(1000, 4, 0.2, 0.8), wavy, &order, smooth);
    double sum = 0;
    for (std::size_t i = 0; i < z.size(); ++i) sum += std::fabs(z[i] - wavy(order[i].x, order[i].y));
    return sum;
  };
  EXPECT_GT(error(1000, true) / error(16000, true), 100);   // a fourth of the spacing: 256
  EXPECT_LT(error(1000, false) / error(16000, false), 32);  // chords: 16
  EXPECT_LT(error(16000, true), 0.05 * error(16000, false));
}

/// On either side of a line through the mesh, differences of values on three close points agree wherever it crosses
/// edges: a kink of chords would show as a jump of slope.
TEST(Smooth, HasNoKinksAcrossEdges) {
  const Points nodes = square(200, 5, 0, 1);
  const double step = 1e-5;
  const auto worst = [&](bool smooth) {
    double jump = 0;
    for (int row = 0; row < 3; ++row) {
      Points line, order;
      for (int i = 0; i < 40000; ++i) line.push_back({0.3 + step * i, 0.4 + 0.1 * row});
      Array<double> z = heights(nodes, line, wavy, &order, smooth);
      std::vector<std::pair<double, double>> sorted;
      for (std::size_t i = 0; i < z.size(); ++i) sorted.emplace_back(order[i].x, z[i]);
      std::sort(sorted.begin(), sorted.end());
      for (std::size_t i = 1; i + 1 < sorted.size(); ++i)
        jump = std::max(jump, std::fabs(sorted[i + 1].second - 2 * sorted[i].second + sorted[i - 1].second) / step);
    }
    return jump;
  };
  EXPECT_GT(worst(false), 0.1);
  EXPECT_LT(worst(true), 0.01);
}

TEST(Smooth, PassesThroughItsNodesAndKeepsCliffsInBounds) {
  const auto cliff = [](double x, double) { return x < 0.5 ? 0.0 : 30.0; };
  const Points nodes = square(2000, 6, 0, 1);
  Points order;
  const Array<double> own = heights(nodes, nodes, cliff, &order);
  for (std::size_t i = 0; i < own.size(); ++i) EXPECT_EQ(own[i], cliff(order[i].x, 0));
  for (const double z : heights(nodes, square(5000, 7, 0, 1), cliff)) EXPECT_TRUE(z >= -3.75 && z <= 33.75) << z;
}

TEST(Smooth, GridsLinesAndFewNodesAreFinite) {
  const auto plane = [](double x, double y) { return 2 * x - 3 * y + 1; };
  for (const int n : {2, 3, 4, 20}) {
    Points grid, order;
    for (int i = 0; i < n * n; ++i) grid.push_back({1e6 + i % n, -1e6 + i / n});
    Points asked;
    for (const Point2& p : square(200, 8, 0, n - 1)) asked.push_back({1e6 + p.x, -1e6 + p.y});
    const Array<double> z = heights(grid, asked, plane, &order);
    for (std::size_t i = 0; i < z.size(); ++i) EXPECT_NEAR(z[i], plane(order[i].x, order[i].y), 1e-7);
  }
  for (const double z : heights({{0, 0}, {1, 1}, {2, 2}}, {{0.5, 0.5}, {3, 0}, {1, 2}}, wavy))
    EXPECT_TRUE(std::isfinite(z));
}

TEST(Smooth, SameBitsForAnyNumberOfThreads) {
  Array<double> one, seven;
  run_with_threads(1, [&] { one = heights(square(20000, 1, 0, 1), square(9000, 2, 0, 1), wavy); });
  run_with_threads(7, [&] { seven = heights(square(20000, 1, 0, 1), square(9000, 2, 0, 1), wavy); });
  EXPECT_EQ(one, seven);
}

}  // namespace
}  // namespace isopach::test
