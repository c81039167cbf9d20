// triangulate: the Delaunay triangulation of points in the plane, a function of the point *set*.
//
// Words. in_circle ties (cocircular points) are broken by lifting the points by infinitesimal heights in lexicographic
// order [Devillers2003], see geom/predicates.hpp. Divide and conquer after [Guibas1985] and
// [Dwyer1987] (alternating cuts), on triangles with ghosts as in [Shewchuk1996]; the cuts are read off the Hilbert
// keys.
#pragma once
#include <cstdint>
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/geom/curve.hpp"

namespace isopach {

/// Delaunay triangulation of distinct finite points that are in curve order (see curve_order) of `box`.
/// Gives 2n−2 triangles, ghosts included. The same bits for any number of threads.
/// Errors: UsageError if there are more than max_nodes. Degenerate: collinear points give ghosts only; n < 2 gives
/// none. Cost: O(n log n) worst case, no allocation besides the result and 8 bytes a point of keys. Oracle:
/// tests/delaunay (validate, brute force, CGAL).
[[nodiscard]] Triangulation triangulate(std::span<const Point2> xy, const CurveBox& box, const Context& context);

/// The same where the keys of the points are known (curve_key): of them alone it is read how to cut.
[[nodiscard]] Triangulation triangulate(std::span<const Point2> xy, std::span<const std::uint64_t> keys,
                                        const Context& context);

/// The same for points in any order, duplicates allowed. `order[i]` is the input id of node i of the triangulation, the
/// first of its equals; `node_of` maps every input point to its node.
struct SortedTriangulation {
  Triangulation triangulation;
  Array<Point2> xy;
  Array<Index> order;
  Array<Index> node_of;
};
[[nodiscard]] SortedTriangulation triangulate_unsorted(std::span<const Point2> points, const Context& context);

}  // namespace isopach
