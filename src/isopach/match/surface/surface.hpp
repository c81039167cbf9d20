// MatchSurface: a scan as the search sees it, in frame coordinates: nodes, triangulation, what its sampling supports,
// and the area each node stands for.
#pragma once
#include <array>
#include <limits>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/overlay/border.hpp"

namespace isopach {

/// What a residual asks of a facet, in one cache line. Slopes of facets carry the noise of three heights over one edge:
/// where the scan is dense that is more than the slope itself. The residual takes the facet as it is, but for its rise;
/// its derivative and its normal take the slope smoothed over the neighbourhood.
struct alignas(64) Facet {
  double x = 0, y = 0;                                  ///< a corner
  double z = std::numeric_limits<double>::quiet_NaN();  ///< its height; NaN: no surface here (not kept, or too thin)
  float gx = 0, gy = 0;                                 ///< slope
  float bx = 0, by = 0, cx = 0, cy = 0;                 ///< gradients of the barycentric coordinates of the others
  float smooth_gx = 0, smooth_gy = 0;  ///< mean over its corners of the mean slope around each, by area
  /// How far the surface lies over the facet, as a mean over it, by the curvature that the mean slopes at its corners
  /// show. A facet lies on the inner side of what is curved, the deeper the longer its edges: without the rise two
  /// scans of different density pull apart.
  float rise = 0;

  [[nodiscard]] bool exists() const { return z == z; }
  /// Barycentric coordinates of the two other corners at (x, y) + (dx, dy), in single precision.
  [[nodiscard]] std::array<float, 2> shares(double dx, double dy) const {
    const auto fx = static_cast<float>(dx), fy = static_cast<float>(dy);
    return {bx * fx + by * fy, cx * fx + cy * fy};
  }
  /// 0 at the corners, 4/3 in the middle, 1 in the mean.
  [[nodiscard]] float bubble(double dx, double dy) const {
    const auto [b, c] = shares(dx, dy);
    return 4 * (b * c + (1 - b - c) * (b + c));
  }
  /// Of the surface: the facet's and the rise, spread as the bubble.
  [[nodiscard]] double height(double px, double py) const {
    const double dx = px - x, dy = py - y;
    const double lift = static_cast<double>(rise * bubble(dx, dy));
    return z + static_cast<double>(gx) * dx + static_cast<double>(gy) * dy + lift;
  }
};

struct MatchSurface {
  Array<Point2> xy;
  Array<double> z;
  Triangulation t;
  Footprint footprint;        ///< triangles that the sampling supports
  Array<double> weight;       ///< by node: a third of the areas of its facets; 0 where it has none
  Array<Facet> facets;        ///< by real triangle
  Array<float> cosine;        ///< by real triangle: of the smoothed slope
  Array<double> mu;           ///< by node: weight of the user, which `weight` holds already; empty: 1
  Array<float> facet_weight;  ///< by real triangle: mean of mu over its corners; empty: 1
};

/// Nodes in curve order of `box`. `trim`, `max_edge` as in overlay/border.hpp. Cost O(n log n).
[[nodiscard]] MatchSurface make_surface(Array<Point2> xy, Array<double> z, const CurveBox& box, bool trim,
                                        double max_edge, const Context& context);

/// The same of what is triangulated already; `kept`: one flag per real triangle, empty if all are. Cost O(n).
[[nodiscard]] MatchSurface make_surface(Array<Point2> xy, Array<double> z, Triangulation t,
                                        const Array<unsigned char>& kept);

/// A weight of 0 or more for each node: the area that it stands for counts so many times, and so does what lies over
/// the facets around it.
void weigh(MatchSurface& s, Array<double> mu);

/// Rise over run at each node, mean of the facets around it by area.
[[nodiscard]] Array<double> steepness(const MatchSurface& s);

/// Standard deviation of the heights about their neighbours, from the median: of the node's height over the mean of the
/// corners of its facets, carried along the mean slope there. It holds what is noise and what the nodes are too few to
/// show, whatever the other scan is. 0 without facets. Cost O(n).
[[nodiscard]] double roughness(const MatchSurface& s);

/// Covariance of the two parts of a slope.
struct SlopeNoise {
  double xx = 0, xy = 0, yy = 0;
};
/// By node: what independent heights of variance 1 make of the mean slope around it. Cost O(n).
/// Test: Surface.NoiseOfSlopes.
[[nodiscard]] Array<SlopeNoise> slope_noise(const MatchSurface& s);

/// The surface through the means of `run` nodes in a row each (they are neighbours: the nodes are in curve order):
/// smoother and `run` times thinner.
[[nodiscard]] MatchSurface thinned(const MatchSurface& s, std::size_t run, bool trim, const Context& context);

}  // namespace isopach
