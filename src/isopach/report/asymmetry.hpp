// What `isopach asymmetry` writes and prints. Computes nothing that is not in Asymmetry already.
#pragma once
#include <string>
#include <vector>

#include "isopach/apps/asymmetry.hpp"
#include "isopach/report/report.hpp"

namespace isopach {

/// Schema isopach.asymmetry/1: no NaN, shortest round-trip numbers, two-space indent.
[[nodiscard]] std::string asymmetry_json(const Asymmetry& a, const std::vector<std::string>& outputs);

/// Aligned lines with units, warnings last. Ends with a newline; no colours.
[[nodiscard]] std::string asymmetry_text(const Asymmetry& a);

/// asymmetry.png: the face upright, the plane as a line, the height of each side above the mirrored other one.
void write_asymmetry_map(const std::string& path, const Asymmetry& a, const MapOptions& look, const Context& context);

/// report.html, as write_html; `json` is the text of asymmetry_json, `map_png` the map's path (empty: none).
void write_asymmetry_html(const std::string& path, const Asymmetry& a, const std::string& map_png,
                          const std::string& json, const MapOptions& look, const Context& context);

/// points.ply: the points of the file where they are, with the attribute `asymmetry` (NaN where it is not known).
void write_asymmetry_points(const std::string& path, const CloudView& face, const Asymmetry& a, const Context& context);

}  // namespace isopach
