// SmoothSurface: heights of a surface that bends, not of chords (`--interpolation cubic`).
#pragma once
#include <array>

#include "isopach/overlay/interpolate.hpp"

namespace isopach {

/// A surface that is cubic about each node. Node i has a polynomial Tᵢ through its height, fitted to its neighbours and
/// theirs by least squares with weights 1 / (r²/h² + 0.1)², h² the mean of r²: cubic with 13 neighbours or more, else
/// quadratic with 7, else a plane; a lower degree, too, where the fit is ill-conditioned (lines, grids too small,
/// repeated directions). In a triangle the surface is w₁T₁ + w₂T₂ + w₃T₃, where wᵢ is the Clough–Tocher piecewise cubic
/// that is 1 at node i and whose gradients at nodes and derivatives across edges are 0. So it passes through the nodes,
/// is C¹ inside the hull, and reproduces cubics wherever the fits are cubic. One limit, where it gives up C¹: a value
/// leaves the range of the heights the three fits have seen by an eighth of it at most, so that cliffs and gaps do not
/// make it swing.
///
/// Source: [Clough1965] for the weights; blending of node functions: [Franke1980]. Oracle:
/// tests/overlay/smooth_test.cpp (cubics, gradients across edges, limits).
class SmoothSurface {
 public:
  /// Fits all nodes. The arrays belong to the caller and stay alive while the surface is used. Cost O(nodes), 96 bytes
  /// a node, and 4 more (8 with 64-bit indices) while it fits. The same bits for any number of threads.
  SmoothSurface(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z, const Context& context);

  /// Height at each located point. Outside, on nodes, and in triangles thinner than rounding: as interpolate.
  /// Cost O(points).
  [[nodiscard]] Array<double> at(const Locations& where, std::span<const Point2> points, const Context& context) const;

  [[nodiscard]] const Triangulation& triangulation() const { return t_; }
  [[nodiscard]] std::span<const Point2> nodes() const { return xy_; }

 private:
  static constexpr unsigned terms = 9;  // x y, xx xy yy, xxx xxy xyy yyy
  struct NodeFunction {
    double scale = 0;  // 1/h; 0: constant
    std::array<double, terms> c{};
    double low = 0, high = 0;  // heights seen, relative to the node's
    [[nodiscard]] double at(double dx, double dy) const;
  };
  [[nodiscard]] static NodeFunction fit(Index node, std::span<const Index> seen, std::span<const Point2> xy,
                                        std::span<const double> z);
  [[nodiscard]] double in_triangle(const Point2& q, const Triangle& t, double linear) const;

  const Triangulation& t_;
  std::span<const Point2> xy_;
  std::span<const double> z_;
  Array<NodeFunction> functions_;  // none where there is no triangle
};

/// SmoothSurface(t, xy, z).at(where, points), for a surface that is asked once.
[[nodiscard]] Array<double> interpolate_smooth(const Locations& where, std::span<const Point2> points,
                                               const Triangulation& t, std::span<const Point2> xy,
                                               std::span<const double> z, const Context& context);

}  // namespace isopach
