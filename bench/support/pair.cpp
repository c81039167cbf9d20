#include "bench/support/pair.hpp"

#include "isopach/base/random.hpp"
#include "isopach/delaunay/validate.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/overlay/localise.hpp"
#include "isopach/overlay/localise_by_interface.hpp"
#include "isopach/overlay/merge.hpp"

namespace isopach::bench {
namespace {

Mesh mesh_of(Points nodes, const CurveBox& box) {
  Mesh mesh;
  mesh.xy = std::move(nodes);
  mesh.t = triangulate(mesh.xy, box, {});
  mesh.tree = spanning_tree(mesh.t, mesh.xy, {});
  return mesh;
}

Points sorted(const Points& points, const CurveBox& box) {
  Points nodes;
  nodes.reserve(points.size());
  for (const Index i : curve_order(points, box))
    if (nodes.empty() || !(nodes.back() == points[i])) nodes.push_back(points[i]);
  return nodes;
}

Points some(const Points& nodes, std::uint64_t keep, std::uint64_t seed) {
  const RandomStream chance(seed, 9);
  Points kept;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (chance.bits(i) % keep == 0) kept.push_back(nodes[i]);
  return kept;
}

}  // namespace

Pair make_pair_of(const Points& a, const Points& b) {
  Box2 box;
  for (const Points* points : {&a, &b})
    for (const Point2& p : *points) box.add(p);
  Pair pair;
  pair.box = curve_box(box);
  pair.a = mesh_of(sorted(a, pair.box), pair.box);
  pair.b = mesh_of(sorted(b, pair.box), pair.box);
  return pair;
}

Pair make_pair_of(const Cloud& a, const Cloud& b, std::uint64_t keep) {
  const ProjectOptions options;
  const Frame frame = choose_frame(a, b, Pose{}, options, {});
  Pair pair;
  pair.box = frame.curve;
  pair.a = mesh_of(some(project(a, Pose{}, frame, options, {}).xy, keep, 1), pair.box);
  pair.b = mesh_of(some(project(b, Pose{}, frame, options, {}).xy, keep, 2), pair.box);
  return pair;
}

Located localise_both(const Pair& pair) {
  return {localise(pair.a.xy, pair.a.tree, pair.b.t, pair.b.xy, {}),
          localise(pair.b.xy, pair.b.tree, pair.a.t, pair.a.xy, {})};
}

Located localise_in_order_both(const Pair& pair) {
  return {localise_in_order(pair.a.xy, pair.b.t, pair.b.xy, {}), localise_in_order(pair.b.xy, pair.a.t, pair.a.xy, {})};
}

Union united(const Pair& pair) {
  Union common;
  common.g = unite(pair.a.xy, pair.b.xy, pair.box);
  common.t = triangulate(common.g.xy, pair.box, {});
  return common;
}

Located localise_by_interface_both(const Pair& pair, const Union& common) {
  MutualLocations found = localise_by_interface(common.g, common.t, pair.a.t, pair.a.xy, pair.b.t, pair.b.xy, {});
  return {std::move(found.of_1_in_2), std::move(found.of_2_in_1)};
}

ToMerge ready_to_merge(const Pair& pair) { return {pair.a.t, pair.b.t, localise_in_order_both(pair)}; }

Merged merge(const Pair& pair, ToMerge parts) {
  const UnitedNodes g = unite(pair.a.xy, pair.b.xy, pair.box);
  Merged merged;
  merged.t = isopach::merge({std::move(parts.a), pair.a.xy, &parts.where.a_in_b},
                            {std::move(parts.b), pair.b.xy, &parts.where.b_in_a}, g, pair.box, {});
  merged.interface = interface_triangles(merged.t, g);
  return merged;
}

Merged merge_from_scratch(const Pair& pair) {
  Union common = united(pair);
  Merged merged;
  merged.interface = interface_triangles(common.t, common.g);
  merged.t = std::move(common.t);
  return merged;
}

std::string verdict_on_merge(const Pair& pair, const Triangulation& merged) {
  const auto fault = validate(merged, unite(pair.a.xy, pair.b.xy, pair.box).xy);
  return fault ? "WRONG: " + *fault : "right";
}

}  // namespace isopach::bench
