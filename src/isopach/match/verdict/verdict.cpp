#include "isopach/match/verdict/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/base/error.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/checks.hpp"

namespace isopach {
namespace {

constexpr double loose_agreement = 0.95, agreement_by_slip = 0.3;
constexpr double least_shape = 0.50, enough_shape = 0.70, agreement_and_shape = 1.40;

Grade grade_of(const PoseEvidence& e, bool freed) {
  if (e.points_in_view == 0) return Grade::doubted;
  if (freed && !e.has_detail()) return Grade::undetermined;
  if (!(e.agree >= agreement_needed(e))) return Grade::doubted;
  if (e.has_detail() && !(e.shape >= shape_needed(e))) return Grade::doubted;
  return e.slip >= e.slip_needed ? Grade::trusted : Grade::undetermined;
}

std::string percent(double share) { return fmt::format("{:.0f} %", 100 * std::clamp(share, 0.0, 1.0)); }

/// "97 % agrees within noise (1 % in front, 2 % behind), shape 0.98". E allows for what a scan differs from itself, so
/// what lies in front and behind is told as shares of what is left to 100 %.
std::string numbers(const PoseEvidence& e) {
  const double off = e.in_front + e.behind, rest = std::max(0.0, 1 - e.agree), part = off > 0 ? rest / off : 0;
  return fmt::format(
      "of what both scans see, {} agrees within their noise (needs {:.0f} %; {} lies in front, {} behind), and their "
      "shapes agree by {:.2f} (needs {:.2f}); in view {} of the moving scan, {} of the fixed one",
      percent(e.agree), 100 * agreement_needed(e), percent(part * e.in_front), percent(part * e.behind), e.shape,
      shape_needed(e), percent(e.in_view[0]), percent(e.in_view[1]));
}

std::string undetermined(const Verdict& v) {
  const PoseEvidence& e = v.evidence;
  const double q = std::min(e.detail[0], e.detail[1]);
  std::string text = "undetermined: ";
  if (v.freed && q < least_detail)
    text += fmt::format(
        "the surface shows no detail beyond its noise (repeats from half to half of a scan by {:.2f}, needs {:.2f}), "
        "so nothing tells this pose from others",
        std::max(q, 0.0), least_detail);
  else
    text += fmt::format(
        "the surface does not hold the scan: slipping by 1 % of the extent raises the distances by {:.2f} noise (needs "
        "{:.2f})",
        e.slip, e.slip_needed);
  if (!e.loosest.empty()) text += "; held least: " + e.loosest;
  return text;
}

std::string doubted(const Verdict& v) {
  const PoseEvidence& e = v.evidence;
  if (e.points_in_view == 0 && e.noise[0] == 0 && e.noise[1] == 0)
    return "doubted: a scan has too few points for a verdict (needs 60 in different places)";
  if (v.nothing_in_view()) return "doubted: hardly anything of one scan lies in the view of the other";
  return "doubted: " + numbers(e) +
         "; a wrong pose, or a surface that really changed over most of its area, which looks the same";
}

}  // namespace

double agreement_needed(const PoseEvidence& e) {
  return std::min(loose_agreement, least_agreement + agreement_by_slip * std::max(0.0, 1 - e.slip));
}

double shape_needed(const PoseEvidence& e) {
  return std::clamp(agreement_and_shape - e.agree, least_shape, enough_shape);
}

const char* to_text(Grade grade) {
  switch (grade) {
    case Grade::trusted:
      return "trusted";
    case Grade::doubted:
      return "doubted";
    case Grade::undetermined:
      return "undetermined";
    case Grade::rival:
      return "rival";
  }
  return "doubted";
}

Verdict judge(const JudgedScan& moving, const JudgedScan& fixed, const Pose& pose, const Freedom& freedom,
              const std::array<double, 9>& axes) {
  Verdict v;
  v.freed = all_rigid_motions(freedom);
  v.evidence = evidence_at(moving, fixed, pose, freedom, axes);
  v.grade = grade_of(v.evidence, v.freed);
  return v;
}

Verdict judge(const JudgedScan& moving, const JudgedScan& fixed, const Pose& pose) {
  return judge(moving, fixed, pose, Freedom{}, {1, 0, 0, 0, 1, 0, 0, 0, 1});
}

bool only_slides(const Verdict& v) { return v.grade == Grade::undetermined && v.evidence.agree >= least_agreement; }

Rival apart(const Pose& from, const Pose& to, const Point3& middle) {
  Rival r;
  r.pose = to;
  // trace(Aᵀ B) of the rotations; scales are divided out.
  double trace = 0, a2 = 0, b2 = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double a = from.m[4 * i + j], b = to.m[4 * i + j];
      trace += a * b, a2 += a * a, b2 += b * b;
    }
  const double cosine = (3 * trace / std::sqrt(a2 * b2) - 1) / 2;
  r.degrees = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
  r.shift = length(to.apply(middle) - from.apply(middle));
  return r;
}

std::string sentence(const Verdict& v, const std::string& unit) {
  std::string text;
  switch (v.grade) {
    case Grade::trusted:
      text = "trusted: " + numbers(v.evidence);
      break;
    case Grade::undetermined:
      text = undetermined(v);
      break;
    case Grade::doubted:
      text = doubted(v);
      break;
    case Grade::rival:
      text = "not decided: " + numbers(v.evidence);
      break;
  }
  if (v.rival)
    text +=
        fmt::format("; another pose, {:.1f} degrees and {:.4g} {} away, agrees by {:.2f} where this one does by {:.2f}",
                    v.rival->degrees, v.rival->shift, unit, v.rival->least, v.evidence.least());
  if (!v.tried.empty()) text += "; " + v.tried;
  return text;
}

void require_trust(const Verdict& v, const std::string& unit, const std::string& option) {
  if (v.trusted() || v.accepted) return;
  const bool nothing = v.grade == Grade::doubted && v.nothing_in_view();
  std::string remedy = "give a start nearby";
  const bool has_freedom = option == "@match" || option == "match";  // the other verbs search all motions
  if (v.grade == Grade::undetermined)
    remedy = std::string(has_freedom ? "search fewer motions (@freedom), or " : "") + "scan more of what surrounds it";
  if (v.grade == Grade::rival) remedy = "only a start that you know decides";
  if (v.grade == Grade::doubted && !v.freed) remedy += ", or free all motions";
  throw Error(
      nothing ? ExitCode::no_overlap : ExitCode::not_converged,
      fmt::format("{}: the pose is {}: {}, or take it as it is by @accept-doubt", option, sentence(v, unit), remedy));
}

}  // namespace isopach
