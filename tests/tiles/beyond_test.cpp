#include "isopach/tiles/beyond.hpp"

#include <gtest/gtest.h>

#include "isopach/geom/convex_hull.hpp"
#include "isopach/geom/predicates.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

/// Whether some side of the hull has all of the points strictly beyond it.
bool has_separating_side(const std::vector<Point2>& hull, const Points& points) {
  for (std::size_t i = 0; i < hull.size(); ++i) {
    bool all = true;
    for (const Point2& p : points) all = all && orientation(hull[i], hull[(i + 1) % hull.size()], p) < 0;
    if (all) return true;
  }
  return false;
}

TEST(SidesBeyond, SeparateByDefinition) {
  std::size_t separated = 0, told = 0;
  for (const Family& of_hull : families())
    for (const double by : {0.0, 0.3, 0.8, 5.0}) {
      SCOPED_TRACE(of_hull.name);
      ConvexHull hull;
      hull.add(of_hull.make(40, 3));
      Points xy = uniform(60, 4);
      for (Point2& p : xy) p.x += by;
      const Array<std::uint64_t> beyond = sides_beyond(hull.corners(), xy);
      ASSERT_EQ(beyond.size(), xy.size());
      for (std::size_t i = 0; i + 2 < xy.size(); ++i) {
        const bool is_out =
            hull.corners().size() > 2 && has_separating_side(hull.corners(), {xy[i], xy[i + 1], xy[i + 2]});
        const bool is_told = (beyond[i] & beyond[i + 1] & beyond[i + 2]) != 0;
        if (is_told) {
          EXPECT_TRUE(is_out) << i;
        }
        separated += is_out ? 1 : 0, told += is_told ? 1 : 0;
        if (beyond[i] != 0) {
          EXPECT_FALSE(hull.holds(xy[i]));
        }
      }
    }
  EXPECT_GT(told, separated * 9 / 10);
}

TEST(SidesBeyond, NothingIsKnownWithoutAHull) {
  const Points xy = uniform(5, 1);
  for (const std::uint64_t bits : sides_beyond({}, xy)) EXPECT_EQ(bits, 0U);
  const Points line{{0, 0}, {1, 1}};
  for (const std::uint64_t bits : sides_beyond(line, xy)) EXPECT_EQ(bits, 0U);
}

// The corners of a hull and what lies on its sides are not beyond it.
TEST(SidesBeyond, AreStrict) {
  const Points square{{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  const Points xy{{0, 0}, {2, 0}, {4, 4}, {5, 2}, {2, -1}, {5, -1}};
  const Array<std::uint64_t> beyond = sides_beyond(square, xy);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(beyond[i], 0U);
  for (std::size_t i = 3; i < 6; ++i) EXPECT_NE(beyond[i], 0U);
  EXPECT_EQ((beyond[3] & beyond[4]), 0U);
  EXPECT_EQ(beyond[5], (beyond[3] | beyond[4]));
}

}  // namespace
}  // namespace isopach::test
