// Locations against the oracle that tries every triangle; own nodes; points on edges; outside; degenerate meshes.
#include "isopach/overlay/localise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

using Kind = Location::Kind;

Locations localise_all(const SortedTriangulation& points, const SortedTriangulation& mesh) {
  return localise(points.xy, spanning_tree(points.triangulation, points.xy, {}), mesh.triangulation, mesh.xy, {});
}

Locations localise_all_in_order(const SortedTriangulation& points, const SortedTriangulation& mesh) {
  return localise_in_order(points.xy, mesh.triangulation, mesh.xy, {});
}

void expect_equal(const Locations& found, const Locations& expected) {
  EXPECT_EQ(found.kind, expected.kind);
  EXPECT_EQ(found.id, expected.id);
}

Points corners_of(const Location& at, const SortedTriangulation& mesh) {
  const Triangulation& t = mesh.triangulation;
  if (at.kind == Kind::node) return {mesh.xy[at.id]};
  if (at.kind == Kind::edge) return distinct({mesh.xy[t.origin(at.id)], mesh.xy[t.target(at.id)]});
  if (at.kind == Kind::triangle) {
    const auto& v = t.triangles[at.id].v;
    return distinct({mesh.xy[v[0]], mesh.xy[v[1]], mesh.xy[v[2]]});
  }
  return {};
}

long double distance_to_edge(const Point2& q, const Point2& a, const Point2& b) {
  const long double ux = static_cast<long double>(b.x) - a.x, uy = static_cast<long double>(b.y) - a.y;
  const long double vx = static_cast<long double>(q.x) - a.x, vy = static_cast<long double>(q.y) - a.y;
  const long double s = std::clamp((ux * vx + uy * vy) / (ux * ux + uy * uy), 0.0L, 1.0L);
  return std::hypot(vx - s * ux, vy - s * uy);
}

void expect_nearest_hull_edge(const Point2& q, const Location& at, const SortedTriangulation& mesh) {
  const Triangulation& t = mesh.triangulation;
  ASSERT_TRUE(t.is_ghost(triangle_of(at.id)));
  ASSERT_EQ(side_of(at.id), 0u);
  long double nearest = std::numeric_limits<long double>::infinity();
  for (Index g = t.real; g < t.triangles.size(); ++g)
    nearest = std::min(nearest, distance_to_edge(q, mesh.xy[t.triangles[g].v[0]], mesh.xy[t.triangles[g].v[1]]));
  const long double found = distance_to_edge(q, mesh.xy[t.origin(at.id)], mesh.xy[t.target(at.id)]);
  // A point closer to the hull than the rounding of its coordinates may be told the next edge.
  const double rounding = 1e-15 * (std::fabs(q.x) + std::fabs(q.y));
  EXPECT_LE(static_cast<double>(found), static_cast<double>(nearest) * (1 + 1e-9) + rounding) << q.x << " " << q.y;
}

void expect_equal_to_brute_force(const SortedTriangulation& points, const SortedTriangulation& mesh) {
  const Locations found = localise_all(points, mesh);
  ASSERT_EQ(found.size(), points.xy.size());
  expect_equal(localise_all_in_order(points, mesh), found);
  const Points nodes(mesh.xy.begin(), mesh.xy.end());
  const std::vector<Triple> triangles = brute_delaunay(nodes);
  for (std::size_t i = 0; i < points.xy.size(); ++i) {
    const Point2& q = points.xy[i];
    Points expected;
    for (const std::size_t corner : brute_locate(nodes, triangles, q)) expected.push_back(nodes[corner]);
    expected = distinct(expected);
    const Kind kinds[] = {Kind::outside, Kind::node, Kind::edge, Kind::triangle};
    if (mesh.triangulation.real > 0) {
      EXPECT_EQ(found.kind[i], kinds[expected.size()]) << q.x << " " << q.y;
      EXPECT_EQ(corners_of(found[i], mesh), expected) << q.x << " " << q.y;
    }
    if (found.kind[i] == Kind::edge && mesh.triangulation.real > 0) {
      EXPECT_FALSE(mesh.triangulation.is_ghost(triangle_of(found.id[i])));
    }
    if (found.kind[i] == Kind::outside) expect_nearest_hull_edge(q, found[i], mesh);
  }
}

/// Points that ask for every answer: the mesh's own nodes, middles of its edges, points near and far outside.
Points questions(const SortedTriangulation& mesh, std::uint64_t seed) {
  Random random(seed);
  Points asked(mesh.xy.begin(), mesh.xy.end());
  const std::size_t n = asked.size();
  Box2 box;
  for (const Point2& p : mesh.xy) box.add(p);
  const double w = box.max.x - box.min.x, h = box.max.y - box.min.y;
  for (std::size_t i = 0; i < 3 * n; ++i) {
    const Point2 &p = asked[random.below(n)], &q = asked[random.below(n)];
    asked.push_back({(p.x + q.x) / 2, (p.y + q.y) / 2});
    asked.push_back({box.min.x + w * random.uniform(-0.5, 1.5), box.min.y + h * random.uniform(-0.5, 1.5)});
  }
  return asked;
}

class LocaliseFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, LocaliseFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(LocaliseFamilies, EqualsBruteForce) {
  for (const std::size_t n : {2, 3, 4, 5, 9, 30})
    for (std::uint64_t seed = 1; seed <= (n < 10 ? 10 : 2); ++seed) {
      const SortedTriangulation mesh = triangulate_unsorted(GetParam().make(n, 80 + seed), {});
      if (mesh.xy.size() < 2) continue;
      expect_equal_to_brute_force(triangulate_unsorted(questions(mesh, seed), {}), mesh);
    }
}

TEST_P(LocaliseFamilies, EqualsBruteForceForNodesOfTheSameFamily) {
  const SortedTriangulation mesh = triangulate_unsorted(GetParam().make(40, 81), {});
  const SortedTriangulation points = triangulate_unsorted(GetParam().make(200, 82), {});
  expect_equal_to_brute_force(points, mesh);
}

TEST_P(LocaliseFamilies, OwnNodesAreOnNode) {
  const SortedTriangulation mesh = triangulate_unsorted(GetParam().make(20000, 83), {});
  const Locations found = localise_all(mesh, mesh);
  for (std::size_t i = 0; i < found.size(); ++i) ASSERT_EQ(found[i], (Location{Kind::node, static_cast<Index>(i)}));
}

TEST_P(LocaliseFamilies, IsTheSameForAnyNumberOfThreads) {
  const SortedTriangulation mesh = triangulate_unsorted(GetParam().make(5000, 84), {});
  const SortedTriangulation points = triangulate_unsorted(GetParam().make(80000, 85), {});
  const Locations expected = localise_all(points, mesh);
  const std::uint64_t visited_in_order = localise_all_in_order(points, mesh).visited;
  for (const int threads : {1, 2, 7})
    run_with_threads(threads, [&] {
      const Locations found = localise_all(points, mesh);
      EXPECT_EQ(found.kind, expected.kind) << threads;
      EXPECT_EQ(found.id, expected.id) << threads;
      EXPECT_EQ(found.visited, expected.visited) << threads;
      const Locations ordered = localise_all_in_order(points, mesh);
      expect_equal(ordered, expected);
      EXPECT_EQ(ordered.visited, visited_in_order) << threads;
    });
}

// Runs and blocks of every size, most of them not full.
TEST_P(LocaliseFamilies, IsTheSameAlongTheTreeAndInOrderForAnyNumberOfPoints) {
  const SortedTriangulation mesh = triangulate_unsorted(GetParam().make(3000, 89), {});
  for (const std::size_t n : {1, 2, 63, 64, 65, 129, 5000, 100000}) {
    const SortedTriangulation points = triangulate_unsorted(GetParam().make(n, 90), {});
    expect_equal(localise_all_in_order(points, mesh), localise_all(points, mesh));
  }
}

// The order of the points costs time, never the answer.
TEST_P(LocaliseFamilies, InOrderTakesAnyOrder) {
  const SortedTriangulation mesh = triangulate_unsorted(GetParam().make(2000, 91), {});
  const SortedTriangulation points = triangulate_unsorted(questions(mesh, 92), {});
  const Locations expected = localise_all_in_order(points, mesh);
  std::vector<Index> order(points.xy.size());
  for (Index i = 0; i < order.size(); ++i) order[i] = i;
  Random(93).shuffle(order);
  Points shuffled;
  for (const Index i : order) shuffled.push_back(points.xy[i]);
  const Locations found = localise_in_order(shuffled, mesh.triangulation, mesh.xy, {});
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(found[i], expected[order[i]]) << i;
}

TEST(Localise, SaysAtWhichEndOfTheRangeItIs) {
  const SortedTriangulation none = triangulate_unsorted(Points{}, {});
  const SortedTriangulation one = triangulate_unsorted(Points{{1, 1}}, {});
  const SortedTriangulation points = triangulate_unsorted(Points{{1, 1}, {2, 3}, {0, 5}}, {});
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(localise_all(points, none)[i], Location{});
    const Kind kind = points.xy[i] == Point2{1, 1} ? Kind::node : Kind::outside;
    EXPECT_EQ(localise_all(points, one)[i], (Location{kind, 0}));
  }
  EXPECT_EQ(localise_all(none, points).size(), 0u);
  EXPECT_EQ(localise_all_in_order(none, points).size(), 0u);
}

TEST(Localise, OnCollinearNodesTellsNodeEdgeAndOutside) {
  const SortedTriangulation mesh = triangulate_unsorted(Points{{0, 0}, {2, 4}, {5, 10}, {3, 6}}, {});
  const SortedTriangulation points =
      triangulate_unsorted(Points{{0, 0}, {1, 2}, {4, 8}, {3, 6}, {-1, -2}, {6, 12}, {2, 5}, {4, 7}, {5, 10}}, {});
  const Locations found = localise_all(points, mesh);
  for (std::size_t i = 0; i < points.xy.size(); ++i) {
    const Point2& q = points.xy[i];
    const bool on_line = q.y == 2 * q.x && q.x >= 0 && q.x <= 5, on_node = q.x == 0 || q.x == 3 || q.x == 5 || q.x == 2;
    EXPECT_EQ(found.kind[i], !on_line ? Kind::outside : on_node ? Kind::node : Kind::edge) << q.x << " " << q.y;
    if (found.kind[i] == Kind::edge) {
      EXPECT_EQ(corners_of(found[i], mesh), q.x == 1 ? (Points{{0, 0}, {2, 4}}) : (Points{{3, 6}, {5, 10}}));
    }
    if (found.kind[i] == Kind::outside) expect_nearest_hull_edge(q, found[i], mesh);
  }
}

// One ulp decides between inside, on the edge and outside.
TEST(Localise, IsExactAtTheHull) {
  const SortedTriangulation mesh = triangulate_unsorted(Points{{0, 0}, {3, 1}, {0, 1}}, {});
  const Point2 on{1.5, 0.5};
  const Point2 inside{1.5, std::nextafter(0.5, 1)}, outside{1.5, std::nextafter(0.5, 0)};
  const SortedTriangulation points = triangulate_unsorted(Points{on, inside, outside}, {});
  const Locations found = localise_all(points, mesh);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(found.kind[i], points.xy[i] == on ? Kind::edge : points.xy[i] == inside ? Kind::triangle : Kind::outside);
}

// Theorem 1 of the paper: for uniform nodes the work per node does not grow with their number.
TEST(Localise, VisitsAConstantNumberOfTrianglesPerUniformNode) {
  for (const auto localise_by : {localise_all, localise_all_in_order}) {
    double per_node[2];
    for (int i = 0; i < 2; ++i) {
      const std::size_t n = i == 0 ? 5000 : 80000;
      const SortedTriangulation a = triangulate_unsorted(uniform(n, 86), {}),
                                b = triangulate_unsorted(uniform(n, 87), {});
      per_node[i] = static_cast<double>(localise_by(a, b).visited) / static_cast<double>(n);
    }
    EXPECT_LT(per_node[1], 1.1 * per_node[0]);
    EXPECT_GT(per_node[1], 1);
    EXPECT_LT(per_node[1], 10);
  }
}

void expect_three_outside(double scale) {
  const auto scaled = [&](Points points) {
    for (Point2& p : points) p = {p.x * scale, p.y * scale};
    return triangulate_unsorted(points, {});
  };
  const SortedTriangulation mesh = scaled(uniform(50, 88));
  const Locations found = localise_all(scaled(Points{{2, 2}, {0.5, 0.5}, {-1, 0.5}, {0.5, -9}}), mesh);
  EXPECT_EQ(std::count(found.kind.begin(), found.kind.end(), Kind::outside), 3) << scale;
}

TEST(Localise, EndsForCoordinatesWhoseProductsOverflow) { expect_three_outside(1e200); }
TEST(Localise, EndsForSmallCoordinates) { expect_three_outside(1e-150); }
// The foot on a hull edge is a product of two lengths: 0 for all edges when they are this small.
TEST(Localise, EndsForCoordinatesWhoseProductsUnderflow) { expect_three_outside(1e-200); }

}  // namespace
}  // namespace isopach::test
