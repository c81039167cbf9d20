// ICP of large scans: by means of their points first, and where these tell as much as the points do, by them alone.
#pragma once
#include "isopach/match/pairs/icp_search.hpp"

namespace isopach {

/// Clouds that a search looked at, and what it found.
struct IcpFound {
  OrientedCloud moving, fixed;
  Array<Index> of_point;  ///< which point of `moving` each ordered point of MOVING is, or is part of
  IcpState state;
};

/// icp_search of ordered points, which it orients. Objectives icp_plane and icp_gicp: scans of more than 16384 points
/// are taken as means_of() so many at most, until a step is below 0.03 standard deviations of the pose as if residuals
/// were independent. Unless means_suffice(), the search then goes on with all points from there. Test:
/// tests/match/means_test.cpp.
[[nodiscard]] IcpFound find_by_pairs(OrientedCloud moving, OrientedCloud fixed, const MatchOptions& options,
                                     const Context& context);

/// Whether all points would tell little more of the pose than the means that it was found by. A mean is less noisy than
/// a point, so that few means tell as much as many points, unless the surface has detail finer than the bricks: that
/// lies between means like noise. What a scan tells is counted as its number over the square of the lower third of the
/// distances from planes, of 1024 points and of their means; three times as much is little where the scans have change
/// or errors in common parts: where runs of 128 means pull eight times as much as they would independently. `fixed`
/// gets its boxes. Cost O(n), and 1024 normals.
[[nodiscard]] bool means_suffice(const OrientedCloud& moving, OrientedCloud& fixed, const IcpFound& by_means,
                                 PairKind kind);

}  // namespace isopach
