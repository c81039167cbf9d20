// The weight of a matching: what compare --weight names, at the nodes of the scan that carries it.
#pragma once
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/compare/options.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/match/surface/surface.hpp"

namespace isopach {

/// Gives the surface that carries it the weight of `options`: an attribute belongs to the points of its scan (FIXED is
/// A, MOVING is B, as in compare), a formula and a raster to places of FIXED; both heights of a formula are those of
/// FIXED, and so are both slopes. Nothing where there is no weight. A node without a value (outside a raster) weighs
/// nothing. Errors, naming --weight: as in compare, and a weight that is 0 everywhere. Cost O(nodes).
void apply_weight(const CloudView& moving, const CloudView& fixed, const HeightField& moving_field,
                  const HeightField& fixed_field, const Frame& frame, const CompareOptions& options,
                  MatchSurface& moving_surface, MatchSurface& fixed_surface);

}  // namespace isopach
