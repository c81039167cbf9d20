// Planes about which a surface in space is nearly its own mirror image, from no start at all.
#pragma once
#include <vector>

#include "isopach/apps/thin_points.hpp"

namespace isopach {

/// normal · p = offset; the normal has length 1.
struct MirrorPlane {
  Point3 normal{1, 0, 0};
  double offset = 0;

  [[nodiscard]] double distance(const Point3& p) const {
    return normal.x * p.x + normal.y * p.y + normal.z * p.z - offset;
  }
  [[nodiscard]] Point3 mirrored(const Point3& p) const {
    const double twice = 2 * distance(p);
    return {p.x - twice * normal.x, p.y - twice * normal.y, p.z - twice * normal.z};
  }
  /// Of a direction.
  [[nodiscard]] Point3 turned(const Point3& v) const {
    const double twice = 2 * (normal.x * v.x + normal.y * v.y + normal.z * v.z);
    return {v.x - twice * normal.x, v.y - twice * normal.y, v.z - twice * normal.z};
  }
};

/// Two unit vectors u, v of the plane: u × v is the normal.
void plane_axes(const Point3& normal, Point3& u, Point3& v);

struct SymmetryPlane3 {
  MirrorPlane plane;
  double score = 0;  ///< of the search on few points
  double share = 0;  ///< of the points away from the plane, those that lie on the mirror image of others
};

/// Coordinates are about the mean of the points and scaled so that lengths near 1 are those of the object (its points
/// lie at some 0.8 from their middle, in the median). 110 directions × 3 offsets of the plane are each improved by
/// Gauss–Newton steps on the plane itself (three unknowns; [Combes2008]), the residual being that from
/// the mirrored point to the tangent plane of its nearest point, with weights of Geman and McClure; what is left, at
/// most eight planes that differ, is refined on all points. Best first. No start is needed, nor oriented normals, nor
/// faces. Cost: some million nearest points read off the grid. The same bits for any number of threads. Test:
/// tests/apps/face_pose_test.cpp.
[[nodiscard]] std::vector<SymmetryPlane3> symmetry_planes(const ThinPoints& points, const NearestGrid& grid);

}  // namespace isopach
