// The symmetry plane of a face that has been found: on its own region alone, with all its points, and how sure it is.
#pragma once
#include "isopach/apps/face_fit.hpp"

namespace isopach {

/// The region of a face, in widths of it (FaceFit::in_widths): between the ears, from chin to hairline, without the
/// back of the head. `margin` widens it sideways.
[[nodiscard]] bool in_face(const Point3& widths, double margin = 0);

struct FaceSymmetry {
  MirrorPlane plane;        ///< normal to the patient's left
  double sigma_angle = 90;  ///< standard deviation of the direction of the normal, degrees
  double sigma_offset = 0;  ///< of the offset at the middle of the face
  double spread = 0;        ///< of the residuals of the two sides (1.48 MAD), in widths
  double both = 0;          ///< share of the face that has its other side in the scan
  double agree = 0;         ///< share of that whose sides agree
  double swelling = 0;      ///< largest mean residual over a large part, to its side, in widths
  std::size_t points = 0;
};

/// Gauss–Newton on the plane with Tukey's weights (three standard deviations by the median), on up to 16 000 points of
/// the region. σ is the larger of two jackknives: over 24 small patches, and over six large parts with weights found
/// anew, since asymmetry is coherent over such parts (the first alone is two to six times too small). Too few points:
/// sigma_angle stays 90. The same bits for any number of threads. Test: tests/apps/face_pose_test.cpp.
[[nodiscard]] FaceSymmetry face_symmetry(std::span<const Point3> points, const FaceFit& fit);

}  // namespace isopach
