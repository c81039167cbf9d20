// How sure the pose of ICP is: the sandwich of clusters.hpp over its pairs.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "isopach/match/pairs/icp_search.hpp"
#include "isopach/match/surface/search.hpp"

namespace isopach {

/// Puts covariance (axes of the frame, about information.centre), undetermined and weak directions of the pose that
/// `found` ended at into `result`.
///
/// Bread: how the pull of the pairs changes with the pose (pull_response). Meat: clustered_scores over runs of points
/// of MOVING, so that neighbouring pairs may share the noise of FIXED. The step that the search left undone is added as
/// an error. Motions that no more than noise of the normals holds (information_floor) are undetermined. Cost O(pairs),
/// and pull_response.
void find_icp_covariance(const IcpState& found, const OrientedCloud& moving, const OrientedCloud& fixed,
                         const MatchOptions& options, const std::array<std::string, 3>& axes, SearchResult& result);

}  // namespace isopach
