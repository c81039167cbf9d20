// T by whichever way is chosen equals T from scratch, and the choice is that of the sets alone.
#include "isopach/overlay/triangulate_union.hpp"

#include <gtest/gtest.h>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/validate.hpp"
#include "isopach/overlay/localise.hpp"
#include "tests/overlay/united_case.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"

namespace isopach::test {
namespace {

// A case with both its meshes, in the order given or exchanged.
struct Meshes {
  Case c;
  Triangulation t1, t2;
  Locations at_1, at_2;
  explicit Meshes(Case given) : c(std::move(given)) {
    t1 = triangulate(c.g1, c.box, {});
    t2 = triangulate(c.g2, c.box, {});
    at_1 = localise_in_order(c.g1, t2, c.g2, {});
    at_2 = localise_in_order(c.g2, t1, c.g1, {});
  }
  [[nodiscard]] MeshToMerge first() const { return {t1, c.g1, &at_1}; }
  [[nodiscard]] MeshToMerge second() const { return {t2, c.g2, &at_2}; }
  [[nodiscard]] Triangulation united() const { return triangulate_union(first(), second(), c.g, c.box, {}); }
  [[nodiscard]] Triangulation united_exchanged() const {
    UnitedNodes g = c.g;
    std::swap(g.of_1, g.of_2);
    return triangulate_union(second(), first(), g, c.box, {});
  }
  [[nodiscard]] UnionMethod method() const { return cheapest(shape_of(first(), second(), c.g)); }
};

std::size_t runs_of(const UnitedNodes& g) {
  std::size_t runs = 0;
  int last = 0;
  for (std::size_t u = 0; u < g.xy.size(); ++u) {
    const int colour = g.of_2[u] == no_index ? 1 : (g.of_1[u] == no_index ? 2 : 0);
    runs += colour != 0 && colour != last ? 1 : 0;
    last = colour != 0 ? colour : last;
  }
  return runs;
}

void expect_united(const Points& a, const Points& b) {
  const Meshes m(make_case(a, b));
  const Triangulation t = m.united();
  ASSERT_EQ(validate(t, m.c.g.xy).value_or("valid"), "valid");
  const Triangulation scratch = triangulate(m.c.g.xy, m.c.box, {});
  EXPECT_EQ(t.real, scratch.real);
  ASSERT_TRUE(triangle_set(t, m.c.g.xy) == triangle_set(scratch, m.c.g.xy));
  EXPECT_TRUE(same_bytes(t, m.united_exchanged())) << "exchanged";
}

TEST(TriangulateUnion, OneFamilyAndAnother) {
  for (const Family& one : families())
    for (const Family& other : families()) {
      SCOPED_TRACE(one.name + " and " + other.name);
      expect_united(one.make(120, 41), other.make(90, 42));
      expect_united(one.make(30, 43), moved(other.make(120, 44), 1.5, 0.25));
      if (HasFatalFailure()) return;
    }
}

TEST(TriangulateUnion, FewNodes) {
  for (std::size_t n1 = 0; n1 < 6; ++n1)
    for (std::size_t n2 = 0; n2 < 6; ++n2)
      for (std::uint64_t seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(std::to_string(n1) + " and " + std::to_string(n2) + ", seed " + std::to_string(seed));
        expect_united(coarse_lattice(n1, seed), coarse_lattice(n2, 100 + seed));
        if (HasFatalFailure()) return;
      }
}

TEST(TriangulateUnion, ManySmallLattices) {
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    SCOPED_TRACE(seed);
    expect_united(coarse_lattice(3 + seed % 38, 1000 + seed), moved(coarse_lattice(3 + seed % 29, 9 + seed), 2, 1));
    if (HasFatalFailure()) return;
  }
}

TEST(TriangulateUnion, ChoosesBySets) {
  const auto method = [](const Points& a, const Points& b) { return Meshes(make_case(a, b)).method(); };
  const Points a = uniform(4000, 1), b = uniform(4000, 2), some = uniform(250, 3);
  EXPECT_EQ(method(a, b), UnionMethod::insertion);
  EXPECT_EQ(method(a, some), UnionMethod::insertion);
  EXPECT_EQ(method(some, a), UnionMethod::insertion);
  EXPECT_EQ(method(a, a), UnionMethod::insertion);  // a copy
  EXPECT_EQ(method(a, moved(b, 1.05, 0)), UnionMethod::merging);
  EXPECT_EQ(method(a, moved(some, 1.05, 0)), UnionMethod::merging);
  EXPECT_EQ(method(a, moved(scaled(b, 1e-4), 0.5, 0.5)), UnionMethod::merging);
  EXPECT_EQ(method(a, moved(b, 0.6, 0)), UnionMethod::scratch);
}

TEST(TriangulateUnion, ShapeIsCounted) {
  const Points a = {{0, 0}, {1, 0}, {0, 1}, {1, 1}}, b = {{0, 0}, {0.5, 0.5}, {3, 3}, {3, 3.5}};
  const Meshes m(make_case(a, b));
  const UnionShape shape = shape_of(m.first(), m.second(), m.c.g);
  EXPECT_EQ(shape.nodes, 7U);
  EXPECT_EQ(shape.inserted, 3U);
  EXPECT_EQ(shape.runs, runs_of(m.c.g));
  EXPECT_EQ(shape.outside, 2U);
}

TEST(TriangulateUnion, RunsOfManyBlocksAreOneSum) {
  const Meshes m(make_case(uniform(20000, 5), joined(uniform(9000, 6), some_of(uniform(20000, 5), 7))));
  EXPECT_EQ(shape_of(m.first(), m.second(), m.c.g).runs, runs_of(m.c.g));
}

// Insertion is chosen, gives up, and the union is triangulated from scratch: a row of nodes that each see all of a fan.
TEST(TriangulateUnion, FallsBackWhereInsertionIsExpensive) {
  Points fan, row;
  for (int i = 0; i < 2000; ++i) fan.push_back({1e-3 * i, 0});
  fan.push_back({1, 1e6});
  for (int i = 0; i < 1000; ++i) row.push_back({1 + 1e-4 * i * (i % 2 == 0 ? 1 : -1), 1e5 - i});
  const Meshes m(make_case(fan, row));
  const Triangulation scratch = triangulate(m.c.g.xy, m.c.box, {});
  EXPECT_TRUE(triangle_set(m.united(), m.c.g.xy) == triangle_set(scratch, m.c.g.xy));
}

}  // namespace
}  // namespace isopach::test
