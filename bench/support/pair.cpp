#include "bench/support/pair.hpp"

#include "isopach/base/random.hpp"
#include "isopach/delaunay/validate.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/localise.hpp"

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

Triangulation merge(const Pair& pair) {
  const UnitedNodes g = unite(pair.a.xy, pair.b.xy, pair.box);
  return triangulate(g.xy, pair.box, {});
}

std::string verdict_on_merge(const Pair& pair, const Triangulation& merged) {
  const auto fault = validate(merged, unite(pair.a.xy, pair.b.xy, pair.box).xy);
  return fault ? "WRONG: " + *fault : "right";
}

std::string merge_description() { return "both node lists merged in curve order, then triangulated from scratch"; }

}  // namespace isopach::bench
