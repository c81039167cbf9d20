// Flags of triangles and nodes of a part of a triangulation. Internal to tiles/.
#pragma once
#include <array>
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/geom/disc.hpp"
#include "isopach/tiles/part.hpp"

namespace isopach {

using Flags = Array<unsigned char>;

/// By real triangle: whether its closed disc lies in the square.
[[nodiscard]] Flags certified_triangles(const Triangulation& t, std::span<const Point2> xy, const OpenBox& square);

/// By node: whether one of its triangles has no flag, ghosts among them, or it has no triangle at all.
[[nodiscard]] Flags nodes_beside(const Triangulation& t, const Flags& of_triangles);

/// By node: flagged, or the neighbour of one that is.
[[nodiscard]] Flags with_neighbours(const Triangulation& t, const Flags& of_nodes);

/// By node: a half-edge of a real triangle that leaves it, or no_index.
[[nodiscard]] Array<HalfEdge> leaving_nodes(const Triangulation& t);

/// Those of the flagged triangles that holds(triangle, its corners) is true for.
template <class F>
[[nodiscard]] Flags kept_where(const Triangulation& t, const Flags& flags, F&& holds) {
  Flags kept(t.real);
  for_each_index(t.real, [&](std::size_t i) { kept[i] = flags[i] != 0 && holds(i, t.triangles[i].v) ? 1 : 0; });
  return kept;
}

}  // namespace isopach
