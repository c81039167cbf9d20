// SurfaceCurrent: a triangulated surface as a current: the centroid and the area-weighted normal of each triangle.
#pragma once
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/measure/currents/currents.hpp"
#include "isopach/measure/source.hpp"

namespace isopach {

/// Frame coordinates; normals point up (along the direction), their length is the area of the triangle in space.
struct SurfaceCurrent {
  Array<Point3> centroids, normals;
  double mean_edge = 0;  ///< of the sides of these triangles in space; 0 if there is none
  [[nodiscard]] Current view() const { return {centroids, normals}; }
};

/// The real triangles of `t` whose flag in `kept` is set (empty: all), in their order, but those that are no more than
/// a line in the plane (lower than 10⁻⁶ of their longest side): rounding makes them of nodes on a line. Of a triangle
/// that `domain` cuts, the part inside counts: one centroid, the normal by its share of the area; mean_edge
/// is of whole triangles. Cost O(triangles). The same bits for any number of threads. Oracle:
/// tests/measure/current_test.cpp.
[[nodiscard]] SurfaceCurrent surface_current(const Triangulation& t, std::span<const Point2> xy,
                                             std::span<const double> z, std::span<const unsigned char> kept,
                                             const Domain& domain = Domain::everything());

/// A width of the kernel where none is given: five mean edges of the surface with the longer ones. 0 if there is none.
[[nodiscard]] double default_sigma(const SurfaceCurrent& a, const SurfaceCurrent& b);

}  // namespace isopach
