// Heights of a surface under places in the plane.
#pragma once
#include "isopach/match/surface/surface.hpp"

namespace isopach {

/// Height of `surface` under each place, linear in its triangles; NaN where its sampling supports none. Fast where the
/// places are in curve order. Cost: that of localise_in_order. Test: tests/apps/roughness_test.cpp.
[[nodiscard]] Array<double> heights_below(const Array<Point2>& xy, const MatchSurface& surface, const Context& context);

}  // namespace isopach
