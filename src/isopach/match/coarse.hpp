// coarse_start: a first pose from any rotation about the projection direction and any shift with enough overlap.
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/match/matching.hpp"

namespace isopach {

/// T_fixed_moving, input coordinates, near enough for match() to converge from. Deterministic by context.seed. Throws
/// OverlapError where no pose is supported by the data.
[[nodiscard]] Pose coarse_start(const Cloud& moving, const Cloud& fixed, const MatchOptions& options,
                                const Context& context);

}  // namespace isopach
