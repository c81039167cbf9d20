// interpolate: heights of one surface at points located in it (docs/method/method.md, section 1).
#pragma once
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach {

/// Height at each located point: the node's own on a node, linear along an edge, linear in a triangle. Outside it is
/// the height at the nearest point of the hull boundary (continuous, no new extrema); callers that must not extrapolate
/// ask Locations::kind. `none` gives NaN. A value never leaves the range of the heights it is made from. On a plane z =
/// a + b·x + c·y the error is at most plane_interpolation_bound · (range of the heights of the triangle). Oracle:
/// tests/overlay/interpolate_test.cpp.
[[nodiscard]] Array<double> interpolate(const Locations& where, std::span<const Point2> points, const Triangulation& t,
                                        std::span<const Point2> xy, std::span<const double> z, const Context& context);

inline constexpr double plane_interpolation_bound = 1e-9;

}  // namespace isopach
