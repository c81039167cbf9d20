// The face template laid on a scan: where in a plane of symmetry a face sits, which way it looks and which way is up,
// how large it is, and how much like a face the scan is there.
#pragma once
#include <vector>

#include "isopach/apps/symmetry_planes.hpp"

namespace isopach {

/// A place of the template, in the coordinates of the points.
struct FaceFit {
  MirrorPlane plane;  ///< normal to the patient's left: left = up × front
  Point3 tip{0, 0, 0};
  Point3 front{0, 0, 1}, up{0, 1, 0};
  double width = 0;  ///< of the face

  double rank = 0;     ///< what fits are ordered by: good · correlation · 1.5 min(slope, 1 / slope), this at most 1
  double covered = 0;  ///< share of the template that has scan near it
  double good = 0;     ///< share of the template that the scan follows
  double correlation = 0;  ///< of the reliefs: nose, eyes and lips, the large curvature taken off
  double slope = 0;        ///< of the scan's relief over that of the template

  [[nodiscard]] Point3 left() const;
  /// 1 for the mean face itself; 0 where the reliefs have nothing in common.
  [[nodiscard]] double likeness() const;
  /// x to the left, y up, z to the front of the nose tip, in widths of the face.
  [[nodiscard]] Point3 in_widths(const Point3& p) const;
};

/// Fits of the template in this plane, the best first; empty where less than three tenths of it is covered anywhere.
/// The starts take what stands out most along the profile, to either side, for the tip of the nose (as [Faltemier2008]
/// does): up to 28 places, six pitches, both ways up, six sizes. Unknown are pitch, size and two shifts. Coordinates as
/// symmetry_planes has them. The same bits for any number of threads. Test: tests/apps/face_pose_test.cpp.
[[nodiscard]] std::vector<FaceFit> fit_face(const ThinPoints& points, const NearestGrid& grid,
                                            const MirrorPlane& plane);

/// How the points lie about the template where it is: `rank` to `slope` of the fit.
[[nodiscard]] FaceFit judged(FaceFit fit, const ThinPoints& points);

/// The template once more, on dense points and with exact nearest ones, the plane held, until the pitch stands still:
/// the choice of points at first would else turn the front by up to 2 degrees. `points` are those around the face.
[[nodiscard]] FaceFit settled(FaceFit fit, const ThinPoints& points);

}  // namespace isopach
