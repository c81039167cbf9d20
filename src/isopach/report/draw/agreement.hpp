// agreement.png: the points of a matched scan in place, coloured by what they are to the other one.
#pragma once
#include <string>

#include "isopach/match/matching.hpp"
#include "isopach/report/draw/canvas.hpp"

namespace isopach {

/// The points of MOVING at m.pose, seen along the direction of `frame`, the nearest to the eye on top: what agrees,
/// lies in front or behind (of what FIXED saw), or is not in the view of FIXED. Needs m.agreement. `title` over it; the
/// verdict under that. Width in pixels, 300 to 20000. Errors: UsageError for another width.
[[nodiscard]] Image render_agreement(const CloudView& moving, const Matching& m, const Frame& frame, int width,
                                     const Context& context);
void write_agreement(const std::string& path, const CloudView& moving, const Matching& m, const Frame& frame, int width,
                     const Context& context);

}  // namespace isopach
