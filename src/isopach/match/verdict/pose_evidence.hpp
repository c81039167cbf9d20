// PoseEvidence: what two scans say about a pose of one on the other, from all that both of them see.
#pragma once
#include <array>
#include <string>

#include "isopach/geom/rigid.hpp"
#include "isopach/match/options.hpp"
#include "isopach/match/verdict/judged_scan.hpp"

namespace isopach {

/// What a point of one scan is to the other, at a pose.
enum class PointVerdict : unsigned char {
  not_in_view,  ///< seen beside nothing of the other scan, or on a side that its eye cannot see
  agrees,       ///< within 3 standard deviations of the noise of both
  in_front,     ///< where the other scan saw through
  behind        ///< where the other scan cannot have seen
};

/// Least detail q, of both scans, of a surface that determines a pose.
inline constexpr double least_detail = 0.5;

/// All numbers of a pose. First of two: points of MOVING in the view of FIXED; second: the other way round.
struct PoseEvidence {
  double agree = 0;  ///< E: share, of what is in view and faces the eye, that agrees; the lesser of both ways, over
                     ///< what a scan agrees with itself (f, the lesser)
  double shape = 0;  ///< D: correlation of the normals' detail; the lesser of both ways, over the lesser q
  double slip = 0;   ///< rise of the residuals, in standard deviations of the noise, where the scan slips 1 % of its
                     ///< extent in the free motion that is held least
  double slip_needed = 0;  ///< least slip that holds: 0.5, less for few points, where the noise of normals alone, which
                           ///< makes even a plane rough, shows as 0.01 extent / (3.9 spacing)
  std::string loosest;     ///< this motion in words
  std::array<double, 2> in_view{0, 0};  ///< share of the points
  double in_front = 0, behind = 0;      ///< shares of what E counts, of both ways together
  std::array<double, 2> noise{0, 0};    ///< of MOVING, of FIXED, in the unit of FIXED
  std::array<double, 2> detail{0, 0};   ///< q of MOVING, of FIXED
  std::size_t points_in_view = 0;       ///< points of MOVING and of FIXED that E rests on
  bool side_known = true;               ///< false: the scans fit with the back of one on the front of the other's file

  /// Whether the surfaces repeat from half to half of a scan, beyond their noise: else `shape` says nothing.
  [[nodiscard]] bool has_detail() const { return detail[0] >= least_detail && detail[1] >= least_detail; }
  /// z: the lesser of agree and shape.
  [[nodiscard]] double least() const { return agree < shape ? agree : shape; }
};

/// PoseEvidence at T_fixed_moving = `pose`, whose scale may differ from 1. `freedom` says which motions `slip` looks
/// at; `axes` the frame they are along (rows u, v, w).
///
/// A point is in view where, in the viewing of the other scan, a point of that lies within 1.5 of its spacings; it
/// counts where its normal is within 78 degrees of the line of sight. Its distance is measured along the normal of the
/// nearest in depth of the four nearest there. Which side of a scan was seen is not known from its points: the normals
/// of MOVING are tried either way, and the way with the greater lesser number stands, for both directions alike.
/// All 0 where a scan is not usable(). Cost: 5000 searches for neighbours, about 15 ms. Deterministic.
/// Test: PoseEvidence.* in tests/match/verdict_test.cpp, against a twin that looks at all pairs of points.
[[nodiscard]] PoseEvidence evidence_at(const JudgedScan& moving, const JudgedScan& fixed, const Pose& pose,
                                       const Freedom& freedom, const std::array<double, 9>& axes);

/// Of every point of a cloud, what it is to `fixed` at the pose; `noise` is that of both scans together. Points that
/// are not finite, and points where `fixed` is seen edge-on (within 12 degrees), are not in view. Cost O(n log
/// judged_points), in parallel.
[[nodiscard]] Array<PointVerdict> agreement_of(const CloudView& moving, const JudgedScan& fixed, const Pose& pose,
                                               double noise, const Context& context);

}  // namespace isopach
