// areal_parameters: the field parameters of ISO 25178-2 [ISO25178], integrated over a surface of triangles in closed
// form.
#pragma once
#include <array>
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/base/types.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// Heights are counted from their mean. Names of ISO 25178-2; sa to sv in the unit of heights, the others without.
struct ArealParameters {
  double area = 0;  ///< evaluated, in the plane
  double mean = 0;  ///< of the heights before it was subtracted
  double sa = 0;    ///< arithmetical mean of |z|
  double sq = 0;    ///< root of the mean of z²
  double sz = 0;    ///< sp + sv
  double sp = 0;    ///< highest measured node
  double sv = 0;    ///< deepest one, as a positive number
  double ssk = 0;   ///< mean of z³ / sq³; 0 where sq is 0
  double sku = 0;   ///< mean of z⁴ / sq⁴; 0 where sq is 0
  double sdr = 0;   ///< area of the surface ÷ its area in the plane − 1
  double sdq = 0;   ///< root of the mean of |grad z|²
  /// Root of the mean of z² over the measured nodes of the triangles, each counted once, z from the mean of these. The
  /// integrals run over triangles, which average the noise of their corners: white noise of 1 has an sq of 0.71 over
  /// plane triangles and of 0.83 over bent ones, and an sq_points of 1. No parameter of ISO 25178-2.
  double sq_points = 0;
};

/// Triangles, counter-clockwise, of nodes with a height.
struct TriangleSurface {
  Array<Point2> xy;
  Array<double> z;
  Array<std::array<Index, 3>> triangles;
  std::size_t measured = 0;  ///< nodes before this one were measured; the others are interpolated, and no peak or pit
};

/// Of the piecewise linear surface, exactly but for rounding: with h_k the complete homogeneous polynomial of the three
/// heights, ∬ zᵏ = 2A k!/(k+2)! h_k over a triangle of area A; |z| by split_volume; slopes are constant on it. Sums are
/// compensated, over fixed blocks. No triangle: zeros. Cost O(triangles). Oracle: quadrature,
/// tests/measure/areal_test.cpp.
[[nodiscard]] ArealParameters areal_parameters(const TriangleSurface& surface, const Context& context);

/// The kept triangles of t (all where `kept` is empty), each cut into pieces² equal ones. New corners lie on the smooth
/// surface through the nodes (overlay/smooth.hpp), so that the surface between the points is not cut off by chords:
/// what that takes from Sa and Sq falls with pieces². `pieces` 1: the triangles as they are.
[[nodiscard]] TriangleSurface refined(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                                      std::span<const unsigned char> kept, unsigned pieces, const Context& context);

}  // namespace isopach
