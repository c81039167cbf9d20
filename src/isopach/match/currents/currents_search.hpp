// currents_search: the motion of the moving surface that minimises the distance of both as currents, equation (5), by
// descent.
//
// ρ(φA, B) = ‖A‖² + ‖B‖² − 2 ⟨φA, B⟩ is smooth in the motion φ, and no pairs are sought. It is descended by
// quasi-Newton steps (BFGS; [Nocedal2006], chapter 6), begun with the matrix 2 ⟨∂A, ∂A⟩ that ρ has where A lies
// on itself. A wide kernel has a wide basin: σ starts at a fifth of the extent and is halved down to options.sigma, on
// surfaces thinned to five edges a σ.
#pragma once
#include <array>
#include <string>

#include "isopach/match/surface/search.hpp"

namespace isopach {

/// As `search`, with options.sigma. `history` of the last width: rho in unit⁴, share 1. Everything takes part: no real
/// change is kept out of the fit, and where one scan reaches beyond the other its border pulls. The covariance is from
/// how unevenly the cubes of the kernel pull at the end. Throws UsageError for a free scale, an overlap or a weight,
/// which currents do not know, and OverlapError where a scan has no triangle or both are out of reach of the widest
/// kernel.
[[nodiscard]] SearchResult currents_search(const MatchSurface& moving, const MatchSurface& fixed,
                                           const MatchOptions& options, const std::array<std::string, 3>& axes,
                                           const Context& context);

}  // namespace isopach
