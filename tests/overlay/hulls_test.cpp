// Areas of hulls and of what they share, against clipping.
#include "isopach/overlay/hulls.hpp"

#include <gtest/gtest.h>

#include "isopach/delaunay/triangulate.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

Points hull_with_collinear_nodes(const Points& points) {
  const SortedTriangulation s = triangulate_unsorted(points, {});
  Points hull;
  for (const Index i : hull_nodes(s.triangulation, s.xy)) hull.push_back(s.xy[i]);
  return hull;
}

class HullFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, HullFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(HullFamilies, AreasEqualClipping) {
  for (const std::size_t n : {3, 10, 200, 2000}) {
    const Points a = GetParam().make(n, 131);
    Points b = GetParam().make(n, 132);
    Box2 box;
    for (const Point2& p : a) box.add(p);
    const double w = box.max.x - box.min.x, h = box.max.y - box.min.y;
    const double scale = w * h;
    EXPECT_NEAR(isopach::polygon_area(hull_with_collinear_nodes(a)), static_cast<double>(polygon_area(brute_hull(a))),
                1e-11 * scale);
    for (const double shift : {0.0, 0.25, 0.9, 3.0}) {
      Points moved = b;
      for (Point2& p : moved) p = {p.x + shift * w, p.y - shift / 2 * h};
      const double expected = static_cast<double>(convex_intersection_area(brute_hull(a), brute_hull(moved)));
      const Points p = hull_with_collinear_nodes(a), q = hull_with_collinear_nodes(moved);
      EXPECT_NEAR(shared_area(p, q), expected, 1e-9 * scale) << n << " " << shift;
      EXPECT_EQ(shared_area(p, q), shared_area(q, p)) << n << " " << shift;
    }
  }
}

TEST(SharedArea, OfSquares) {
  const Points unit = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  EXPECT_DOUBLE_EQ(shared_area(unit, Points{{0.5, 0.25}, {1.5, 0.25}, {1.5, 1.25}, {0.5, 1.25}}), 0.375);
  EXPECT_DOUBLE_EQ(shared_area(unit, unit), 1);
  EXPECT_EQ(shared_area(unit, Points{{1, 0}, {2, 0}, {2, 1}, {1, 1}}), 0) << "they touch along a side";
  EXPECT_EQ(shared_area(unit, Points{{1, 1}, {2, 1}, {2, 2}, {1, 2}}), 0) << "they touch in a corner";
  EXPECT_EQ(shared_area(unit, Points{{5, 5}, {6, 5}, {6, 6}}), 0);
  EXPECT_EQ(shared_area(unit, Points{}), 0);
  EXPECT_EQ(shared_area(unit, Points{{0.5, 0.5}}), 0);
  EXPECT_EQ(shared_area(unit, Points{{0, 0}, {1, 1}}), 0);
}

}  // namespace
}  // namespace isopach::test
