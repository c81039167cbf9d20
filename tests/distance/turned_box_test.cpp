// Bounds of turned boxes against the distances to their triangles.
#include "isopach/distance/turned_box.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/distance/surface_tree.hpp"
#include "isopach/distance/vectors.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

using Corners = std::vector<std::array<Point3, 3>>;

Point3 in_cube(test::Random& random, double half) {
  return {random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half)};
}

/// Triangles with a corner in common, in an angle that `spread` is the width of, `far` from the origin.
Corners fan(std::size_t n, double spread, double rough, double far, std::uint64_t seed) {
  test::Random random(seed);
  const Point3 tip = far * in_cube(random, 1), along = in_cube(random, 1), aside = spread * in_cube(random, 1);
  std::vector<Point3> rim;
  for (std::size_t i = 0; i <= n; ++i)
    rim.push_back(tip + along + (static_cast<double>(i) / static_cast<double>(n)) * aside + in_cube(random, rough));
  Corners triangles;
  for (std::size_t i = 0; i < n; ++i)
    triangles.push_back(i % 2 == 0 ? std::array{tip, rim[i], rim[i + 1]} : std::array{rim[i], rim[i + 1], tip});
  return triangles;
}

double distance2(const Point3& p, const Corners& triangles) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& c : triangles) best = std::min(best, closest_on_triangle(p, c).distance2);
  return best;
}

/// Around the tip, around the rim, and farther away.
std::vector<Point3> places(const Corners& triangles, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Point3> all;
  for (int i = 0; i < 40; ++i)
    for (const double size : {1e-6, 1e-2, 1.0, 100.0})
      for (const Point3& corner : triangles[random.below(triangles.size())])
        all.push_back(corner + in_cube(random, size));
  return all;
}

TEST(TurnedBox, BoundIsBelowTheDistanceOfFans) {
  std::size_t at_tip = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
    for (const double far : {0.0, 1.0, 1e6}) {
      const double spread = std::pow(10, -static_cast<double>(seed % 7)), rough = seed % 2 == 0 ? 0 : spread / 10;
      const Corners triangles = fan(1 + seed % 9, spread, rough, far, seed);
      const TurnedBox box(triangles);
      for (const Point3& p : places(triangles, seed + 100)) {
        const TurnedBox::Bound bound = box.bound(p);
        const double distance = std::sqrt(distance2(p, triangles)), rounding = 1e-14 * (1 + far);
        ASSERT_LE(std::sqrt(bound.distance2), distance + rounding) << seed << ' ' << far;
        if (!bound.at_tip) continue;
        ++at_tip;
        ASSERT_NEAR(length(p - box.tip()), distance, rounding);
      }
    }
  EXPECT_GT(at_tip, 1000u);
}

TEST(TurnedBox, BoundIsBelowTheDistanceOfAnyTriangles) {
  test::Random random(5);
  for (int i = 0; i < 300; ++i) {
    Corners triangles(1 + random.below(5));
    const double thin = std::pow(10, -static_cast<double>(random.below(12)));
    for (auto& c : triangles) {
      c[0] = in_cube(random, 1), c[1] = in_cube(random, 1);
      c[2] = random.below(5) == 0 ? c[1] : c[1] + in_cube(random, thin);
    }
    const TurnedBox box(triangles);
    for (const Point3& p : places(triangles, random.bits()))
      ASSERT_LE(std::sqrt(box.bound(p).distance2), std::sqrt(distance2(p, triangles)) + 1e-14);
  }
}

TEST(TurnedBox, OfAFlatFanTheBoundIsTheDistanceBesideIt) {
  Corners triangles;
  for (int i = 0; i < 20; ++i) triangles.push_back({Point3{0, 0, 0}, {10, 0.01 * i, 0}, {10, 0.01 * (i + 1), 0}});
  const TurnedBox box(triangles);
  ASSERT_TRUE(box.is_fan());
  for (const double y : {-1.0, -1e-3, -1e-9, 0.3, 1.0})
    for (const double z : {0.0, 0.4}) {
      const Point3 p{3, y, z};
      EXPECT_NEAR(std::sqrt(box.bound(p).distance2), std::sqrt(distance2(p, triangles)), 1e-4 * std::fabs(y) + 1e-12);
    }
  EXPECT_TRUE(box.bound({-1, 0, 0}).at_tip);
  EXPECT_TRUE(box.bound({-1e-6, 0, 0}).at_tip);
  EXPECT_FALSE(box.bound({1e-6, 1e-7, 0}).at_tip);
}

TEST(TurnedBox, OfATriangleInOnePlace) {
  const Corners triangles{{Point3{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}};
  const TurnedBox box(triangles);
  EXPECT_NEAR(box.bound({1, 2, 5}).distance2, 4, 1e-12);
  EXPECT_EQ(box.bound({1, 2, 3}).distance2, 0);
}

}  // namespace
}  // namespace isopach
