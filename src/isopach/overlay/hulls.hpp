// Convex hulls as polygons: their areas and the area they share. Reporting only: no decision of the topology.
#pragma once
#include <span>

#include "isopach/delaunay/triangulation.hpp"

namespace isopach {

/// Area inside a polygon (positive when counter-clockwise).
[[nodiscard]] double polygon_area(std::span<const Point2> polygon);

/// Area of the intersection of two convex counter-clockwise polygons: the integral over x of what their lower and upper
/// chains leave free, slab by slab. Cost O(h1 + h2). Degenerate polygons give 0. Oracle: clipping, tests/overlay.
[[nodiscard]] double shared_area(std::span<const Point2> p, std::span<const Point2> q);

}  // namespace isopach
