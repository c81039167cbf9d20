// The united node set: the sorted union, shared nodes once, each node knowing where it came from.
#include "isopach/overlay/common.hpp"

#include <gtest/gtest.h>

#include "isopach/delaunay/validate.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"

namespace isopach::test {
namespace {

class UniteFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, UniteFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(UniteFamilies, IsTheUnionInCurveOrder) {
  for (const auto& [n1, n2] :
       {std::pair{0, 0}, std::pair{0, 5}, std::pair{5, 0}, std::pair{700, 900}, std::pair{900, 900}}) {
    Points g1 = distinct(GetParam().make(static_cast<std::size_t>(n1), 101));
    Points g2 = distinct(GetParam().make(static_cast<std::size_t>(n2), 102));
    if (n1 == n2) g2.insert(g2.end(), g1.begin(), g1.begin() + static_cast<std::ptrdiff_t>(g1.size() / 2));
    g2 = distinct(g2);
    Points all = g1;
    all.insert(all.end(), g2.begin(), g2.end());
    all = distinct(all);
    Box2 extent;
    for (const Point2& p : all) extent.add(p);
    const CurveBox box = curve_box(extent);
    g1 = in_order(g1, box);
    g2 = in_order(g2, box);
    const UnitedNodes g = unite(g1, g2, box);
    const Points expected = in_order(all, box);
    ASSERT_EQ(Points(g.xy.begin(), g.xy.end()), expected);
    std::size_t of_1 = 0, of_2 = 0;
    for (std::size_t i = 0; i < g.xy.size(); ++i) {
      ASSERT_TRUE(g.of_1[i] != no_index || g.of_2[i] != no_index);
      of_1 += g.of_1[i] != no_index;
      of_2 += g.of_2[i] != no_index;
      EXPECT_TRUE(g.of_1[i] == no_index || g1[g.of_1[i]] == g.xy[i]);
      EXPECT_TRUE(g.of_2[i] == no_index || g2[g.of_2[i]] == g.xy[i]);
    }
    EXPECT_EQ(of_1, g1.size());
    EXPECT_EQ(of_2, g2.size());
    EXPECT_EQ(validate(triangulate(g.xy, box, {}), g.xy).value_or("valid"), "valid");
  }
}

}  // namespace
}  // namespace isopach::test
