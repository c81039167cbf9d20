// Triangulation: flat arrays, no coordinates. The numbering:
//
//          v[2]
//          /  \            triangle t has corners v[0], v[1], v[2], counter-clockwise.
//    n[2] /    \ n[1]      side k runs from v[k] to v[(k+1)%3]; half-edge h = 4·t + k.
//        /  t   \          n[k] is the half-edge on the other side of side k (its twin).
//      v[0] ---- v[1]
//          n[0]
//
// Triangles [0, real) are real. Triangles [real, size) are ghosts, one per hull edge: for the hull edge a→b (interior
// on its left) the ghost is (b, a, none), its side 0 is b→a, its side 1 leads to the ghost of the hull edge that ends
// at a and its side 2 to the ghost of the one that starts at b. So every side of every triangle has a twin, and a walk
// that leaves the hull is told where it left. A set of collinear nodes has no real triangle, only ghosts: one per side
// of each of its edges. Fewer than 2 nodes have no triangles at all.
//
// Why flat arrays and not pointers: 24 bytes a triangle, the same bits on every machine, order along the curve.
// Why ghosts and not "none" at the hull: the build glues them in place (no allocation), and outside has an address.
#pragma once
#include <array>
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/base/types.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

struct Triangle {
  std::array<Index, 3> v;  ///< nodes, counter-clockwise; v[2] == no_index in a ghost
  std::array<Index, 3> n;  ///< twins as half-edges 4·triangle + side
};

using HalfEdge = Index;
[[nodiscard]] constexpr Index triangle_of(HalfEdge h) { return h >> 2; }
[[nodiscard]] constexpr Index side_of(HalfEdge h) { return h & 3; }
[[nodiscard]] constexpr HalfEdge half_edge(Index triangle, Index side) { return 4 * triangle + side; }
[[nodiscard]] constexpr Index next_side(Index side) { return side == 2 ? 0 : side + 1; }
[[nodiscard]] constexpr Index previous_side(Index side) { return side == 0 ? 2 : side - 1; }

struct Triangulation {
  Array<Triangle> triangles;  ///< real ones first, then ghosts
  Index real = 0;             ///< number of real triangles
  Index nodes = 0;            ///< number of nodes triangulated

  [[nodiscard]] bool is_ghost(Index t) const { return t >= real; }
  [[nodiscard]] Index ghosts() const { return static_cast<Index>(triangles.size()) - real; }
  [[nodiscard]] HalfEdge twin(HalfEdge h) const { return triangles[triangle_of(h)].n[side_of(h)]; }
  /// The half-edge that leaves the same node next, counter-clockwise.
  [[nodiscard]] HalfEdge next_leaving(HalfEdge h) const {
    return twin(half_edge(triangle_of(h), previous_side(side_of(h))));
  }
  [[nodiscard]] Index origin(HalfEdge h) const { return triangles[triangle_of(h)].v[side_of(h)]; }
  [[nodiscard]] Index target(HalfEdge h) const { return triangles[triangle_of(h)].v[next_side(side_of(h))]; }
};

/// Nodes of the convex hull, counter-clockwise, collinear ones included; starts at the lexicographically least node.
/// For collinear nodes: there and back again.
[[nodiscard]] Array<Index> hull_nodes(const Triangulation& t, std::span<const Point2> xy);

}  // namespace isopach
