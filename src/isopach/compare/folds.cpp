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
Array<double> merged_spread(const CloudView& cloud, const Pose& pose, const Frame& frame, const HeightField& field) {
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

}  // namespace

MergedSpreads merged_spreads(const CloudView& cloud_a, const CloudView& cloud_b, const Pair& pair,
                             const CompareOptions& options) {
  MergedSpreads spreads;
  const bool along_z = std::fabs(pair.frame.rotation[8]) == 1;
  spreads[0].is_raster = along_z && cloud_a.grid.has_value();
  spreads[1].is_raster = along_z && cloud_b.grid.has_value() && options.pose.is_identity();
  const DuplicatePolicy policy = options.project.duplicates;
  if (!options.check_layers || (policy != DuplicatePolicy::mean && policy != DuplicatePolicy::median)) return spreads;
  const Scan &a = pair.scan[0], &b = pair.scan[1];
  if (a.field.cleaning.duplicates > 0) spreads[0].of_node = merged_spread(cloud_a, Pose{}, pair.frame, a.field);
  if (b.field.cleaning.duplicates > 0) spreads[1].of_node = merged_spread(cloud_b, options.pose, pair.frame, b.field);
  return spreads;
}

Array<unsigned char> with_folds(Array<unsigned char> kept, const Array<unsigned char>& folded) {
  if (kept.empty() || folded.empty()) return kept;
  for_each_index(kept.size(), [&](std::size_t i) { kept[i] = kept[i] != 0 || folded[i] != 0 ? 1 : 0; });
  return kept;
}

Pair as_sampled(const Pair& pair) {
  Pair copy;
  copy.frame = pair.frame;
  for (std::size_t k = 0; k < 2; ++k) {
    const Scan& s = pair.scan[k];
    copy.scan[k] = {s.field, s.t, with_folds(s.kept, s.folded), s.folded, {}};
  }
  return copy;
}

}  // namespace isopach::stages
