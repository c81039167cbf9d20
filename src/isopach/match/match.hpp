// match(moving, fixed, options): the rigid pose of MOVING that minimises the chosen objective.
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/match/matching.hpp"

namespace isopach {

/// See docs/method/matching.md. Errors: OverlapError when the scans share no area at the start (exit 4), UsageError for
/// options that contradict one another, InputError for scans without usable points. A search that does not converge is
/// a result (converged = false), not an error; so is a pose that is not trusted (verdict): ask require_trust().
///
/// Unless options.check_pose is off, the pose gets a verdict (match/verdict/verdict.hpp). Where it is doubted, or the
/// scans do not overlap at the start, and all rigid motions are free, a coarse search looks for another place: by
/// icp-plane from there, and by the objective from there unless the verdict falls; the better of the two poses stands.
/// A trusted pose is set beside the other places that a coarse search found, if one ran, and beside those where a scan
/// repeats itself (match/coarse/repeats.hpp): as good, they are rivals (Grade::rival), unless the start lies nearer to
/// the pose than a tenth of the way from there to them.
[[nodiscard]] Matching match(const CloudView& moving, const CloudView& fixed, const MatchOptions& options,
                             const Context& context);

/// only_slides() of the verdict of a matching, if it has one: the warning that the verdict left stays.
[[nodiscard]] bool slides_alone(const Matching& m);

/// require_trust() of the verdict of a matching, if it has one. `option`: how the message begins, e.g. "@match".
void require_trust(const Matching& m, const std::string& option);

}  // namespace isopach
