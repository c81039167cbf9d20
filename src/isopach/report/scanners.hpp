// What `isopach scanners` writes and prints.
#pragma once
#include <string>
#include <vector>

#include "isopach/apps/scanners.hpp"
#include "isopach/report/report.hpp"

namespace isopach {

/// Schema isopach.scanners/1: no NaN, shortest round-trip numbers, two-space indent.
[[nodiscard]] std::string scanners_json(const Scanners& s, const std::vector<std::string>& outputs);
/// Aligned lines with units, warnings last. Ends with a newline; no colours.
[[nodiscard]] std::string scanners_text(const Scanners& s);
/// difference.png: B − A where the reference put both.
void write_scanners_map(const std::string& path, const Scanners& s, const MapOptions& look, const Context& context);
void write_scanners_html(const std::string& path, const Scanners& s, const std::string& map_png,
                         const std::string& json, const MapOptions& look, const Context& context);

}  // namespace isopach
