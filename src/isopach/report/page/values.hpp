// Numbers, points and matrices as JSON. Internal to report/: the header needs nlohmann-json.
#pragma once
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "isopach/base/option_key.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/geom/rigid.hpp"

namespace isopach::values {

using Json = nlohmann::ordered_json;

/// null for NaN and infinities; 0 without a sign.
[[nodiscard]] inline Json real(double value) {
  return std::isfinite(value) ? Json(value == 0 ? 0.0 : value) : Json(nullptr);
}
/// null for what is not known or was not given.
[[nodiscard]] inline Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }
[[nodiscard]] inline Json point(const Point3& p) { return Json::array({real(p.x), real(p.y), real(p.z)}); }

/// A message of the library, with options spelled as at a command line; message_text of words.hpp is its other half.
[[nodiscard]] inline Json message(const std::string& text) { return for_shell(text); }
[[nodiscard]] inline Json messages(const std::vector<std::string>& list) {
  Json out = Json::array();
  for (const std::string& text : list) out.push_back(message(text));
  return out;
}

/// Four rows of four.
[[nodiscard]] inline Json matrix(const Pose& pose) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < 16; i += 4)
    rows.push_back(Json::array({real(pose.m[i]), real(pose.m[i + 1]), real(pose.m[i + 2]), real(pose.m[i + 3])}));
  return rows;
}

/// Six rows of six.
[[nodiscard]] inline Json covariance(const std::array<double, 36>& matrix) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < 6; ++i) {
    Json row = Json::array();
    for (std::size_t j = 0; j < 6; ++j) row.push_back(real(matrix[6 * i + j]));
    rows.push_back(row);
  }
  return rows;
}

/// Seconds by stage, in running order, and in all.
[[nodiscard]] inline Json timing(const Timing& timing) {
  Json out = Json::object();
  for (const auto& [stage, seconds] : timing.stages) out[stage] = real(seconds);
  out["total"] = real(timing.total);
  return out;
}

/// x and y of two corners; null if there is none.
[[nodiscard]] inline Json crop_box(const std::optional<Box2>& corners) {
  if (!corners) return nullptr;
  return Json::array({real(corners->min.x), real(corners->min.y), real(corners->max.x), real(corners->max.y)});
}

}  // namespace isopach::values
