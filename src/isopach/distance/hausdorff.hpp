// hausdorff: how far the farthest point of one surface is from the other, between two proven bounds.
//
// Branch and bound over the triangles of the surface. From below: the distance at any of its points. From above: the
// distance to one triangle S of the other surface is convex, so on a triangle it is largest at a corner, and the other
// surface is no farther away than S. Where the bounds are too far apart the triangle is cut, by turns along a side of S
// (what is left over S then has equal bounds) and across its longest edge (so that pieces shrink whatever happens).
#pragma once
#include <cstdint>

#include "isopach/distance/surface_tree.hpp"

namespace isopach {

struct HausdorffBound {
  double lower = 0, upper = 0;  ///< the true distance is in [lower, upper]
  Point3 at{0, 0, 0};           ///< where `lower` is attained, frame coordinates
  std::uint64_t pieces = 0;     ///< triangles looked at, cut ones included
};

/// What rounding may do to a distance between points of these surfaces; it is part of every bound below.
[[nodiscard]] double distance_rounding(const Mesh& a, const Mesh& b);

/// max over the surface `from` of the distance to `to`, upper − lower ≤ tolerance. Errors: UsageError if the tolerance
/// is less than 4 times distance_rounding; Error (not converged) after `most_pieces`. The same bits for any number of
/// threads. Cost: a closest point for each node, then what refinement takes: little where the maximum is a point, as
/// much as an overlay of both surfaces where the distance is the same everywhere. Oracle:
/// tests/distance/hausdorff_test.cpp.
[[nodiscard]] HausdorffBound directed_hausdorff(const Mesh& from, const SurfaceTree& to, double tolerance,
                                                const Context& context, std::uint64_t most_pieces = 200'000'000);

}  // namespace isopach
