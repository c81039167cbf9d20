// The united node set: the sorted union, shared nodes once, each node knowing where it came from.
#include "isopach/overlay/common.hpp"

#include <gtest/gtest.h>

#include "isopach/delaunay/validate.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

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

TEST(Unite, OfManyNodesIsThatOfOneAfterTheOther) {  // parts, with shared nodes in and between them
  const CurveBox box = curve_box({{0, 0}, {1, 1}});
  const Points all = in_order(distinct(uniform(200000, 5)), box);
  Random random(6);
  for (const auto& one_in : {std::array<std::size_t, 2>{3, 5}, {1, 1}, {2, 2}, {1, 50}, {50, 1}}) {
    std::array<Points, 2> g;
    std::vector<std::array<Index, 2>> expected;
    Points places;
    for (const Point2& p : all) {
      std::array<Index, 2> ids{no_index, no_index};
      for (std::size_t k = 0; k < 2; ++k) {
        if (random.below(one_in[k]) != 0) continue;
        ids[k] = static_cast<Index>(g[k].size());
        g[k].push_back(p);
      }
      if (ids[0] == no_index && ids[1] == no_index) continue;
      expected.push_back(ids);
      places.push_back(p);
    }
    const UnitedNodes found = unite(g[0], g[1], box);
    ASSERT_EQ(Points(found.xy.begin(), found.xy.end()), places);
    ASSERT_EQ(found.of_1.size(), expected.size());
    ASSERT_EQ(found.of_2.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      ASSERT_EQ((std::array{found.of_1[i], found.of_2[i]}), expected[i]) << i;
  }
}

}  // namespace
}  // namespace isopach::test
