// The options of an alignment as JSON. Internal to report/: the header needs nlohmann-json.
#pragma once
#include "isopach/match/matching.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach::values {

/// The names of the motions that are searched, as --freedom takes them.
[[nodiscard]] inline Json freedom(const Freedom& f) {
  Json free = Json::array();
  const auto add = [&](bool is_free, const char* name) {
    if (is_free) free.push_back(name);
  };
  add(f.shift_x, "x"), add(f.shift_y, "y"), add(f.shift_z, "z");
  add(f.turn_x, "turn-x"), add(f.turn_y, "turn-y"), add(f.turn_z, "turn-z"), add(f.scale, "scale");
  return free;
}

/// A scan that was aligned.
[[nodiscard]] inline Json aligned_input(const InputSummary& in, const std::string& role) {
  return {{"role", role},
          {"path", in.path},
          {"points", in.points},
          {"nodes", in.nodes},
          {"unit", in.unit},
          {"vertical_unit", in.vertical_unit},
          {"crs", text_or_null(in.crs)},
          {"format", in.format}};
}

/// Adds to `parameters` how scans were aligned, cleaned and bounded; nothing is free where there was no alignment.
inline void add_alignment(Json& parameters, const MatchOptions& m, bool aligned, const std::string& unit) {
  const CompareOptions& c = m.compare;
  parameters["freedom"] = aligned ? freedom(m.freedom) : Json::array();
  parameters["overlap"] = m.overlap > 0 ? real(m.overlap) : Json("auto");
  parameters["max_iterations"] = m.max_iterations;
  parameters["tolerance"] = real(m.tolerance > 0 ? m.tolerance : default_match_tolerance);
  parameters["border"] = to_text(c.border);
  parameters["folds"] = to_text(c.folds);
  parameters["max_edge"] = c.max_edge > 0 ? real(c.max_edge) : Json(nullptr);
  parameters["duplicates"] = to_text(c.project.duplicates);
  parameters["direction_rule"] = to_text(c.project.direction.kind);
  parameters["class"] = c.project.classes.empty() ? Json(nullptr) : Json(c.project.classes);
  parameters["crop"] = crop_box(c.project.crop);
  parameters["unit"] = unit;
  parameters["allow_crs"] = c.allow_crs;
}

/// What a comparison found of folds.
[[nodiscard]] inline Json folds(const Comparison& c) {
  const FoldSummary& f = c.folds;
  return {{"rule", to_text(c.options.folds)}, {"looked_for", c.options.check_layers}, {"area", real(f.area)},
          {"share", real(f.share)},           {"share_a", real(f.share_a)},           {"share_b", real(f.share_b)},
          {"above", real(f.volume.above)},    {"below", real(f.volume.below)}};
}

}  // namespace isopach::values
