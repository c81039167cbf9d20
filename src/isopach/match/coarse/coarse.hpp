// coarse_start: a first pose from any rotation about the projection direction and any shift with enough overlap.
#pragma once
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/match/matching.hpp"

namespace isopach {

/// T_fixed_moving, input coordinates, near enough for match() to converge from. Deterministic by context.seed. Throws
/// OverlapError where no pose is supported by the data.
[[nodiscard]] Pose coarse_start(const CloudView& moving, const CloudView& fixed, const MatchOptions& options,
                                const Context& context);

/// The best few of the poses that were tried, at most `most`, the best first, each farther than other_turn or
/// other_shift (match/verdict/verdict.hpp) from those before it: where a surface repeats itself, the others are rivals
/// of the first. Cost and errors as coarse_start().
[[nodiscard]] std::vector<Pose> coarse_poses(const CloudView& moving, const CloudView& fixed,
                                             const MatchOptions& options, std::size_t most, const Context& context);

}  // namespace isopach
