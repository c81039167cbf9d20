// icp: iterative closest points in space: the paper's equations (1) point-to-point and (3) point-to-plane, and plane to
// plane [Segal2009].
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/match/matching.hpp"

namespace isopach {

/// From `start`, by options.objective (one of_pairs()). Fills pose, iterations, converged, reason, history,
/// overlap, covariance, centre, weak_directions and stable of the result; the rest is match()'s.
[[nodiscard]] Matching icp(const CloudView& moving, const CloudView& fixed, const Pose& start,
                           const MatchOptions& options, const Context& context);

}  // namespace isopach
