// The pose of a face in space: where it is in a scan, which way it looks, which way is up and which side is the
// patient's left; or why no face was found.
#pragma once
#include <string>
#include <vector>

#include "isopach/apps/symmetry_planes.hpp"
#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/field/height_field.hpp"

namespace isopach {

/// Input coordinates. Left and right are those of the person as the scan has it: a scan that its export mirrored is a
/// perfect face, and nothing in its shape tells.
struct FacePose {
  enum class Refusal {
    none,
    too_few_points,  ///< fewer than a face can be told by
    several_planes,  ///< symmetric about planes across each other: a sphere, a cube
    no_face,         ///< symmetric or not, it does not look like a face
    sides_missing,   ///< less than 40 % of the face has its other side in the scan, or the sides do not agree
    unsure           ///< the plane is known to no better than 2.5 degrees
  };
  Refusal refusal = Refusal::no_face;
  [[nodiscard]] bool found() const { return refusal == Refusal::none; }

  Point3 front{0, 0, 1}, up{0, 1, 0}, left{1, 0, 0};  ///< unit vectors; left = up × front is the normal of the plane
  double offset = 0;                                  ///< left · p = offset for every p of the plane
  Point3 tip{0, 0, 0};                                ///< of the nose, as the template lies
  double width = 0;                                   ///< of the face, between the ears

  double likeness = 0;          ///< 0 to about 1: how well the relief follows that of a mean face
  double covered = 0;           ///< share of the template that the scan has
  double share = 0;             ///< of the scan, mirrored about the plane, that lies on the scan
  double rival_share = 0;       ///< the same of the best plane that stands across it
  double both = 0, agree = 0;   ///< share of the face that has its other side; of that, the share that agrees
  double sigma_angle_deg = 90;  ///< standard deviation of the plane's direction
  double sigma_offset = 0;      ///< of its place in the middle of the face
  double spread = 0;            ///< of the two sides about each other, as a share of the width
  /// Planes about which the scan is nearly symmetric, best first, whether there is a face or not; empty where there are
  /// too few points.
  std::vector<MirrorPlane> planes;
  Array<unsigned char> region;  ///< per input point: 1 in the region of the face; empty if none was found

  /// No living face is as symmetric: a model, a mannequin or a mirrored half.
  [[nodiscard]] bool too_symmetric() const { return found() && spread < 0.001; }
};

/// The motion that stands a face upright: x to the patient's left, y up, z to the front, about the tip of the nose.
[[nodiscard]] Pose upright(const FacePose& face);
/// Why there is no face, in words, with what to give instead; empty if there is one.
[[nodiscard]] std::string refusal_sentence(const FacePose& pose);
/// The word of a refusal in result.json: "not a face", ...
[[nodiscard]] const char* to_text(FacePose::Refusal refusal);

/// The kept points (classes, crop, not finite ones; the direction of `project` is not used) are thinned to some 2200
/// means; planes of symmetry are looked for in space from no start (symmetry_planes), in each the template of a face is
/// laid (fit_face), the best is settled on dense points and its plane found once more on the region of the face alone
/// (face_symmetry). No unit, no normals, no faces of the file are needed, nor any idea of the orientation. Refusals are
/// no errors. Cost: below a second, whatever the size of the file but for reading it once. A function of the set of
/// points, the same bits for any number of threads. Errors: InputError where no point is kept. Test:
/// tests/apps/face_pose_test.cpp; study: bench/faces_study.py.
[[nodiscard]] FacePose find_face(const CloudView& cloud, const ProjectOptions& project, const Context& context);

}  // namespace isopach
