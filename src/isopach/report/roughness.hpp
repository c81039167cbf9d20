// What `isopach roughness` writes and prints. Computes nothing that is not in Roughness already.
#pragma once
#include <string>
#include <vector>

#include "isopach/apps/roughness.hpp"
#include "isopach/report/page/words.hpp"
#include "isopach/report/report.hpp"

namespace isopach {

/// Schema isopach.roughness/1: no NaN, shortest round-trip numbers, two-space indent; null for what there is not.
[[nodiscard]] std::string roughness_json(const Roughness& r, const std::vector<std::string>& outputs);

/// Aligned lines with units, warnings last. Ends with a newline; no colours.
[[nodiscard]] std::string roughness_text(const Roughness& r);

/// One line a wrinkle of the first scan, numbers in shortest round-trip form; beside a second scan, its depth there.
[[nodiscard]] std::string wrinkles_csv(const Roughness& r);

/// The points of a file with waviness, roughness, valley and wrinkle; format by extension (see write_cloud).
void write_roughness_points(const std::string& path, const CloudView& cloud, const Texture& texture,
                            const Context& context);

/// Maps of one scan: its roughness, or the valleys that wrinkles are looked for in, with the wrinkles' lines and
/// numbers.
void write_roughness_map(const std::string& path, const Roughness& r, const Texture& texture, const MapOptions& look,
                         const Context& context);
void write_wrinkle_map(const std::string& path, const Roughness& r, const Texture& texture, const MapOptions& look,
                       const Context& context);

/// A picture of the page, already written.
struct ReportPicture {
  std::string path, caption;
};

/// report.html: every number is read from `json`, the text of roughness_json. `look`: of the view, as of the maps.
void write_roughness_html(const std::string& path, const Roughness& r, const std::vector<ReportPicture>& pictures,
                          const std::string& json, const MapOptions& look, const Context& context);

/// "plane removed, waviness longer than 8 mm removed", for people.
[[nodiscard]] std::string removed_text(const Roughness& r, Typography typography);

[[nodiscard]] const char* to_text(FormKind form);
[[nodiscard]] const char* to_text(MeanFilter filter);

/// The parameters by their names in result.json, with the power of the unit (0: none) and what they say.
struct ParameterName {
  const char* key;
  const char* symbol;
  double ArealParameters::*value;
  int power;
  const char* meaning;
};
[[nodiscard]] const std::vector<ParameterName>& parameter_names();

}  // namespace isopach
