// Location: where a point lies with respect to a triangulation. A sum type: on a node, on an edge, inside a triangle,
// outside the hull, or nowhere (a triangulation without nodes).
#pragma once
#include "isopach/delaunay/triangulation.hpp"

namespace isopach {

struct Location {
  enum class Kind : unsigned char { node, edge, triangle, outside, none };

  Kind kind = Kind::none;
  /// node: the node. edge: a half-edge of a real triangle on it. triangle: the triangle.
  /// outside: half-edge 0 of the ghost whose hull edge holds the point nearest to it.
  Index id = no_index;

  friend bool operator==(const Location&, const Location&) = default;
};

/// Locations of many points, as two flat arrays (5 bytes a point).
struct Locations {
  Array<Location::Kind> kind;
  Array<Index> id;
  std::uint64_t visited = 0;  ///< triangles visited in all, ghosts included

  [[nodiscard]] Location operator[](std::size_t i) const { return {kind[i], id[i]}; }
  [[nodiscard]] std::size_t size() const { return kind.size(); }
};

}  // namespace isopach
