// What `isopach distance` writes and prints. Computes nothing that is not in Distances already.
#pragma once
#include <string>
#include <vector>

#include "isopach/distance/distance.hpp"

namespace isopach {

/// Schema isopach.distance/1: no NaN, shortest round-trip numbers, two-space indent; null for what was not measured.
[[nodiscard]] std::string distance_json(const Distances& d, const std::vector<std::string>& outputs);

/// Aligned lines with units, warnings last. Ends with a newline; no colours.
[[nodiscard]] std::string distance_text(const Distances& d);

/// report.html: A coloured by its distance, as a picture and as a view that people turn; figures with units. `a`: the
/// scan that was measured; `json`: the text of distance_json.
[[nodiscard]] std::string distance_html(const Distances& d, const CloudView& a, const std::string& json,
                                        const Context& context);

/// The points of a file with its distances as attributes; format by extension (see write_cloud).
void write_distance_points(const std::string& path, const CloudView& cloud, const std::vector<Attribute>& fields,
                           const Context& context);

/// The core points of M3C2 with distance, lod, significant, sigma1, sigma2, n1, n2, nx, ny, nz.
void write_core_points(const std::string& path, const Distances& d, const Context& context);

}  // namespace isopach
