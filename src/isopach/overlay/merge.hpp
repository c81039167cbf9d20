// merge: the common triangulation T from T1 and T2 in linear time (the paper's section 4, theorem 2).
//
// Words. Colours: the nodes of g1 and of g2; a shared node has both; "pure" is a node of one colour. A triangle of T1
// or T2 survives if its circle holds no node of the other colour; otherwise it is dead. Every other triangle of T joins
// colours: an interface triangle. It has exactly one side whose ends are of one colour, an edge of T1 or T2, on which
// it leans; its two other sides are interface edges. Chains of interface triangles across interface edges are contours.
// The infinite node (third node of every ghost) belongs to both colours, so a contour ends at the hull as at any shared
// node. Related: [Kirkpatrick1979] (merging Voronoi diagrams by contours), [Guibas1985] (the step along a seam).
#pragma once
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach {

/// One of the two meshes to be merged: its triangulation, its nodes and where these lie in the other.
struct MeshToMerge {
  Triangulation triangulation;
  std::span<const Point2> xy;
  const Locations* in_other = nullptr;
};

/// The Delaunay triangulation of the united nodes `g` (ids of g), equal to triangulate(g.xy) triangle by triangle;
/// numbered along the curve, real triangles first. The triangulations given are used up. The same bits for any number
/// of threads and for the meshes exchanged.
/// Cost: O(n) for contours, marks and output, plus for every contour the search of its first edge: the cavity of one
/// node in the other triangulation. Degenerate: a mesh without a real triangle (collinear or fewer than 3 nodes) gives
/// nothing to merge with: the union is triangulated. Oracle: triangulate, tests/overlay/merge_test.cpp.
[[nodiscard]] Triangulation merge(MeshToMerge m1, MeshToMerge m2, const UnitedNodes& g, const CurveBox& box,
                                  const Context& context);

/// The interface triangles of T, ascending: real triangles with nodes of g1 alone *and* nodes of g2 alone.
[[nodiscard]] Array<Index> interface_triangles(const Triangulation& t, const UnitedNodes& g);

}  // namespace isopach
