// localise: every node of one mesh in the triangulation of the other (docs/method/localisation.md; section 4 of the
// paper).
//
// From the known location of a node M the walk goes to Q, its child in the spanning tree, triangle by triangle: it
// crosses any side that has Q strictly on its other side. The paper's walk follows the segment MQ itself; this one
// (a visibility walk, which in a Delaunay triangulation cannot cycle [Edelsbrunner1989]) starts and ends in the same
// places, needs no case for a node that lies on MQ or an edge that MQ runs along, and visits fewer triangles.
// Outside the hull the walk ends at the ghost whose hull edge is nearest.
#pragma once
#include <limits>
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/spanning_tree.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach {

/// Location of every point of `points` in `t` (nodes `xy`), along `tree`, the spanning tree of the points.
/// Gives one Location per point; exact; the same for any number of threads. Expected O(n) for uniform nodes (theorem
/// 1), quadratic on constructed inputs. The tree's order is cut into runs that are walked side by side; a node whose
/// parent is of an earlier run starts where the node before it lies (a few per cent more triangles). Degenerate: a
/// triangulation of collinear nodes knows node, edge, outside (nearest edge); of one node: node or outside with id 0;
/// of none: none. Oracle: tests/overlay/localise_test.cpp (every triangle tried).
[[nodiscard]] Locations localise(std::span<const Point2> points, const SpanningTree& tree, const Triangulation& t,
                                 std::span<const Point2> xy, const Context& context);

/// The same locations without a tree, in the order of the points, each from where the one before lies. Both arrays of
/// nodes are to be in the order of one curve (see curve_order): then a walk is about a quarter longer than along the
/// tree (3.2 triangles instead of 2.5), and memory is read in order. In any other order the answer is the same and
/// slow. Cost: O(n) expected for uniform nodes, quadratic on constructed inputs, like localise. Oracle: localise.
[[nodiscard]] Locations localise_in_order(std::span<const Point2> points, const Triangulation& t,
                                          std::span<const Point2> xy, const Context& context);

/// Location of one point, walking from triangle (or ghost) `at`, which is left where the walk ended; `visited` grows by
/// the triangles seen. Needs at least one real triangle. Gives up, with kind none, where `visited` has grown to
/// `limit`.
[[nodiscard]] Location locate(const Point2& q, const Triangulation& t, std::span<const Point2> xy, Index& at,
                              std::uint64_t& visited, std::uint64_t limit = std::numeric_limits<std::uint64_t>::max());

}  // namespace isopach
