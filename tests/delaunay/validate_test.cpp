// The validator refuses what it should: each kind of damage, made by hand.
#include "isopach/delaunay/validate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/delaunay/triangulate.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"

namespace isopach::test {
namespace {

bool accepted(const Triangulation& t, const Points& points) { return !validate(t, points).has_value(); }

const Points square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};

TEST(Validate, AcceptsTheTriangulationMadeByBruteForce) {
  for (const Family& family : families()) {
    if (family.collinear) continue;
    const Points points = distinct(family.make(25, 61));
    const Triangulation t = from_triples(brute_delaunay(points), points.size());
    EXPECT_EQ(validate(t, points).value_or("valid"), "valid") << family.name;
  }
}

TEST(Validate, RefusesTheOtherDiagonalOfATie) {
  EXPECT_TRUE(accepted(from_triples({{0, 1, 3}, {1, 2, 3}}, 4), square));
  EXPECT_FALSE(accepted(from_triples({{0, 1, 2}, {0, 2, 3}}, 4), square));
}

TEST(Validate, RefusesAnEdgeThatIsNotDelaunay) {
  const Points kite = {{0, 0}, {2, -1}, {4, 0}, {2, 1}};
  EXPECT_TRUE(accepted(from_triples({{0, 1, 3}, {1, 2, 3}}, 4), kite));
  EXPECT_FALSE(accepted(from_triples({{0, 1, 2}, {0, 2, 3}}, 4), kite));
}

TEST(Validate, RefusesADentInTheHull) {
  const Points points = {{0, 0}, {4, 0}, {2, 1}, {2, 4}};  // without the triangle 0 1 2
  EXPECT_TRUE(accepted(from_triples({{0, 1, 2}, {1, 3, 2}, {0, 2, 3}}, 4), points));
  EXPECT_FALSE(accepted(from_triples({{1, 3, 2}, {0, 2, 3}}, 4), points));
}

TEST(Validate, RefusesClockwiseTriangles) {
  Points mirrored = square;
  for (Point2& p : mirrored) p.x = -p.x;
  EXPECT_FALSE(accepted(from_triples({{0, 1, 3}, {1, 2, 3}}, 4), mirrored));
}

TEST(Validate, RefusesAMissingNode) {
  Points points = square;
  points.push_back({0.5, 0.25});
  EXPECT_FALSE(accepted(from_triples({{0, 1, 3}, {1, 2, 3}}, 4), points));
  EXPECT_FALSE(accepted(from_triples({{0, 1, 3}, {1, 2, 3}}, 5), points));
}

TEST(Validate, RefusesBrokenTwinsAndNodes) {
  const Triangulation good = from_triples({{0, 1, 3}, {1, 2, 3}}, 4);
  for (Index t = 0; t < good.triangles.size(); ++t)
    for (Index k = 0; k < 3; ++k) {
      Triangulation bad = good;
      bad.triangles[t].n[k] = half_edge(t, k);
      EXPECT_FALSE(accepted(bad, square)) << t << " " << k;
      bad.triangles[t].n[k] = no_index;
      EXPECT_FALSE(accepted(bad, square)) << t << " " << k;
      bad = good;
      bad.triangles[t].v[k] = good.triangles[t].v[k] == 0 ? 2 : 0;
      EXPECT_FALSE(accepted(bad, square)) << t << " " << k;
      bad.triangles[t].v[k] = 77;
      EXPECT_FALSE(accepted(bad, square)) << t << " " << k;
    }
  Triangulation ghosts_first = good;
  ghosts_first.real = 1;
  EXPECT_FALSE(accepted(ghosts_first, square));
  Triangulation none = good;
  none.triangles.clear();
  none.real = 0;
  EXPECT_FALSE(accepted(none, square));
  EXPECT_FALSE(accepted(good, {{0, 0}}));
}

// A fan round the origin whose rim winds twice, locally convex, like a limaçon with an inner loop: every edge passes
// the circle test and every triangle is counter-clockwise, yet triangles overlap.
TEST(Validate, RefusesAHullThatWindsTwice) {
  const std::size_t rim = 48;
  Points points = {{0, 0}};
  std::vector<Triple> fan;
  for (std::size_t i = 0; i < rim; ++i) {
    const double angle = 4 * 3.14159265358979 * static_cast<double>(i) / rim;
    const double radius = 1 + 0.1 * std::cos(angle / 2);
    points.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    fan.push_back({0, 1 + i, 1 + (i + 1) % rim});
  }
  EXPECT_FALSE(accepted(from_triples(fan, points.size()), points));
}

TEST(Validate, OfTooFewNodesWantsNoTriangles) {
  EXPECT_TRUE(accepted({}, {}));
  Triangulation one;
  one.nodes = 1;
  EXPECT_TRUE(accepted(one, {{1, 2}}));
  EXPECT_FALSE(accepted(from_triples({{0, 1, 3}, {1, 2, 3}}, 4), {}));
}

// Nodes on one line: the ghosts must follow the line, each side once.
TEST(Validate, OfCollinearNodesWantsThemInOrder) {
  const Points line = {{0, 0}, {1, 1}, {2, 2}, {3, 3}};
  const SortedTriangulation s = triangulate_unsorted(line, {});
  ASSERT_TRUE(accepted(s.triangulation, Points(s.xy.begin(), s.xy.end())));
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j) {
      Points other(s.xy.begin(), s.xy.end());
      std::swap(other[i], other[j]);
      EXPECT_FALSE(accepted(s.triangulation, other)) << i << " " << j;
    }
}

}  // namespace
}  // namespace isopach::test
