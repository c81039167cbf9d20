// triangulate_union: the common triangulation T by the cheapest of three ways: one mesh inserted into the other, both
// merged in linear time, or all nodes triangulated from scratch. All three give the same triangles.
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/merge.hpp"

namespace isopach {

enum class UnionMethod { insertion, merging, scratch };

/// What the choice depends on. A run is a sequence of nodes of one mesh alone on the curve, shared nodes apart: sets
/// that lie apart have few runs, sets of the same ground about as many as nodes.
struct UnionShape {
  std::size_t nodes = 0;     ///< of the union
  std::size_t inserted = 0;  ///< of them, those that the mesh with more nodes lacks
  std::size_t outside = 0;   ///< of these, those that lie outside of its hull
  std::size_t runs = 0;
};

/// Of the union `g` of the nodes of two meshes. Cost O(n).
[[nodiscard]] UnionShape shape_of(const MeshToMerge& m1, const MeshToMerge& m2, const UnitedNodes& g);

/// The way that is expected to be the cheapest, by the table in docs/method/localisation.md, section 4.
[[nodiscard]] UnionMethod cheapest(const UnionShape& shape);

/// Whether it is the first mesh that the other's nodes are inserted into: the one of more nodes, of equal ones the one
/// that has the first node on the curve that is not shared; so it does not matter which was named first.
[[nodiscard]] bool is_first_extended(const UnitedNodes& g, std::size_t n1, std::size_t n2);

/// The Delaunay triangulation of the united nodes `g`, equal to triangulate(g.xy) triangle by triangle; numbered along
/// the curve, real triangles first, but how depends on the way. The meshes given are used up. Where insertion is chosen
/// and proves expensive (see insert), the union is triangulated from scratch. The same bits for any number of threads
/// and for the meshes exchanged. Cost: that of `insert`, `merge` or `triangulate`, and one pass over the nodes.
/// Oracle: triangulate, tests/overlay/triangulate_union_test.cpp.
[[nodiscard]] Triangulation triangulate_union(MeshToMerge m1, MeshToMerge m2, const UnitedNodes& g, const CurveBox& box,
                                              const Context& context);

}  // namespace isopach
