// The outputs of a comparison before which B was moved on A.
#pragma once
#include "cli/output.hpp"
#include "isopach/match/matching.hpp"

namespace isopach::cli {

/// deliver() of cli/output.hpp, which also says how B was moved; `matched` may be null.
void deliver(Comparison& comparison, const Cloud& a, const Cloud& b, const std::optional<Truth>& truth,
             const Delivery& delivery, OutputFolder* folder, double read_s, Run& run, const Matching* matched);

}  // namespace isopach::cli
