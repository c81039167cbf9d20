// The small print of folds: what find_borders and its callers need beside overlay/folds.hpp.
#include <cmath>
#include <utility>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/stages.hpp"

namespace isopach::stages {
bool keeps_raster(const Frame& frame, const Pose& pose) {
  return std::fabs(frame.rotation[8]) == 1 && pose.is_identity();
}

bool asks_spreads(const CompareOptions& options) {
  const DuplicatePolicy policy = options.project.duplicates;
  return options.check_layers && (policy == DuplicatePolicy::mean || policy == DuplicatePolicy::median);
}

MergedSpreads merged_spreads(const CloudView& cloud_a, const CloudView& cloud_b, const Pair& pair,
                             const CompareOptions& options) {
  MergedSpreads spreads;
  spreads[0].is_raster = cloud_a.grid.has_value() && keeps_raster(pair.frame, Pose{});
  spreads[1].is_raster = cloud_b.grid.has_value() && keeps_raster(pair.frame, options.pose);
  if (!asks_spreads(options)) return spreads;
  spreads[0].of_node = merged_spread(cloud_a, Pose{}, pair.frame, pair.scan[0].field);
  spreads[1].of_node = merged_spread(cloud_b, options.pose, pair.frame, pair.scan[1].field);
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
