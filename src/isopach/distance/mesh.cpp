#include "isopach/distance/mesh.hpp"

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/overlay/border.hpp"

namespace isopach {
namespace {

Mesh delaunay_mesh(const std::string& name, const HeightField& field, const MeshBorder& border,
                   const Context& context) {
  Mesh mesh;
  const Triangulation t = triangulate(field.xy, field.keys, context);
  mesh.points.resize(field.xy.size());
  for_each_index(mesh.points.size(), [&](std::size_t i) {
    mesh.points[i] = {field.xy[i].x, field.xy[i].y, field.z[i]};
  });
  const Footprint kept = footprint(t, field.xy, border.trim, {border.max_edge, 0}, context);
  mesh.faces.reserve(t.real);
  for (Index i = 0; i < t.real; ++i)
    if (kept.keeps(i)) mesh.faces.push_back(t.triangles[i].v);
  if (t.real > 0 && mesh.faces.empty())
    throw InputError(name +
                     ": @max-edge or @border trim leaves no triangle of it: give a longer edge, or @border "
                     "hull");
  if (kept.removed_area > 0) mesh.trimmed_area = kept.removed_area / (kept.area + kept.removed_area);
  return mesh;
}

Mesh mesh_of_faces(const CloudView& cloud, const Pose& pose, const Frame& frame, const HeightField& field) {
  check_faces(cloud);
  Mesh mesh;
  mesh.own_faces = true;
  mesh.points.resize(cloud.points.size());
  for_each_index(cloud.points.size(),
                 [&](std::size_t i) { mesh.points[i] = frame.to_field(pose.apply(cloud.points[i])); });
  for (const auto& face : cloud.faces) {
    bool kept = true;
    for (const Index corner : face) kept = kept && field.node_of_point[corner] != no_index;
    if (kept) mesh.faces.push_back(face);
  }
  return mesh;
}

}  // namespace

ScanPoints scan_points(const CloudView& cloud, const Pose& pose, const Frame& frame, const HeightField& field) {
  ScanPoints scan;
  scan.points.reserve(cloud.points.size());
  scan.ids.reserve(cloud.points.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (field.node_of_point[i] == no_index) continue;
    scan.points.push_back(frame.to_field(pose.apply(cloud.points[i])));
    scan.ids.push_back(static_cast<Index>(i));
  }
  return scan;
}

Mesh make_mesh(const CloudView& cloud, const Pose& pose, const Frame& frame, const HeightField& field,
               MeshSource source, const MeshBorder& border, const Context& context) {
  if (source == MeshSource::faces && cloud.faces.empty())
    throw InputError(cloud_name(cloud) + ": has no faces: leave out @mesh faces, or give a mesh");
  const bool own = source != MeshSource::delaunay && !cloud.faces.empty();
  Mesh mesh = own ? mesh_of_faces(cloud, pose, frame, field) : delaunay_mesh(cloud_name(cloud), field, border, context);
  if (mesh.faces.empty())
    throw InputError(cloud_name(cloud) +
                     (own ? ": no face is left after @class and @crop"
                          : ": its points lie on one line along the direction, so there is no surface "
                            "to measure to: use @measure c2c"));
  return mesh;
}

double face_area(const std::array<Point3, 3>& c) { return 0.5 * length(cross(c[1] - c[0], c[2] - c[0])); }

}  // namespace isopach
