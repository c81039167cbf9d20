// gather_ghosts: the last step of whatever builds a triangulation in slots along the curve.
#pragma once
#include "isopach/delaunay/triangulation.hpp"

namespace isopach {

/// Brings the ghosts of `t` to its end and returns the number of real triangles. `ghost` is any of them. There are few:
/// only they and as many real triangles change their places. Oracle: validate, tests/delaunay.
[[nodiscard]] Index gather_ghosts(Array<Triangle>& t, Index ghost);

}  // namespace isopach
