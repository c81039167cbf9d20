// comparison_text: the summary that `isopach compare` prints.
#pragma once
#include <optional>
#include <string>

#include "isopach/match/matching.hpp"
#include "isopach/simulate/scene.hpp"

namespace isopach {

/// About fifteen aligned lines: the result in a sentence, the inputs, the numbers with units, the truth where it is
/// known, warnings last; first how B was moved on A, where it was (`matched`, may be null). Ends with a newline; no
/// colours.
[[nodiscard]] std::string comparison_text(const Comparison& c, const std::optional<Truth>& truth,
                                          const Matching* matched = nullptr);

}  // namespace isopach
