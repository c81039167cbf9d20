// asymmetry(face): how the two sides of a face (or of any surface that is nearly its own mirror image) differ. The face
// is matched to its mirror image, which gives the symmetry plane; then both are compared, and the result is reported by
// region: docs/use/asymmetry.md. The plane as that of the best motion of the mirror image: [Benz2002].
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/apps/face_pose.hpp"
#include "isopach/apps/face_regions.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/match/matching.hpp"
#include "isopach/match/verdict/pose_evidence.hpp"

namespace isopach {

/// Parts of a face that the plane may be fitted to alone, because the others are swollen, missing or moved.
enum class StablePart { forehead, eyes, nose, cheeks, mouth, chin };

[[nodiscard]] const char* to_text(StablePart part);

/// Who says where the front is: the pose that is found in the scan, or compare.project.direction and `across`.
enum class FaceOrientation { found, given };

struct AsymmetryOptions {
  CompareOptions compare;  ///< scan, border and unit as in a comparison; `pose` is not used
  FaceOrientation orientation = FaceOrientation::found;
  std::optional<Point3> across;  ///< from one side to the other, roughly; default: the patient's left where the face is
                                 ///< found, else the first axis of the projection
  std::vector<StablePart> stable;  ///< parts that the plane is fitted to; empty: all. Needs a face that is found
  double rim = 0;                  ///< points nearer than this to the border of the scan or of a hole are left out
  double depth = 0;      ///< > 0: points farther than this behind the foremost one are left out (the back of a head)
  bool visible = false;  ///< of a file with faces: points behind a face (inside of the mouth, back) are left out; of
                         ///< a face that is found so in any case
  FaceParts parts = FaceParts::thirds;
  std::optional<PolygonSet> polygons;  ///< regions to tell instead of parts: in the two axes of the file that the face
                                       ///< looks across (x and y for a face that looks along z)
  double overlap = 0;        ///< share of the common area that the plane is fitted to; 0: all that is symmetric
  int max_iterations = 100;  ///< of each of the few searches
  bool accept_doubt =
      false;  ///< direction or across given: the plane is taken although the sides hardly agree about it
};

/// Input coordinates. The positive side is the one that `normal` points to; `normal` goes along options.across.
struct SymmetryPlane {
  Point3 normal{1, 0, 0};
  Point3 point{0, 0, 0};        ///< of the plane, nearest the middle of the face
  double offset = 0;            ///< normal · p = offset for every p of the plane
  double sigma_angle = 0;       ///< standard deviation of the direction of the normal, degrees
  double sigma_offset = 0;      ///< of the offset at `point`
  double twist = 0, glide = 0;  ///< degrees, length: what the best motion of the mirror image does beyond a reflection
};

/// The index is ρ between the face and its mirror image, in percent of the size of the face, √area: it has no unit and
/// does not change with scale. `floor` is what a symmetric face with these points and this noise would show (see
/// NoiseFloor), `raw` the index with it, `percent` without.
struct AsymmetryIndex {
  double percent = 0, raw = 0, floor = 0;
  double size = 0;  ///< √area
};

struct Asymmetry {
  AsymmetryOptions options;
  InputSummary face;
  std::string unit = "unknown";
  FacePose pose;  ///< of the face as it was found, or why not
  double swelling =
      0;  ///< where the face was found: mean d over the fifth of the width that stands out most, in widths
  SymmetryPlane plane;
  std::optional<PoseEvidence> sides;  ///< how both sides agree about the plane, where no face vouches for it
  Pose to_face;  ///< T_face_input. Face coordinates: x from the plane to the positive side, z along the direction as
                 ///< far as it lies in the plane, y = z × x; the origin is plane.point
  Comparison comparison;  ///< A: the mirror image, B: the face, both in face coordinates: d(−x, y) = −d(x, y)
  AsymmetryIndex index;
  std::vector<SideDifference> regions;  ///< the whole first
  Array<double> of_point;  ///< per input point: its height above the mirrored other side; NaN: dropped or no other side
  int iterations = 0;
  bool converged = false;
  std::string reason;
  double overlap = 1;  ///< share of the area that was taken for symmetric and fitted
  std::vector<std::string> warnings;
  Timing timing;
};

/// Orientation found: the pose of the face (find_face) gives direction, sides, region of the face and a first plane;
/// options.across and visible still hold where given. Refused: OverlapError that says what to give. Given: the start
/// is, of 27 planes about `across` (turned by up to 12 degrees in the picture and 20 in depth, shifted by up to 15 % of
/// the width, so that a crop that is itself asymmetric does no harm), solved on thinned points for shift and tilts of
/// the plane, the one about which the largest area is symmetric; a face is then looked for only to name the sides, and
/// to warn where its pose disagrees by 15 degrees. The plane that is found must be one that both sides agree about
/// (symmetry_check.hpp); else one is looked for among all motions in space, and where that does no better: exit 5,
/// unless options.accept_doubt. Its σ is that of a jackknife over parts of the face where this is clearly larger. Then
/// all motions on all points, turned into face coordinates, until the plane stands still. Fitting leaves out what
/// differs more than noise (see match). Cost: that of some matchings and a comparison with noise floor. A function of
/// the set of points, the same bits for any number of threads. Errors: UsageError for options, OverlapError where no
/// part of the scan lies over its mirror image or no face is found, InputError as `project`, for polygons as
/// stages::regions_of and where none of them holds a part of the face, and where heights have another unit than x and
/// y. Test: tests/apps/asymmetry_test.cpp, tests/apps/asymmetry_pose_test.cpp.
[[nodiscard]] Asymmetry asymmetry(const CloudView& face, const AsymmetryOptions& options, const Context& context);

}  // namespace isopach
