// combine(face, jaw, reference, options): two scans that share no surface in one model, by an object that is seen in
// both (docs/use/combine.md).
//
// The object is found in each scan (coarse start, then least squares of distances to planes); the two poses are
// chained, T_face_jaw = T_face_reference · T_reference_jaw, and so are their covariances.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/geom/rigid.hpp"

namespace isopach {

struct CombineOptions {
  double least_share = 0.3;        ///< of the object's points that must be found in each scan
  std::optional<Pose> start_face;  ///< T_face_reference to start from; default: looked for
  std::optional<Pose> start_jaw;   ///< T_jaw_reference likewise
  std::string unit;                ///< of lengths; empty: as in the files
};

/// The object in one scan.
struct LocatedReference {
  Pose pose;                            ///< T_scan_reference, input coordinates
  double rms = 0;                       ///< distances of the pairs that take part
  std::size_t pairs = 0;                ///< that take part: points of the sparser of the two on the denser one
  double correlation = 1;               ///< of the variances in `covariance`, that neighbours which err alike make
  double share = 0;                     ///< of the object's points that lie on the scan
  double covered = 0;                   ///< of the scan's points that lie on the object
  Point3 centre{0, 0, 0};               ///< of the fit, scan coordinates
  std::array<double, 36> covariance{};  ///< of the pose: turn (rad), then shift, about centre, axes of the scan
  double slip = 0;  ///< noises that distances rise by where the object slips 1 % of its extent along what holds least
  Array<unsigned char> on_reference;  ///< by point of the scan
};

enum class CombinedPart : unsigned char { face = 0, jaw = 1, reference_in_face = 2, reference_in_jaw = 3 };

struct Combination {
  CombineOptions options;
  InputSummary face_input, jaw_input, reference_input;
  std::string unit = "unknown";
  LocatedReference face, jaw;
  Pose face_jaw;                        ///< T_face_jaw
  std::array<double, 36> covariance{};  ///< of it: turn (rad), then shift, about `centre`, axes of the face
  Point3 centre{0, 0, 0};               ///< middle of the object in the face scan, face coordinates
  Point3 jaw_middle{0, 0, 0};           ///< middle of the jaw, face coordinates
  double sigma_angle = 0;               ///< rad, of the turn
  double sigma_middle = 0;              ///< standard deviation of the place of the jaw's middle
  double sigma_farthest = 0;            ///< … of the jaw's point farthest from the object
  Array<Point3> points;                 ///< the model, face coordinates: face, then jaw
  Array<CombinedPart> part;
  std::array<std::size_t, 4> counts{};  ///< of points, by part
  std::vector<std::string> warnings;
  Timing timing;
};

/// Errors: OverlapError, naming the scan, with the reason, where the object is not found in it: nothing like it is
/// there, less than options.least_share of it, or what is there fits worse than the noise of both scans; exit 5 where
/// its shape leaves a motion free, or fits as well at another turn (looked for where no start is given); InputError for
/// scans without usable points or of different units; UsageError for options without sense. Cost: O(n log n) and a
/// search. The same bits for any number of threads and any order of the points.
[[nodiscard]] Combination combine(const CloudView& face, const CloudView& jaw, const CloudView& reference,
                                  const CombineOptions& options, const Context& context);

}  // namespace isopach
