// MatchSurface: a scan as the search sees it, in frame coordinates: nodes, triangulation, what its sampling supports,
// and the area each node stands for.
#pragma once
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/overlay/border.hpp"

namespace isopach {

/// What a residual asks of a facet. Slopes of facets carry the noise of three heights over one edge: where the scan is
/// dense that is more than the slope itself. The residual takes the facet as it is, its derivative and its normal take
/// the slope smoothed over the neighbourhood.
struct Facet {
  double gx = 0, gy = 0;               ///< slope
  float smooth_gx = 0, smooth_gy = 0;  ///< mean over its corners of the mean slope around each, by area
  float cosine = 0;                    ///< of the smoothed slope; 0: no surface here (not kept, or too thin)
};

struct MatchSurface {
  Array<Point2> xy;
  Array<double> z;
  Triangulation t;
  Footprint footprint;   ///< triangles that the sampling supports
  Array<double> weight;  ///< by node: a third of the areas of its kept triangles; 0 where it has none
  Array<Facet> facets;   ///< by real triangle
};

/// Nodes in curve order of `box`. `trim`, `max_edge` as in overlay/border.hpp. Cost O(n log n).
[[nodiscard]] MatchSurface make_surface(Array<Point2> xy, Array<double> z, const CurveBox& box, bool trim,
                                        double max_edge, const Context& context);

/// The surface through the means of `run` nodes in a row each (they are neighbours: the nodes are in curve order):
/// smoother and `run` times thinner.
[[nodiscard]] MatchSurface thinned(std::span<const Point2> xy, std::span<const double> z, std::size_t run, bool trim,
                                   const Context& context);

}  // namespace isopach
