// Reports of a comparison before which B was moved on A: those of report.hpp, with how it was moved.
#pragma once
#include "isopach/match/matching.hpp"
#include "isopach/report/report.hpp"

namespace isopach {

/// comparison_json() with the keys `matched` and `verdict`; null where `matched` is null.
[[nodiscard]] std::string comparison_json(const Comparison& c, const std::vector<std::string>& outputs,
                                          const Matching* matched);

/// write_html() that says under the headline how B was moved, if it was.
void write_html(const std::string& path, const Comparison& c, const std::string& map_png, const std::string& json,
                const std::optional<Truth>& truth, const Context& context, const MapOptions& look,
                const Matching* matched);

}  // namespace isopach
