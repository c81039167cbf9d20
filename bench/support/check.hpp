// Is what was timed also right?
#pragma once
#include <cstddef>
#include <string>

#include "isopach/delaunay/triangulate.hpp"

namespace isopach::bench {

/// Edges of a triangulation, ghosts' own sides not counted.
[[nodiscard]] std::size_t edges(const Triangulation& t);

/// "right" if the exact validator finds nothing wrong, else what it says.
[[nodiscard]] std::string verdict(const SortedTriangulation& s);

/// The same, and the number of edges must be that of the rival.
[[nodiscard]] std::string verdict(const SortedTriangulation& s, std::size_t edges_of_rival);

}  // namespace isopach::bench
