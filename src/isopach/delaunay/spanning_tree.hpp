// spanning_tree: the Euclidean minimum spanning tree, from the Delaunay edges (METHOD stage 2), in walking order.
// Equal lengths are ordered by the lexicographic order of their ends, so the tree is unique too.
#pragma once
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"

namespace isopach {

/// A rooted tree on the nodes. `order` holds every node once, parents before children, near the curve order;
/// `parent[i]` is the parent of node i, no_index for the root order[0].
struct SpanningTree {
  Array<Index> order;
  Array<Index> parent;
};

/// Cost: O(n): the longest edge of every triangle is dropped (cycle rule), then Borůvka rounds with contraction.
/// Degenerate: one node is a tree; none is an empty one. Lengths are compared as rounded squares, ties lexicographically;
/// the weight is that of the minimum spanning tree up to that rounding. Oracle: Prim on the complete graph.
[[nodiscard]] SpanningTree spanning_tree(const Triangulation& t, std::span<const Point2> xy, const Context& context);

}  // namespace isopach
