// project: filter, order along the curve, merge points that share (x, y).
#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "isopach/base/error.hpp"
#include "isopach/base/prefetch.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/field/filter.hpp"
#include "isopach/field/height_field.hpp"

namespace isopach {
namespace {

// One height for a node, from the heights of its points in ascending order: independent of the order of the input.
double merged_height(const std::vector<double>& sorted, double of_first, DuplicatePolicy policy) {
  const std::size_t n = sorted.size();
  const double low = sorted.front();
  switch (policy) {
    case DuplicatePolicy::mean: {
      Sum sum;  // of what exceeds the lowest, so that equal heights keep their bits
      for (const double z : sorted) sum.add(z - low);
      return std::min(low + sum.value() / static_cast<double>(n), sorted.back());
    }
    case DuplicatePolicy::min:
      return low;
    case DuplicatePolicy::max:
      return sorted.back();
    case DuplicatePolicy::median: {
      const double lower = sorted[(n - 1) / 2], upper = sorted[n / 2];
      return lower + (upper - lower) / 2;
    }
    case DuplicatePolicy::first:
    case DuplicatePolicy::error:
      return of_first;
  }
  throw UsageError("unknown duplicate policy");
}

[[noreturn]] void refuse_duplicates(const CloudView& cloud, std::size_t duplicates, const Array<Point2>& sorted,
                                    const Array<Index>& order, const Kept& kept) {
  const auto twin = std::adjacent_find(sorted.begin(), sorted.end());
  const Point3 p = cloud.points[kept.point(order[static_cast<std::size_t>(twin - sorted.begin())])];
  throw InputError(
      fmt::format("{}: {} points share their place in the plane with another point, the first at {}, {}, {}; "
                  "choose how to merge them (duplicates mean, min, max, median or first)",
                  cloud_name(cloud), duplicates, p.x, p.y, p.z));
}

Array<Point2> gather(const Array<Point2>& xy, const Array<Index>& order) {
  Array<Point2> result(order.size());
  for_each_index(order.size(), [&](std::size_t k) { result[k] = xy[order[k]]; });
  return result;
}

// Points sorted along the curve become nodes: a run of equal (x, y) is one node, made by the block in which it begins.
struct Merger {
  const Filter& filter;
  const Frame& frame;
  const ProjectOptions& options;
  const Kept& kept;
  const Array<Index>& order;
  const Array<Point2>& sorted;
  HeightField& field;

  [[nodiscard]] bool begins_node(std::size_t k) const { return k == 0 || sorted[k] != sorted[k - 1]; }

  [[nodiscard]] double height(Index point) const { return frame.to_field(filter.posed(point)).z; }

  // The points k.. of `node`. Returns the spread of their heights; `heights` is room to work in.
  double make_node(std::size_t k, Index node, std::vector<double>& heights) const {
    const Index first = kept.point(order[k]);
    const double of_first = height(first);
    field.node_of_point[first] = node;
    field.z[node] = of_first;
    if (k + 1 == sorted.size() || begins_node(k + 1)) return 0;
    heights.assign(1, of_first);
    for (std::size_t i = k + 1; i < sorted.size() && !begins_node(i); ++i) {
      const Index point = kept.point(order[i]);
      field.node_of_point[point] = node;
      heights.push_back(height(point));
    }
    std::sort(heights.begin(), heights.end());
    field.z[node] = merged_height(heights, of_first, options.duplicates);
    return heights.back() - heights.front();
  }

  // Fills z, node_of_point and, if given, xy; returns the largest spread.
  [[nodiscard]] double make_nodes(const std::vector<std::size_t>& place, Array<Point2>* xy) const {
    return reduce_blocks<double>(
        sorted.size(), default_block,
        [&](std::size_t begin, std::size_t end) {
          double spread = 0;
          std::vector<double> heights;
          std::size_t node = place[begin / default_block];
          for (std::size_t k = begin; k < end; ++k) {
            constexpr std::size_t ahead = 16;  // the points of the cloud lie anywhere
            if (k + ahead < end) {
              const Index point = kept.point(order[k + ahead]);
              prefetch(filter.cloud().points.address(point));
              prefetch(&field.node_of_point[point]);
            }
            if (!begins_node(k)) continue;
            if (xy != nullptr) (*xy)[node] = sorted[k];
            spread = std::max(spread, make_node(k, static_cast<Index>(node++), heights));
          }
          return spread;
        },
        [](double& total, double part) { total = std::max(total, part); });
  }

  // Where the nodes of each block begin; sets the number of nodes.
  [[nodiscard]] std::vector<std::size_t> node_places(std::size_t& nodes) const {
    std::vector<std::size_t> place(block_count(sorted.size()));
    for_blocks(sorted.size(), default_block, [&](std::size_t begin, std::size_t end) {
      std::size_t count = 0;
      for (std::size_t k = begin; k < end; ++k) count += begins_node(k);
      place[begin / default_block] = count;
    });
    nodes = counts_to_places(place);
    return place;
  }
};

}  // namespace

HeightField project(const CloudView& cloud, const Pose& pose, const Frame& frame, const ProjectOptions& options,
                    const Context& context) {
  context.check();
  const Filter filter(cloud, pose, options);
  HeightField field;
  field.cleaning = count_dropped(filter);
  require_points(cloud, field.cleaning);
  Kept kept = keep_points(filter, frame, field.cleaning);
  context.check();
  const Array<Index> order = curve_order(kept.xy, frame.curve);
  context.check();
  Array<Point2> sorted = gather(kept.xy, order);
  Array<Point2>().swap(kept.xy);

  const Merger merger{filter, frame, options, kept, order, sorted, field};
  std::size_t nodes = 0;
  const std::vector<std::size_t> place = merger.node_places(nodes);
  check_size(cloud, nodes, max_nodes, "different places in the plane");
  field.cleaning.duplicates = sorted.size() - nodes;
  if (field.cleaning.duplicates > 0 && options.duplicates == DuplicatePolicy::error)
    refuse_duplicates(cloud, field.cleaning.duplicates, sorted, order, kept);
  field.node_of_point.resize(cloud.points.size());
  if (sorted.size() < cloud.points.size())
    for_each_index(cloud.points.size(), [&](std::size_t i) { field.node_of_point[i] = no_index; });
  field.z.resize(nodes);
  if (nodes < sorted.size()) field.xy.resize(nodes);
  field.cleaning.duplicate_max_spread = merger.make_nodes(place, nodes < sorted.size() ? &field.xy : nullptr);
  if (nodes == sorted.size()) field.xy = std::move(sorted);
  return field;
}

}  // namespace isopach
