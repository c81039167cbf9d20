// Mesh: a scan as a triangulated surface in space: the faces of its file, or the Delaunay triangulation seen along the
// direction, lifted to the heights of its nodes.
#pragma once
#include <array>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/field/height_field.hpp"

namespace isopach {

/// Points in frame coordinates; every face is three indices into them.
struct Mesh {
  Array<Point3> points;
  Array<std::array<Index, 3>> faces;
  bool own_faces = false;   ///< the file's faces, not a Delaunay triangulation
  double trimmed_area = 0;  ///< share of the hull's area, seen along the direction, that MeshBorder left out

  [[nodiscard]] std::array<Point3, 3> corners(std::size_t face) const {
    const auto& f = faces[face];
    return {points[f[0]], points[f[1]], points[f[2]]};
  }
};

/// automatic: the file's faces where it has any.
enum class MeshSource { automatic, delaunay, faces };

/// What of a Delaunay triangulation is surface, see overlay/border.hpp. The faces of a file are surface as they are.
struct MeshBorder {
  bool trim = true;     ///< only what the sampling supports; false: the convex hull
  double max_edge = 0;  ///< > 0: no triangle with a longer edge in x and y
};

/// The kept points of a cloud in frame coordinates, and which they are.
struct ScanPoints {
  Array<Point3> points;
  Array<Index> ids;  ///< points[i] is point ids[i] of the cloud
};
[[nodiscard]] ScanPoints scan_points(const CloudView& cloud, const Pose& pose, const Frame& frame,
                                     const HeightField& field);

/// The surface of a scan. Faces with a corner that `field` dropped are left out. Errors: InputError, naming the file,
/// where no face is left, where points all lie on one line along the direction, or where faces are asked for and the
/// file has none. A node that the border leaves without a triangle stays a point without surface. Cost: that of
/// `triangulate`, or O(faces).
[[nodiscard]] Mesh make_mesh(const CloudView& cloud, const Pose& pose, const Frame& frame, const HeightField& field,
                             MeshSource source, const MeshBorder& border, const Context& context);

/// Area of a face.
[[nodiscard]] double face_area(const std::array<Point3, 3>& corners);

}  // namespace isopach
