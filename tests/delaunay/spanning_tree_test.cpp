// Laws of the Euclidean minimum spanning tree: its weight is Prim's on the complete graph, it walks from parents to
// children, its edges are Delaunay edges.
#include "isopach/delaunay/spanning_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

using Edges = std::set<std::pair<Index, Index>>;

Edges edges_of(const SpanningTree& tree) {
  Edges edges;
  for (std::size_t place = 1; place < tree.order.size(); ++place)
    edges.insert(std::minmax(tree.order[place], tree.order[tree.parent[place]]));
  return edges;
}

/// Kruskal on all Delaunay edges, sorted by rounded squared length and then by the curve order of their ends.
Edges kruskal(const Triangulation& t, std::span<const Point2> xy) {
  std::vector<std::tuple<double, Index, Index>> all;
  for (Index i = 0; i < t.triangles.size(); ++i)
    for (Index k = 0; k < (t.is_ghost(i) ? 1u : 3u); ++k) {
      const auto [a, b] = std::minmax({t.origin(half_edge(i, k)), t.target(half_edge(i, k))});
      const double dx = xy[b].x - xy[a].x, dy = xy[b].y - xy[a].y;
      all.emplace_back(dx * dx + dy * dy, a, b);
    }
  std::sort(all.begin(), all.end());
  std::vector<Index> above(t.nodes);
  for (Index v = 0; v < t.nodes; ++v) above[v] = v;
  const auto root = [&](Index v) {
    while (above[v] != v) v = above[v] = above[above[v]];
    return v;
  };
  Edges chosen;
  for (const auto& [length, a, b] : all) {
    if (root(a) == root(b)) continue;
    above[root(a)] = root(b);
    chosen.insert({a, b});
  }
  return chosen;
}

/// The same triangulation with its triangles in random order, ghosts last.
Triangulation renumbered(const Triangulation& t, std::uint64_t seed) {
  std::vector<Index> from, ghosts;
  for (Index i = 0; i < t.triangles.size(); ++i) (t.is_ghost(i) ? ghosts : from).push_back(i);
  Random random(seed);
  random.shuffle(from);
  random.shuffle(ghosts);
  from.insert(from.end(), ghosts.begin(), ghosts.end());
  std::vector<Index> to(from.size());
  for (Index i = 0; i < from.size(); ++i) to[from[i]] = i;
  Triangulation other = t;
  for (Index i = 0; i < from.size(); ++i) {
    other.triangles[i] = t.triangles[from[i]];
    for (HalfEdge& h : other.triangles[i].n) h = half_edge(to[triangle_of(h)], side_of(h));
  }
  return other;
}

long double weight(const SpanningTree& tree, std::span<const Point2> xy) {
  long double sum = 0;
  for (std::size_t place = 1; place < tree.order.size(); ++place) {
    const Point2 &p = xy[tree.order[place]], &q = xy[tree.order[tree.parent[place]]];
    const long double dx = static_cast<long double>(p.x) - q.x, dy = static_cast<long double>(p.y) - q.y;
    sum += std::sqrt(dx * dx + dy * dy);
  }
  return sum;
}

class SpanningTreeFamilies : public testing::TestWithParam<Family> {
 protected:
  static SortedTriangulation make(std::size_t n, std::uint64_t seed) {
    return triangulate_unsorted(GetParam().make(n, seed), {});
  }
};
INSTANTIATE_TEST_SUITE_P(All, SpanningTreeFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(SpanningTreeFamilies, WeighsAsMuchAsPrims) {
  for (const std::size_t n : {1, 2, 3, 4, 5, 10, 50, 1000}) {
    const SortedTriangulation s = make(n, 71);
    const long double expected = prim_weight(Points(s.xy.begin(), s.xy.end()));
    EXPECT_NEAR(static_cast<double>(weight(spanning_tree(s.triangulation, s.xy, {}), s.xy)),
                static_cast<double>(expected), 1e-12 * static_cast<double>(expected))
        << n;
  }
}

TEST_P(SpanningTreeFamilies, HoldsEveryNodeOnceParentsFirst) {
  const SortedTriangulation s = make(5000, 72);
  const SpanningTree tree = spanning_tree(s.triangulation, s.xy, {});
  ASSERT_EQ(tree.order.size(), s.xy.size());
  ASSERT_EQ(tree.parent.size(), s.xy.size());
  std::set<Index> seen(tree.order.begin(), tree.order.end());
  EXPECT_EQ(seen.size(), s.xy.size());
  EXPECT_EQ(*seen.rbegin(), s.xy.size() - 1);
  EXPECT_EQ(tree.order[0], 0u);
  EXPECT_EQ(tree.parent[0], no_index);
  for (std::size_t place = 1; place < tree.parent.size(); ++place) ASSERT_LT(tree.parent[place], place);
}

TEST_P(SpanningTreeFamilies, HasDelaunayEdgesOnly) {
  const SortedTriangulation s = make(2000, 73);
  const Triangulation& t = s.triangulation;
  std::set<std::pair<Index, Index>> edges;
  for (Index i = 0; i < t.triangles.size(); ++i)
    for (Index k = 0; k < 3; ++k) edges.insert({t.origin(half_edge(i, k)), t.target(half_edge(i, k))});
  const SpanningTree tree = spanning_tree(t, s.xy, {});
  for (std::size_t place = 1; place < tree.order.size(); ++place)
    ASSERT_EQ(edges.count({tree.order[place], tree.order[tree.parent[place]]}), 1u) << place;
}

// Ties included: the tree is unique in the total order of the edges. Sizes at and beyond the blocks that are contracted
// each for itself.
TEST_P(SpanningTreeFamilies, EqualsKruskals) {
  for (const std::size_t n : {2, 3, 7, 100, 8191, 8192, 8193, 16385, 30000}) {
    const SortedTriangulation s = make(n, 77);
    EXPECT_EQ(edges_of(spanning_tree(s.triangulation, s.xy, {})), kruskal(s.triangulation, s.xy)) << n;
  }
}

// The numbering of the triangles costs time, never the tree.
TEST_P(SpanningTreeFamilies, DoesNotDependOnTheNumberingOfTriangles) {
  const SortedTriangulation s = make(20000, 78);
  const Edges expected = edges_of(spanning_tree(s.triangulation, s.xy, {}));
  EXPECT_EQ(edges_of(spanning_tree(renumbered(s.triangulation, 79), s.xy, {})), expected);
}

TEST_P(SpanningTreeFamilies, IsAFunctionOfThePointSetAndNotOfThreads) {
  Points points = GetParam().make(20000, 74);
  const SortedTriangulation s = triangulate_unsorted(points, {});
  const SpanningTree expected = spanning_tree(s.triangulation, s.xy, {});
  Random(75).shuffle(points);
  for (const int threads : {1, 2, 7})
    run_with_threads(threads, [&] {
      const SortedTriangulation again = triangulate_unsorted(points, {});
      const SpanningTree tree = spanning_tree(again.triangulation, again.xy, {});
      EXPECT_EQ(tree.order, expected.order) << threads;
      EXPECT_EQ(tree.parent, expected.parent) << threads;
    });
}

TEST(SpanningTree, OfNoNodeIsEmptyAndOfOneNodeTheRoot) {
  EXPECT_TRUE(spanning_tree({}, {}, {}).order.empty());
  const SortedTriangulation one = triangulate_unsorted(Points{{1, 2}}, {});
  const SpanningTree tree = spanning_tree(one.triangulation, one.xy, {});
  ASSERT_EQ(tree.order.size(), 1u);
  EXPECT_EQ(tree.parent[0], no_index);
}

TEST(SpanningTree, SpansPointsWhoseSquaredDistancesUnderflowOrOverflow) {
  for (const double scale : {1e-200, 1e200}) {
    Points points = uniform(200, 76);
    for (Point2& p : points) p = {p.x * scale, p.y * scale};
    const SortedTriangulation s = triangulate_unsorted(points, {});
    const SpanningTree tree = spanning_tree(s.triangulation, s.xy, {});
    EXPECT_EQ(std::set<Index>(tree.order.begin(), tree.order.end()).size(), s.xy.size());
  }
}

}  // namespace
}  // namespace isopach::test
