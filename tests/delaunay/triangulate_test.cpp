// Laws of the triangulation: valid, equal to brute force, a function of the point set, the same bytes for any number of
// threads.
#include "isopach/delaunay/triangulate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/validate.hpp"
#include "isopach/geom/predicates.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

std::string verdict(const SortedTriangulation& s) { return validate(s.triangulation, s.xy).value_or("valid"); }

class TriangulateFamilies : public testing::TestWithParam<Family> {
 protected:
  static Points make(std::size_t n, std::uint64_t seed) { return GetParam().make(n, seed); }
};
INSTANTIATE_TEST_SUITE_P(All, TriangulateFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(TriangulateFamilies, IsValidAtEverySmallSize) {
  for (std::size_t n = 0; n <= 40; ++n)
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const SortedTriangulation s = triangulate_unsorted(make(n, seed), {});
      ASSERT_EQ(verdict(s), "valid") << n << " points, seed " << seed;
    }
}

TEST_P(TriangulateFamilies, IsValid) {
  for (const std::size_t n : {300, 5000, 20000})
    EXPECT_EQ(verdict(triangulate_unsorted(make(n, 41), {})), "valid") << n;
}

TEST_P(TriangulateFamilies, EqualsBruteForce) {
  for (const std::size_t n : {3, 4, 5, 6, 7, 8, 9, 12, 17, 25, 40})
    for (std::uint64_t seed = 1; seed <= (n < 12 ? 20 : 2); ++seed) {
      const Points points = make(n, 100 * n + seed);
      const SortedTriangulation s = triangulate_unsorted(points, {});
      const Points nodes = distinct(points);
      ASSERT_EQ(triangle_set(s.triangulation, s.xy), triangle_set(brute_delaunay(nodes), nodes))
          << n << " points, seed " << 100 * n + seed;
    }
}

TEST_P(TriangulateFamilies, IsAFunctionOfThePointSet) {
  for (const std::size_t n : {10, 100, 5000}) {
    Points points = make(n, 42);
    const SortedTriangulation first = triangulate_unsorted(points, {});
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      Random(seed).shuffle(points);
      const SortedTriangulation again = triangulate_unsorted(points, {});
      EXPECT_EQ(again.xy, first.xy);
      EXPECT_TRUE(same_bytes(again.triangulation, first.triangulation));
    }
  }
}

// The curve's square must not matter either: the cuts move, the triangles stay.
TEST_P(TriangulateFamilies, IsTheSameSetOfTrianglesForAnyCurveBox) {
  const Points points = distinct(make(2000, 43));
  Box2 extent;
  for (const Point2& p : points) extent.add(p);
  const CurveBox own = curve_box(extent);
  const SortedTriangulation first = triangulate_unsorted(points, {});
  const std::vector<Corners> expected = triangle_set(first.triangulation, first.xy);
  const double side = 4294967296.0 / own.scale;
  for (const CurveBox& box : {CurveBox{{own.min.x - 0.3 * side, own.min.y - 0.1 * side}, own.scale / 2},
                              CurveBox{{own.min.x - 5 * side, own.min.y}, own.scale / 64},
                              CurveBox{{own.min.x + 0.2 * side, own.min.y + 0.3 * side}, own.scale * 4},
                              CurveBox{own.min, own.scale / 1e9}}) {
    Points sorted;
    for (const Index i : curve_order(points, box)) sorted.push_back(points[i]);
    const Triangulation t = triangulate(sorted, box, {});
    EXPECT_EQ(validate(t, sorted).value_or("valid"), "valid");
    EXPECT_EQ(triangle_set(t, sorted), expected);
  }
}

// Cocircular ties are decided by coordinates, so moving and scaling all points exactly changes nothing.
TEST_P(TriangulateFamilies, MovesWithThePointsUnderExactShiftsAndScales) {
  Points points;
  for (const Point2& p : make(1000, 44))
    points.push_back({static_cast<double>(static_cast<float>(p.x)), static_cast<double>(static_cast<float>(p.y))});
  const SortedTriangulation first = triangulate_unsorted(points, {});
  Points scaled;
  for (const Point2& p : points) scaled.push_back({p.x * 0x1p-40, p.y * 0x1p-40});
  const SortedTriangulation second = triangulate_unsorted(scaled, {});
  std::vector<Corners> back = triangle_set(second.triangulation, second.xy);
  for (Corners& c : back)
    for (Point2& p : c) p = {p.x * 0x1p40, p.y * 0x1p40};
  EXPECT_EQ(back, triangle_set(first.triangulation, first.xy));
}

TEST_P(TriangulateFamilies, TilesTheHull) {
  const Points points = make(3000, 45);
  const SortedTriangulation s = triangulate_unsorted(points, {});
  Points corners;
  for (const Corners& c : triangle_set(s.triangulation, s.xy)) corners.insert(corners.end(), c.begin(), c.end());
  const Points hull = brute_hull(points);
  EXPECT_EQ(exact_compare_areas(corners, hull), 0);
  EXPECT_EQ(s.triangulation.triangles.size(), 2 * s.xy.size() - 2);

  Points found;
  for (const Index i : hull_nodes(s.triangulation, s.xy)) found.push_back(s.xy[i]);
  EXPECT_EQ(found.size(), s.triangulation.ghosts());
  EXPECT_EQ(found.front(), distinct(points).front());
  if (GetParam().collinear) {
    EXPECT_EQ(s.triangulation.real, 0u);
    return;
  }
  // The hull of ours holds the corners, in the same order, and besides them only points inside its edges.
  std::size_t corner = 0;
  for (const Point2& p : found)
    if (corner < hull.size() && p == hull[corner]) {
      ++corner;
    } else {
      EXPECT_EQ(exact_orientation(hull[corner - 1], p, hull[corner % hull.size()]), 0);
    }
  EXPECT_EQ(corner, hull.size());
}

TEST_P(TriangulateFamilies, MapsEveryPointToItsNode) {
  const Points points = make(3000, 46);
  const SortedTriangulation s = triangulate_unsorted(points, {});
  ASSERT_EQ(s.node_of.size(), points.size());
  ASSERT_EQ(s.order.size(), s.xy.size());
  EXPECT_EQ(s.xy.size(), distinct(points).size());
  EXPECT_EQ(s.triangulation.nodes, s.xy.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_LT(s.node_of[i], s.xy.size());
    EXPECT_EQ(s.xy[s.node_of[i]], points[i]);
    EXPECT_LE(s.order[s.node_of[i]], i) << "the first of equals";
  }
  for (std::size_t node = 0; node < s.order.size(); ++node) EXPECT_EQ(s.node_of[s.order[node]], node);
}

TEST_P(TriangulateFamilies, HasTheSameBytesForAnyNumberOfThreads) {
  const Points points = make(20000, 47);
  const SortedTriangulation expected = triangulate_unsorted(points, {});
  for (const int threads : {1, 2, 7})
    run_with_threads(threads, [&] {
      const SortedTriangulation s = triangulate_unsorted(points, {});
      EXPECT_EQ(s.order, expected.order) << threads;
      EXPECT_TRUE(same_bytes(s.triangulation, expected.triangulation)) << threads;
    });
}

TEST(Triangulate, OfLargeSetsIsValid) {
  for (const auto& make : {uniform, grid, rotated_grid, scan_lines, clustered})
    EXPECT_EQ(verdict(triangulate_unsorted(make(200000, 48), {})), "valid");
}

TEST(Triangulate, OfNoneOneTwoAndThreePoints) {
  EXPECT_TRUE(triangulate_unsorted(Points{}, {}).triangulation.triangles.empty());
  const SortedTriangulation one = triangulate_unsorted(Points{{3, 4}}, {});
  EXPECT_TRUE(one.triangulation.triangles.empty());
  EXPECT_EQ(one.triangulation.nodes, 1u);
  EXPECT_EQ(hull_nodes(one.triangulation, one.xy).size(), 1u);
  const SortedTriangulation two = triangulate_unsorted(Points{{3, 4}, {1, 2}}, {});
  EXPECT_EQ(two.triangulation.ghosts(), 2u);
  EXPECT_EQ(two.triangulation.real, 0u);
  const SortedTriangulation three = triangulate_unsorted(Points{{0, 0}, {0, 1}, {1, 0}}, {});
  EXPECT_EQ(three.triangulation.real, 1u);
  EXPECT_EQ(three.triangulation.ghosts(), 3u);
}

TEST(Triangulate, OfEqualPointsIsOneNode) {
  const SortedTriangulation s = triangulate_unsorted(Points(1000, Point2{1, 2}), {});
  EXPECT_EQ(s.xy.size(), 1u);
  EXPECT_EQ(s.order[0], 0u);
  EXPECT_EQ(verdict(s), "valid");
}

TEST(Triangulate, TakesMinusZeroForZero) {
  const SortedTriangulation s = triangulate_unsorted(Points{{0.0, 0.0}, {-0.0, 0.0}, {1, 0}, {0, 1}, {1, -0.0}}, {});
  EXPECT_EQ(s.xy.size(), 3u);
  EXPECT_EQ(verdict(s), "valid");
}

TEST(Triangulate, CollinearPointsHaveAGhostOnEachSideOfEachEdge) {
  const SortedTriangulation s = triangulate_unsorted(diagonal(100, 49), {});
  EXPECT_EQ(s.triangulation.real, 0u);
  EXPECT_EQ(s.triangulation.ghosts(), 198u);
  const Array<Index> hull = hull_nodes(s.triangulation, s.xy);
  ASSERT_EQ(hull.size(), 198u);
  for (std::size_t i = 1; i < 100; ++i) EXPECT_TRUE(lexicographic_less(s.xy[hull[i - 1]], s.xy[hull[i]]));
  for (std::size_t i = 100; i < 198; ++i) EXPECT_TRUE(lexicographic_less(s.xy[hull[i]], s.xy[hull[i - 1]]));
}

TEST(Triangulate, OfExtremeMagnitudesIsValid) {
  for (const double scale : {1e-300, 1e-160, 1e-100, 1e100, 1e150, 1e300}) {
    Points points = uniform(300, 50);
    for (Point2& p : points) p = {p.x * scale, p.y * scale};
    EXPECT_EQ(verdict(triangulate_unsorted(points, {})), "valid") << scale;
  }
  Points mixed;
  Random random(51);
  for (int i = 0; i < 300; ++i)
    mixed.push_back({std::ldexp(random.uniform() - 0.5, static_cast<int>(random.below(600)) - 300),
                     std::ldexp(random.uniform() - 0.5, static_cast<int>(random.below(600)) - 300)});
  EXPECT_EQ(verdict(triangulate_unsorted(mixed, {})), "valid");
}

// A column of points so narrow that one cell of the curve holds it: cuts follow the lexicographic order there.
TEST(Triangulate, OfPointsInOneCurveCellIsValid) {
  Points points = uniform(500, 52);
  for (Point2& p : points) p = {p.x * 1e-13, p.y * 1e-13};
  points.push_back({1000, 1000});
  const SortedTriangulation s = triangulate_unsorted(points, {});
  EXPECT_EQ(verdict(s), "valid");
  for (Point2& p : points) p = {p.x, p.x < 1 ? 0 : p.y};
  EXPECT_EQ(verdict(triangulate_unsorted(points, {})), "valid");
}

TEST(Triangulate, StopsWhenCancelled) {
  const std::atomic<bool> cancelled{true};
  Context context;
  context.cancelled = &cancelled;
  EXPECT_THROW((void)triangulate_unsorted(uniform(10, 53), context), Interrupted);
}

}  // namespace
}  // namespace isopach::test
