// Changes as objects in JSON. Internal to report/: the header needs nlohmann-json.
#pragma once
#include "isopach/report/page/values.hpp"

namespace isopach::values {

/// The list `changes` of result.json, in input coordinates.
[[nodiscard]] Json changes_json(const Comparison& c);
/// `change_summary`: sums, what was too small, how many there are of which size.
[[nodiscard]] Json change_summary_json(const Comparison& c);

}  // namespace isopach::values
