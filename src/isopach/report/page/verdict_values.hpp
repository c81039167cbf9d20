// A verdict on a pose as JSON, and what was moved before a comparison. Internal to report/: the header needs
// nlohmann-json.
#pragma once
#include "isopach/match/matching.hpp"
#include "isopach/report/page/moved.hpp"
#include "isopach/report/page/values.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach::values {

/// The key `verdict`: null where no verdict was asked for.
[[nodiscard]] inline Json verdict_json(const std::optional<Verdict>& verdict, const std::string& unit) {
  if (!verdict) return nullptr;
  const Verdict& v = *verdict;
  const PoseEvidence& e = v.evidence;
  Json rival = nullptr;
  if (v.rival)
    rival = {{"matrix", matrix(v.rival->pose)},
             {"least", real(v.rival->least)},
             {"degrees", real(v.rival->degrees)},
             {"shift", real(v.rival->shift)}};
  return {{"grade", to_text(v.grade)},
          {"sentence", message(sentence(v, unit_text(unit)))},
          {"accepted", v.accepted},
          {"stage", v.stage == Verdict::Stage::start ? "start" : "coarse"},
          {"agree", real(e.agree)},
          {"shape", real(e.shape)},
          {"in_view", Json::array({real(e.in_view[0]), real(e.in_view[1])})},
          {"in_front", real(e.in_front)},
          {"behind", real(e.behind)},
          {"noise", Json::array({real(e.noise[0]), real(e.noise[1])})},
          {"detail", Json::array({real(e.detail[0]), real(e.detail[1])})},
          {"slip", real(e.slip)},
          {"rival", rival}};
}

/// The key `matched`: how B was moved; null where it was not.
[[nodiscard]] inline Json matched_json(const Matching* matching) {
  if (matching == nullptr) return nullptr;
  const Matching& m = *matching;
  const Moved by = moved_by(m);
  return {
      {"shift", point(by.shift)},   {"angle_deg", real(by.degrees)},
      {"axis", point(by.axis)},     {"middle", point(m.centre)},
      {"overlap", real(m.overlap)}, {"covariance", precision_is_told(m) ? covariance(m.covariance) : Json(nullptr)}};
}

}  // namespace isopach::values
