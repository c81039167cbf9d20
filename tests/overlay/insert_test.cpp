// Inserting one mesh into the other equals triangulating the union from scratch, triangle by triangle, on every family.
#include "isopach/overlay/insert.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/validate.hpp"
#include "isopach/overlay/localise.hpp"
#include "tests/overlay/united_case.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

constexpr InsertOptions unlimited{.most_tests = 1U << 30, .most_tests_of_union = 1U << 30};
constexpr InsertOptions in_small_blocks{.nodes_at_once = 5, .most_tests = 1U << 30, .most_tests_of_union = 1U << 30};

// The nodes of g2 into the triangulation of g1, or the other way round. None if there is nothing to insert into.
std::optional<Triangulation> inserted(const Case& c, bool second_into_first, const InsertOptions& options) {
  const Points& into = second_into_first ? c.g1 : c.g2;
  const Triangulation mesh = triangulate(into, c.box, {});
  if (mesh.real == 0) return std::nullopt;
  const Locations where = localise_in_order(second_into_first ? c.g2 : c.g1, mesh, into, {});
  const auto &node = second_into_first ? c.g.of_1 : c.g.of_2, &other = second_into_first ? c.g.of_2 : c.g.of_1;
  return insert({mesh, node}, {other, where}, c.g.xy, {}, options);
}

void expect_inserted(const Points& a, const Points& b) {
  const Case c = make_case(a, b);
  const Triangulation scratch = triangulate(c.g.xy, c.box, {});
  const auto expected = triangle_set(scratch, c.g.xy);
  for (const bool second_into_first : {true, false})
    for (const InsertOptions& options : {unlimited, in_small_blocks}) {
      SCOPED_TRACE(second_into_first ? "second into first" : "first into second");
      SCOPED_TRACE(options.nodes_at_once);
      const auto t = inserted(c, second_into_first, options);
      if (!t) continue;
      ASSERT_EQ(validate(*t, c.g.xy).value_or("valid"), "valid");
      EXPECT_EQ(t->real, scratch.real);
      ASSERT_TRUE(triangle_set(*t, c.g.xy) == expected);
    }
}

class InsertFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, InsertFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(InsertFamilies, TwoSamples) {
  for (const auto& [n1, n2] :
       {std::pair{500, 500}, std::pair{900, 60}, std::pair{20, 700}, std::pair{3, 400}, std::pair{3, 4}}) {
    SCOPED_TRACE(n1);
    expect_inserted(GetParam().make(static_cast<std::size_t>(n1), 11),
                    GetParam().make(static_cast<std::size_t>(n2), 12));
  }
}

TEST_P(InsertFamilies, SharedNodes) {
  const Points a = GetParam().make(600, 21), b = GetParam().make(500, 22);
  expect_inserted(a, a);
  expect_inserted(a, some_of(a, 2));
  expect_inserted(joined(a, some_of(b, 5)), b);
  expect_inserted(joined(a, some_of(b, 40)), b);
}

TEST_P(InsertFamilies, CrossingHullsAndDisjointSets) {
  const Points a = GetParam().make(500, 31), b = GetParam().make(400, 32);
  Box2 extent;
  for (const Point2& p : a) extent.add(p);
  const double w = extent.max.x - extent.min.x, h = extent.max.y - extent.min.y;
  expect_inserted(a, moved(b, 0.5 * w, 0.25 * h));
  expect_inserted(a, moved(b, 1.5 * w + 1, 0));
  expect_inserted(a, moved(b, w, 0));
  expect_inserted(a, moved(a, w, 0));
  expect_inserted(a, scaled(b, 0.125));
  expect_inserted(a, {{extent.min.x - 1e9, extent.min.y}, {extent.max.x, extent.max.y + 1e12}});
}

TEST(Insert, OneFamilyIntoAnother) {
  for (const Family& one : families())
    for (const Family& other : families()) {
      SCOPED_TRACE(one.name + " and " + other.name);
      expect_inserted(one.make(120, 41), other.make(90, 42));
      if (HasFatalFailure()) return;
    }
}

TEST(Insert, ManySmallLattices) {
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(seed);
    expect_inserted(coarse_lattice(3 + seed % 38, 1000 + seed), coarse_lattice(3 + seed % 29, 5000 + seed));
    if (HasFatalFailure()) return;
  }
}

TEST(Insert, ManySmallSetsOfDoubles) {
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    SCOPED_TRACE(seed);
    expect_inserted(uniform(3 + seed % 38, 1000 + seed), moved(uniform(3 + seed % 29, 5000 + seed), 0.3, 0.1));
    expect_inserted(nearly_diagonal(3 + seed % 17, seed), moved(near_degenerate(9 + seed % 20, seed), 1, 1));
    if (HasFatalFailure()) return;
  }
}

// Every sign is decided by the exact stages: coordinates that no common step divides, cocircular but for the last bits.
TEST(Insert, LatticesOfTenths) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    expect_inserted(scaled(coarse_lattice(40, seed), 0.1), scaled(coarse_lattice(30, 700 + seed), 0.1));
    if (HasFatalFailure()) return;
  }
}

// The largest coordinates that there are: squares of offsets are infinite, and so are the filters' bounds.
TEST(Insert, OffsetsWhoseSquaresOverflow) {
  expect_inserted(scaled(uniform(60, 3), 1e160), scaled(uniform(50, 4), 1e160));
  expect_inserted(scaled(uniform(60, 3), 1e-160), scaled(uniform(50, 4), 1e-160));
}

TEST(Insert, NothingToInsert) {
  const Case c = make_case(uniform(200, 5), {});
  const Triangulation mesh = triangulate(c.g1, c.box, {});
  const auto t = insert({mesh, c.g.of_1}, {c.g.of_2, {}}, c.g.xy, {});
  ASSERT_TRUE(t);
  EXPECT_TRUE(same_bytes(*t, mesh));
}

// Every node of the one lies near the circle of every triangle of the other: a fan that each insertion tears up.
TEST(Insert, GivesUpWhereCavitiesAreLarge) {
  Points line, far;
  for (int i = 0; i < 2000; ++i) line.push_back({1e-3 * i, 0});
  line.push_back({1, 1e6});
  for (int i = 0; i < 1000; ++i) far.push_back({1 + 1e-4 * i * (i % 2 == 0 ? 1 : -1), 1e5 - i});
  const Case c = make_case(line, far);
  EXPECT_FALSE(inserted(c, true, {}));
  run_with_threads(4, [&] { EXPECT_FALSE(inserted(c, true, {.nodes_at_once = 64})); });
  expect_inserted(line, far);
}

TEST(Insert, SameBitsForAnyNumberOfThreads) {
  const Case c = make_case(uniform(90000, 51), joined(uniform(60000, 52), some_of(uniform(90000, 51), 50)));
  std::optional<Triangulation> one, four;
  run_with_threads(1, [&] { one = inserted(c, true, {.nodes_at_once = 4096}); });
  ASSERT_TRUE(one);
  for (int repeat = 0; repeat < 3; ++repeat) {
    run_with_threads(4, [&] { four = inserted(c, true, {.nodes_at_once = 4096}); });
    EXPECT_TRUE(four && same_bytes(*one, *four));
  }
  EXPECT_EQ(validate(*one, c.g.xy).value_or("valid"), "valid");
}

}  // namespace
}  // namespace isopach::test
