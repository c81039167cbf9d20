// What `isopach combine` writes and prints. Computes nothing that is not in Combination already.
#pragma once
#include <string>
#include <vector>

#include "isopach/apps/combine.hpp"

namespace isopach {

/// Schema isopach.combine/1: no NaN, shortest round-trip numbers; null for what is not known.
[[nodiscard]] std::string combine_json(const Combination& c, const std::vector<std::string>& outputs);

/// Aligned lines with units, warnings last. Ends with a newline; no colours.
[[nodiscard]] std::string combine_text(const Combination& c);

/// report.html: the poses, how sure they are, the model from two sides; opens from disk without a network and without a
/// script. `json` is the text of combine_json.
[[nodiscard]] std::string combine_html(const Combination& c, const std::string& json, const Context& context);

/// combined.ply: the points of both scans in face coordinates with `part`: 0 face, 1 jaw, 2 and 3 the reference object
/// as seen in the face and in the jaw scan.
void write_combined(const std::string& path, const Combination& c, const Context& context);

}  // namespace isopach
