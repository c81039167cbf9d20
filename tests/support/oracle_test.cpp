// The oracles against each other and against cases worked by hand.
#include "tests/support/oracle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

TEST(ExactOrientation, SeesOneUlp) {
  const double up = std::nextafter(0.5, 1), down = std::nextafter(0.5, 0);
  EXPECT_EQ(exact_orientation({12, 12}, {24, 24}, {0.5, 0.5}), 0);
  EXPECT_EQ(exact_orientation({12, 12}, {24, 24}, {0.5, up}), 1);
  EXPECT_EQ(exact_orientation({12, 12}, {24, 24}, {0.5, down}), -1);
  EXPECT_EQ(exact_orientation({1e-300, 0}, {1e300, 1}, {0, 1e-300}), 1);
}

TEST(ExactInCircle, SeesOneUlp) {
  const Point2 a{1, 0}, b{0, 1}, c{-1, 0};
  EXPECT_EQ(exact_in_circle(a, b, c, {0, -1}), 0);
  EXPECT_EQ(exact_in_circle(a, b, c, {0, std::nextafter(-1.0, 0)}), 1);
  EXPECT_EQ(exact_in_circle(a, b, c, {0, std::nextafter(-1.0, -2)}), -1);
}

TEST(TiedInCircle, CutsTheGreatestCornerOffASquare) {
  const Point2 sw{0, 0}, se{1, 0}, ne{1, 1}, nw{0, 1};
  // ne is lifted, so it is the ear: triangles (sw, se, nw) and (se, ne, nw).
  EXPECT_FALSE(tied_in_circle(sw, se, nw, ne));
  EXPECT_FALSE(tied_in_circle(se, ne, nw, sw));
  EXPECT_TRUE(tied_in_circle(sw, se, ne, nw));
  EXPECT_TRUE(tied_in_circle(sw, ne, nw, se));
}

TEST(TiedInCircle, DecidesEveryQuadrilateralOneWay) {
  const Points p = cocircular(12, 1);
  for (std::size_t i = 0; i < 12; ++i)
    for (std::size_t j = 0; j < 12; ++j)
      for (std::size_t k = 0; k < 12; ++k)
        for (std::size_t l = 0; l < 12; ++l) {
          if (exact_orientation(p[i], p[j], p[k]) <= 0 || exact_orientation(p[i], p[k], p[l]) <= 0) continue;
          // Quadrilateral i j k l, counter-clockwise: exactly one of its two diagonals is right, seen from all sides.
          const bool diagonal_ik = !tied_in_circle(p[i], p[j], p[k], p[l]);
          EXPECT_EQ(diagonal_ik, !tied_in_circle(p[i], p[k], p[l], p[j]));
          EXPECT_EQ(diagonal_ik, tied_in_circle(p[i], p[j], p[l], p[k]));
          EXPECT_EQ(diagonal_ik, tied_in_circle(p[j], p[k], p[l], p[i]));
        }
}

TEST(BruteDelaunay, TilesTheHullForEveryFamily) {
  for (const Family& family : families()) {
    const Points points = distinct(family.make(30, 11));
    const std::vector<Triple> triangles = brute_delaunay(points);
    Points corners;
    std::set<std::array<std::size_t, 2>> sides;
    for (const Triple& t : triangles) {
      for (const std::size_t i : t) corners.push_back(points[i]);
      for (std::size_t k = 0; k < 3; ++k) {
        const bool is_new = sides.insert({t[k], t[(k + 1) % 3]}).second;
        EXPECT_TRUE(is_new) << family.name;
      }
    }
    const Points hull = brute_hull(points);
    EXPECT_EQ(exact_compare_areas(corners, hull), 0) << family.name;
    // Euler: 2n − 2 triangles when one ghost per hull edge is counted.
    std::size_t open = 0;
    for (const auto& side : sides) open += sides.count({side[1], side[0]}) == 0;
    if (!family.collinear) {
      EXPECT_EQ(triangles.size() + open, 2 * points.size() - 2) << family.name;
    }
  }
}

TEST(BruteHull, DropsPointsInsideEdges) {
  EXPECT_EQ(brute_hull({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 1}, {0, 1}}),
            (Points{{0, 0}, {2, 0}, {2, 2}, {0, 2}}));
}

TEST(ConvexIntersection, OfSquares) {
  const Points unit = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const Points shifted = {{0.5, 0.25}, {1.5, 0.25}, {1.5, 1.25}, {0.5, 1.25}};
  const Points diamond = {{0.5, 0}, {1, 0.5}, {0.5, 1}, {0, 0.5}};
  EXPECT_DOUBLE_EQ(static_cast<double>(convex_intersection_area(unit, shifted)), 0.375);
  EXPECT_DOUBLE_EQ(static_cast<double>(convex_intersection_area(unit, diamond)), 0.5);
  EXPECT_EQ(convex_intersection_area(unit, {{3, 3}, {4, 3}, {4, 4}}), 0);
}

TEST(PrimWeight, OfAGridIsItsNumberOfNodesLessOne) {
  EXPECT_DOUBLE_EQ(static_cast<double>(prim_weight(grid(100, 0))), 99);
  EXPECT_DOUBLE_EQ(static_cast<double>(prim_weight({{0, 0}, {3, 4}, {3, 5}})), 6);
  EXPECT_EQ(prim_weight({}), 0);
}

TEST(BruteLocate, TellsNodeEdgeTriangleAndOutside) {
  const Points points = {{0, 0}, {2, 0}, {0, 2}};
  const std::vector<Triple> triangles = brute_delaunay(points);
  using Ids = std::vector<std::size_t>;
  EXPECT_EQ(brute_locate(points, triangles, {2, 0}), (Ids{1}));
  EXPECT_EQ(brute_locate(points, triangles, {1, 0}), (Ids{0, 1}));
  EXPECT_EQ(brute_locate(points, triangles, {1, 1}), (Ids{1, 2}));
  EXPECT_EQ(brute_locate(points, triangles, {0.5, 0.5}), (Ids{0, 1, 2}));
  EXPECT_EQ(brute_locate(points, triangles, {1, std::nextafter(1.0, 2)}), Ids{});
}

TEST(BruteSurface, IsLinearInsideAndClampedOutside) {
  const BruteSurface surface = brute_surface({{0, 0}, {4, 0}, {4, 4}, {0, 4}, {1, 2}}, {0, 4, 12, 8, 5});  // x + 2y
  EXPECT_DOUBLE_EQ(static_cast<double>(*surface.at({3.5, 1.25})), 6);
  EXPECT_DOUBLE_EQ(static_cast<double>(*surface.at({4, 1})), 6);
  EXPECT_FALSE(surface.at({5, 1}).has_value());
  EXPECT_DOUBLE_EQ(static_cast<double>(surface.clamped_at({5, 1})), 6);
  EXPECT_DOUBLE_EQ(static_cast<double>(surface.clamped_at({6, 7})), 12);
}

TEST(BruteTriangleParts, OfHandWorkedTriangles) {
  const std::array<Point2, 3> p = {{{0, 0}, {1, 0}, {0, 1}}};
  const Parts positive = brute_triangle_parts(p, {1, 2, 3});
  EXPECT_DOUBLE_EQ(static_cast<double>(positive.above), 1);
  EXPECT_EQ(positive.below, 0);
  // d = x − 1/2: above on the corner triangle of legs 1/2, ∫ = 1/8 · 1/6.
  const Parts mixed = brute_triangle_parts(p, {-0.5L, 0.5L, -0.5L});
  EXPECT_NEAR(static_cast<double>(mixed.above), 1.0 / 48, 1e-17);
  EXPECT_NEAR(static_cast<double>(mixed.above - mixed.below), -0.5 / 6, 1e-16);
  EXPECT_DOUBLE_EQ(static_cast<double>(brute_area_between(p, {-0.5L, 0.5L, -0.5L}, 0, 1)), 0.125);
}

TEST(BruteCommonMeasure, OfLiftedAndTiltedPlanes) {
  const Points square = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {1, 2}, {2.5, 0.5}};
  const Points other = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {3, 3}, {0.5, 1}};
  const auto plane = [](const Points& points, double z0, double zx) {
    std::vector<double> z;
    for (const Point2& p : points) z.push_back(z0 + zx * p.x);
    return brute_surface(points, z);
  };
  const Parts lifted = brute_common_measure(plane(square, 1, 0.5), plane(other, 3, 0.5), false);
  EXPECT_DOUBLE_EQ(static_cast<double>(lifted.area), 16);
  EXPECT_DOUBLE_EQ(static_cast<double>(lifted.above), 32);
  EXPECT_EQ(lifted.below, 0);
  const Parts tilted = brute_common_measure(plane(square, 0, 0), plane(other, -2, 1), true);  // d = x − 2
  EXPECT_NEAR(static_cast<double>(tilted.above), 8, 1e-14);
  EXPECT_NEAR(static_cast<double>(tilted.below), 8, 1e-14);
}

}  // namespace
}  // namespace isopach::test
