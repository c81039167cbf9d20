// match(moving, fixed, options): the rigid pose of MOVING that minimises the chosen objective.
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/match/matching.hpp"

namespace isopach {

/// METHOD section 4. Errors: OverlapError when the scans share no area at the start (exit 4), UsageError for options
/// that contradict one another, InputError for scans without usable points. A search that does not converge is a result
/// (converged = false), not an error.
[[nodiscard]] Matching match(const Cloud& moving, const Cloud& fixed, const MatchOptions& options,
                             const Context& context);

}  // namespace isopach
