// spanning_tree: the Euclidean minimum spanning tree, from the Delaunay edges (docs/method/method.md, section 1), in
// walking order. Equal lengths are ordered by the curve order of their ends, which is a function of the point set, so
// the tree is too.
#pragma once
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"

namespace isopach {

/// A rooted tree on the nodes. `order` holds every node once, parents before children, depth first from node 0, so near
/// the curve order. `parent[p]` is the *place in order* of the parent of order[p] (always < p); parent[0] is no_index.
/// Places and not nodes: what a walk along the tree stores, it stores by place, one after the other.
struct SpanningTree {
  Array<Index> order;
  Array<Index> parent;
};

/// Cost: O(n): the longest edge of every triangle is dropped (cycle rule), then Borůvka rounds with contraction, within
/// blocks of nodes side by side and then on what is left of them. The same bits for any number of threads.
/// Degenerate: one node is a tree; none is an empty one. Lengths are compared as rounded squares, ties by node order;
/// the weight is that of the minimum spanning tree up to that rounding. Oracles: Prim on the complete graph, Kruskal.
[[nodiscard]] SpanningTree spanning_tree(const Triangulation& t, std::span<const Point2> xy, const Context& context);

}  // namespace isopach
