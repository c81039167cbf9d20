// The small print of folds: what find_borders and its callers need beside overlay/folds.hpp.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/stages.hpp"

namespace isopach::stages {
namespace {

// Heights of points are asked for again: a comparison keeps one for each node.
Array<double> merged_spread(const Cloud& cloud, const Pose& pose, const Frame& frame, const HeightField& field) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Array<double> least(field.xy.size(), infinity), most(field.xy.size(), -infinity);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Index node = field.node_of_point[i];
    if (node == no_index) continue;
    const double z = frame.to_field(pose.apply(cloud.points[i])).z;
    least[node] = std::min(least[node], z), most[node] = std::max(most[node], z);
  }
  for_each_index(most.size(), [&](std::size_t k) { most[k] -= least[k]; });
  return most;
}

// A node with all of its triangles in folds.
Array<unsigned char> nodes_outside(const Margin& with, const Margin& without) {
  Array<unsigned char> flags(with.side.size());
  for_each_index(flags.size(), [&](std::size_t i) {
    flags[i] = with.side[i] != Side::outside && without.side[i] == Side::outside ? 1 : 0;
  });
  return flags;
}

}  // namespace

MergedSpreads merged_spreads(const Cloud& cloud_a, const Cloud& cloud_b, const HeightField& a, const HeightField& b,
                             const Comparison& c) {
  MergedSpreads spreads;
  const bool along_z = std::fabs(c.frame.rotation[8]) == 1;
  spreads.raster_a = along_z && cloud_a.grid.has_value();
  spreads.raster_b = along_z && cloud_b.grid.has_value() && c.options.pose.is_identity();
  const DuplicatePolicy policy = c.options.project.duplicates;
  if (!c.options.check_layers || (policy != DuplicatePolicy::mean && policy != DuplicatePolicy::median)) return spreads;
  if (a.cleaning.duplicates > 0) spreads.a = merged_spread(cloud_a, Pose{}, c.frame, a);
  if (b.cleaning.duplicates > 0) spreads.b = merged_spread(cloud_b, c.options.pose, c.frame, b);
  return spreads;
}

Array<unsigned char> with_folds(Array<unsigned char> kept, const Array<unsigned char>& folded) {
  if (kept.empty() || folded.empty()) return kept;
  for_each_index(kept.size(), [&](std::size_t i) { kept[i] = kept[i] != 0 || folded[i] != 0 ? 1 : 0; });
  return kept;
}

ScanMeshes meshes_of(const Comparison& c, const HeightField& a, const HeightField& b, const Triangulation& t1,
                     const Triangulation& t2, const Borders& borders) {
  return {c.frame,
          a,
          b,
          t1,
          t2,
          with_folds(borders.kept_1, borders.folded_1),
          with_folds(borders.kept_2, borders.folded_2),
          borders.folded_1,
          borders.folded_2};
}

NodesLeftOut nodes_in_folds(const Borders& borders) {
  if (!borders.left_out) return {};
  return {nodes_outside(borders.in_1.own, borders.single->in_1.own),
          nodes_outside(borders.in_2.own, borders.single->in_2.own)};
}

}  // namespace isopach::stages
