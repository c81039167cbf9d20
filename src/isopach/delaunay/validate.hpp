// validate: the one checker of a triangulation, used by tests, fuzzing and on demand.
#pragma once
#include <optional>
#include <span>
#include <string>

#include "isopach/delaunay/triangulation.hpp"

namespace isopach {

/// Nothing if `t` is *the* Delaunay triangulation of xy (exact, every edge, tie rule included), else what is wrong.
/// Checks: twins, ghosts, orientation of every triangle, the tie-broken in-circle test on every edge, convexity of the
/// hull, every node used, 2n − 2 triangles. Cost O(n).
[[nodiscard]] std::optional<std::string> validate(const Triangulation& t, std::span<const Point2> xy);

}  // namespace isopach
