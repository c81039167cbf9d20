// Verdict: whether a pose is to be trusted, from what both scans see at it; a search never says so itself.
#pragma once
#include <optional>
#include <string>

#include "isopach/match/verdict/pose_evidence.hpp"

namespace isopach {

enum class Grade {
  trusted,       ///< what both scans see agrees, in place and in shape
  doubted,       ///< it does not: a wrong pose, or a surface that changed over most of its area
  undetermined,  ///< the surface lets the scan turn or slide: nothing tells this pose from others
  rival          ///< trusted, but so would another pose be that is far from it
};

[[nodiscard]] const char* to_text(Grade grade);

/// Least E of a trusted pose on a surface that holds it well.
inline constexpr double least_agreement = 0.70;
/// Least E where the scan slips by 1 % of its extent for `slip` noises. Below 1 an error of that size hides within the
/// noise, so that what disagrees must not be left to change: it rises to 0.95.
[[nodiscard]] double agreement_needed(const PoseEvidence& e);
/// Least D: 0.70, down to 0.50 where E makes up for it. Shape is worth less where the scans differ in density or saw
/// edges from different sides, although they agree in place.
[[nodiscard]] double shape_needed(const PoseEvidence& e);
/// Less in view than this is nothing.
inline constexpr double least_view = 0.02;
/// Another pose: farther off than this many degrees, or this share of the extent; as good: z within rival_margin.
inline constexpr double other_turn = 3, other_shift = 0.03, rival_margin = 0.1;

struct Rival {
  Pose pose;
  double least = 0;               ///< its z
  double degrees = 0, shift = 0;  ///< from the pose judged; the shift is that of the middle of MOVING
};

struct Verdict {
  Grade grade = Grade::doubted;
  PoseEvidence evidence;
  enum class Stage { start, coarse } stage = Stage::start;  ///< whether the pose came from the start or a coarse search
  std::optional<Rival> rival;
  std::string tried;      ///< what was tried besides, in words; empty: nothing
  bool freed = true;      ///< all rigid motions were searched
  bool accepted = false;  ///< the user takes the pose although it is not trusted

  [[nodiscard]] bool trusted() const { return grade == Grade::trusted; }
  /// Nothing of either scan is seen beside the other.
  [[nodiscard]] bool nothing_in_view() const {
    return evidence.points_in_view == 0 || evidence.in_view[0] < least_view || evidence.in_view[1] < least_view;
  }
};

/// Verdict on `pose` (T_fixed_moving) as it comes from the start; the caller sets stage and rival. Where not all rigid
/// motions are free, slip looks at the free ones alone, and a surface without detail is judged by E alone: D has
/// nothing to say there, and there is nothing to turn away to. Too few points: doubted. Cost: that of evidence_at().
/// Source: the evidence is after CorAl ([Adolfsson2021]: what is inherent to each scan is discounted) and free space
/// ([Huber2001] and later work of its authors); slip after [Gelfand2003]. Limits: docs/use/verdict.md.
[[nodiscard]] Verdict judge(const JudgedScan& moving, const JudgedScan& fixed, const Pose& pose, const Freedom& freedom,
                            const std::array<double, 9>& axes);
/// All six motions, in input axes.
[[nodiscard]] Verdict judge(const JudgedScan& moving, const JudgedScan& fixed, const Pose& pose);

/// Undetermined, though what both scans see agrees: MOVING may slide along FIXED (a plane, a sphere, a pipe), and how
/// far the surfaces lie apart stays the same. Enough for whoever measures that alone.
[[nodiscard]] bool only_slides(const Verdict& v);

/// How far two poses are apart: degrees, and the distance of the places that they give to `middle`.
[[nodiscard]] Rival apart(const Pose& from, const Pose& to, const Point3& middle);

/// The verdict with its numbers in one sentence, without a full stop: "trusted: of what both scans see, 97 % agrees
/// within noise ...". `unit` is that of lengths, as it is printed.
[[nodiscard]] std::string sentence(const Verdict& v, const std::string& unit);

/// Throws where the pose is neither trusted nor accepted: OverlapError (exit 4) where nothing is in view, else exit 5;
/// one line that says what to do. `option` is how the message begins, e.g. "@match".
void require_trust(const Verdict& v, const std::string& unit, const std::string& option);

}  // namespace isopach
