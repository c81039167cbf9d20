// Merging equals triangulating the union from scratch, triangle by triangle, on every family.
#include "isopach/overlay/merge.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/validate.hpp"
#include "isopach/overlay/localise.hpp"
#include "tests/overlay/united_case.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"

namespace isopach::test {
namespace {

Triangulation merged(const Case& c, bool swapped = false) {
  const Points &g1 = swapped ? c.g2 : c.g1, &g2 = swapped ? c.g1 : c.g2;
  const Triangulation t1 = triangulate(g1, c.box, {}), t2 = triangulate(g2, c.box, {});
  const Locations in_2 = localise(g1, spanning_tree(t1, g1, {}), t2, g2, {});
  const Locations in_1 = localise(g2, spanning_tree(t2, g2, {}), t1, g1, {});
  UnitedNodes g = c.g;
  if (swapped) std::swap(g.of_1, g.of_2);
  return merge({t1, g1, &in_2}, {t2, g2, &in_1}, g, c.box, {});
}

void expect_merged(const Points& a, const Points& b) {
  const Case c = make_case(a, b);
  const Triangulation t = merged(c);
  ASSERT_EQ(validate(t, c.g.xy).value_or("valid"), "valid");
  const Triangulation scratch = triangulate(c.g.xy, c.box, {});
  ASSERT_EQ(triangle_set(t, c.g.xy), triangle_set(scratch, c.g.xy));
  EXPECT_EQ(t.real, scratch.real);
  EXPECT_TRUE(same_bytes(t, merged(c, true))) << "exchanged";
}

class MergeFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, MergeFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(MergeFamilies, TwoSamples) {
  for (const auto& [n1, n2] : {std::pair{500, 500}, std::pair{900, 60}, std::pair{20, 700}, std::pair{3, 4}}) {
    SCOPED_TRACE(n1);
    expect_merged(GetParam().make(static_cast<std::size_t>(n1), 11), GetParam().make(static_cast<std::size_t>(n2), 12));
  }
}

TEST_P(MergeFamilies, SharedNodes) {
  const Points a = GetParam().make(600, 21), b = GetParam().make(500, 22);
  expect_merged(a, a);
  expect_merged(a, some_of(a, 2));
  expect_merged(joined(a, some_of(b, 5)), b);
  expect_merged(joined(a, some_of(b, 40)), b);
  expect_merged(some_of(a, 3), a);
}

TEST_P(MergeFamilies, CrossingHullsAndDisjointSets) {
  const Points a = GetParam().make(500, 31), b = GetParam().make(400, 32);
  Box2 extent;
  for (const Point2& p : a) extent.add(p);
  const double w = extent.max.x - extent.min.x, h = extent.max.y - extent.min.y;
  expect_merged(a, moved(b, 0.5 * w, 0.25 * h));
  expect_merged(a, moved(b, 1.5 * w + 1, 0));
  expect_merged(a, moved(b, w, 0));
  expect_merged(a, moved(a, w, 0));
  expect_merged(a, scaled(b, 0.125));
  expect_merged(moved(a, 0.01 * w, -0.02 * h), b);
}

TEST(Merge, OneFamilyInAnother) {
  for (const Family& one : families())
    for (const Family& other : families()) {
      SCOPED_TRACE(one.name + " and " + other.name);
      expect_merged(one.make(120, 41), other.make(90, 42));
      if (HasFatalFailure()) return;
    }
}

TEST(Merge, ManySmallLattices) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    expect_merged(coarse_lattice(6 + seed % 90, 1000 + seed), coarse_lattice(4 + seed % 37, 2000 + seed));
    if (HasFatalFailure()) return;
  }
}

TEST(Merge, GridsShiftedByHalfACell) {
  const Points a = grid(900, 0);
  for (const auto& [dx, dy] : {std::pair{0.5, 0.5}, std::pair{0.5, 0.0}, std::pair{0.0, 0.25}, std::pair{3.0, 5.0}})
    expect_merged(a, moved(a, dx, dy));
}

TEST(Merge, SameBitsForAnyNumberOfThreads) {
  const Case c = make_case(uniform(150000, 51), joined(uniform(140000, 52), some_of(uniform(150000, 51), 50)));
  Triangulation one, four;
  run_with_threads(1, [&] { one = merged(c); });
  for (int repeat = 0; repeat < 3; ++repeat) {
    run_with_threads(4, [&] { four = merged(c); });
    EXPECT_TRUE(same_bytes(one, four));
  }
  EXPECT_EQ(validate(one, c.g.xy).value_or("valid"), "valid");
}

TEST(Merge, InterfaceTrianglesJoinColours) {
  const Case c = make_case(uniform(800, 61), joined(uniform(700, 62), some_of(uniform(800, 61), 9)));
  const Triangulation t = merged(c);
  const Array<Index> list = interface_triangles(t, c.g);
  std::size_t place = 0;
  for (Index i = 0; i < t.real; ++i) {
    int pure_1 = 0, pure_2 = 0;
    for (const Index v : t.triangles[i].v) {
      pure_1 += c.g.of_2[v] == no_index ? 1 : 0;
      pure_2 += c.g.of_1[v] == no_index ? 1 : 0;
    }
    if (pure_1 > 0 && pure_2 > 0) {
      ASSERT_LT(place, list.size());
      EXPECT_EQ(list[place++], i);
    }
  }
  EXPECT_EQ(place, list.size());
  EXPECT_GT(place, t.real / 2);
}

}  // namespace
}  // namespace isopach::test
