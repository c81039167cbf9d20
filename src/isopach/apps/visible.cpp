#include "isopach/apps/visible.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/mesh.hpp"
#include "isopach/distance/surface_tree.hpp"

namespace isopach {
namespace {

template <class T>
void keep_items(Array<T>& items, const Array<Index>& now) {
  Array<T> kept;
  kept.reserve(items.size());
  for (std::size_t i = 0; i < now.size(); ++i)
    if (now[i] != no_index) kept.push_back(items[i]);
  items = std::move(kept);
}

void keep_faces(Cloud& cloud, const Array<Index>& now) {
  Array<std::array<Index, 3>> kept;
  for (const auto& f : cloud.faces)
    if (now[f[0]] != no_index && now[f[1]] != no_index && now[f[2]] != no_index)
      kept.push_back({now[f[0]], now[f[1]], now[f[2]]});
  cloud.faces = std::move(kept);
}

}  // namespace

Array<unsigned char> hidden_points(const CloudView& cloud, const Pose& pose, const Frame& frame,
                                   const HeightField& field, const Context& context) {
  if (cloud.faces.empty())
    throw UsageError("@visible: " + cloud_name(cloud) +
                     " has no faces that could hide a point: leave the option out, or give a mesh");
  const Mesh mesh = make_mesh(cloud, pose, frame, field, MeshSource::faces, {}, context);
  const SurfaceTree tree(mesh);
  Box3 box;
  for (const auto& face : mesh.faces)
    for (const Index corner : face) box.add(mesh.points[corner]);
  const double depth = box.max.z - box.min.z, rounding = 1e-9 * (depth + box.max.x - box.min.x);
  Array<unsigned char> hidden(cloud.points.size());
  for_each_index(hidden.size(), [&](std::size_t i) {
    hidden[i] = 0;
    if (field.node_of_point[i] == no_index) return;
    const Point3& p = mesh.points[i];
    const double eye = box.max.z + depth;
    const Crossing first = tree.cross({p.x, p.y, eye}, {0, 0, -1});
    hidden[i] = first.face != no_index && eye - first.t > p.z + rounding ? 1 : 0;
  });
  return hidden;
}

Cloud visible_part(const CloudView& cloud, const Pose& pose, const Frame& frame, const ProjectOptions& options,
                   const Context& context) {
  ProjectOptions merging = options;
  if (merging.duplicates == DuplicatePolicy::error) merging.duplicates = DuplicatePolicy::max;
  const HeightField field = project(cloud, pose, frame, merging, context);
  const Array<unsigned char> hidden = hidden_points(cloud, pose, frame, field, context);
  Array<Index> now(hidden.size());
  Index kept = 0;
  for (std::size_t i = 0; i < hidden.size(); ++i) now[i] = hidden[i] != 0 ? no_index : kept++;
  Cloud seen = copy_of(cloud);
  keep_items(seen.points, now);
  for (Attribute& a : seen.attributes) keep_items(a.values, now);
  keep_faces(seen, now);
  seen.notes.push_back(fmt::format("{} of {} points lie behind a face and are left out (@visible)",
                                   hidden.size() - kept, hidden.size()));
  return seen;
}

}  // namespace isopach
