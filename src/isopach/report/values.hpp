// Numbers, points and matrices as JSON. Internal to report/: the header needs nlohmann-json.
#pragma once
#include <cmath>

#include <nlohmann/json.hpp>

#include "isopach/geom/rigid.hpp"

namespace isopach::values {

using Json = nlohmann::ordered_json;

/// null for NaN and infinities; 0 without a sign.
[[nodiscard]] inline Json real(double value) {
  return std::isfinite(value) ? Json(value == 0 ? 0.0 : value) : Json(nullptr);
}
[[nodiscard]] inline Json point(const Point3& p) { return Json::array({real(p.x), real(p.y), real(p.z)}); }

/// Four rows of four.
[[nodiscard]] inline Json matrix(const Pose& pose) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < 16; i += 4)
    rows.push_back(Json::array({real(pose.m[i]), real(pose.m[i + 1]), real(pose.m[i + 2]), real(pose.m[i + 3])}));
  return rows;
}

}  // namespace isopach::values
