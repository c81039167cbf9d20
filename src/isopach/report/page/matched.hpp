// result.json of a comparison before which B was moved on A.
#pragma once
#include "isopach/match/matching.hpp"
#include "isopach/report/report.hpp"

namespace isopach {

/// comparison_json() with the keys `matched` and `verdict`; null where `matched` is null.
[[nodiscard]] std::string comparison_json(const Comparison& c, const std::vector<std::string>& outputs,
                                          const Matching* matched);

}  // namespace isopach
