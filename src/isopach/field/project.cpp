// project: filter, order along the curve, merge points that share (x, y).
#include <algorithm>
#include <limits>
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

// The kept points in the order of the curve.
struct Sorted {
  Array<Index> point;  // of the cloud
  Array<Point2> xy;
  Array<double> z;
  Array<std::uint64_t> keys;

  [[nodiscard]] std::size_t size() const { return point.size(); }
  [[nodiscard]] bool begins_node(std::size_t k) const { return k == 0 || xy[k] != xy[k - 1]; }
};

[[noreturn]] void refuse_duplicates(const CloudView& cloud, std::size_t duplicates, const Sorted& sorted) {
  const auto twin = std::adjacent_find(sorted.xy.begin(), sorted.xy.end());
  const Point3 p = cloud.points[sorted.point[static_cast<std::size_t>(twin - sorted.xy.begin())]];
  throw InputError(
      fmt::format("{}: {} points share their place in the plane with another point, the first at {}, {}, {}; "
                  "choose how to merge them (duplicates mean, min, max, median or first)",
                  cloud_name(cloud), duplicates, p.x, p.y, p.z));
}

Sorted sort_points(const Filter& filter, const Frame& frame, const Cleaning& cleaning, const Context& context) {
  Kept kept = keep_points(filter, frame, cleaning);
  context.check();
  Sorted s;
  s.point = curve_order(kept.xy, frame.curve, &s.keys);
  context.check();
  const std::size_t n = s.point.size();
  Array<Point2>().swap(kept.xy);
  s.xy.resize(n), s.z.resize(n);
  for_blocks(n, default_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      constexpr std::size_t ahead = 16;  // the points of the cloud lie anywhere
      if (k + ahead < end) prefetch(filter.cloud().points.address(kept.point(s.point[k + ahead])));
      s.point[k] = kept.point(s.point[k]);
      const Point3 p = frame.to_field(filter.posed(s.point[k]));
      s.xy[k] = {p.x, p.y}, s.z[k] = p.z;
    }
  });
  return s;
}

// Points sorted along the curve become nodes: a run of equal (x, y) is one node, made by the block in which it begins.
struct Merger {
  const ProjectOptions& options;
  const Sorted& sorted;
  HeightField& field;

  // The points k.. of `node`. Returns the spread of their heights; `heights` is room to work in.
  double make_node(std::size_t k, Index node, std::vector<double>& heights) const {
    heights.clear();
    do {
      field.node_of_point[sorted.point[k]] = node;
      heights.push_back(sorted.z[k]);
    } while (++k < sorted.size() && !sorted.begins_node(k));
    const double of_first = heights.front();
    field.z[node] = of_first;
    if (heights.size() == 1) return 0;
    std::sort(heights.begin(), heights.end());
    field.z[node] = merged_height(heights, of_first, options.duplicates);
    return heights.back() - heights.front();
  }

  // Fills all of the field but what was cleaned; returns the largest spread.
  [[nodiscard]] double make_nodes(const std::vector<std::size_t>& place) const {
    return reduce_blocks<double>(
        sorted.size(), default_block,
        [&](std::size_t begin, std::size_t end) {
          double spread = 0;
          std::vector<double> heights;
          std::size_t node = place[begin / default_block];
          for (std::size_t k = begin; k < end; ++k) {
            look_ahead(k, end);
            if (!sorted.begins_node(k)) continue;
            field.xy[node] = sorted.xy[k], field.keys[node] = sorted.keys[k];
            spread = std::max(spread, make_node(k, static_cast<Index>(node++), heights));
          }
          return spread;
        },
        [](double& total, double part) { total = std::max(total, part); });
  }

  // Every point is a node.
  void take_all(Sorted& all) const {
    for_blocks(all.size(), default_block, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        look_ahead(k, end);
        field.node_of_point[all.point[k]] = static_cast<Index>(k);
      }
    });
    field.xy = std::move(all.xy), field.z = std::move(all.z), field.keys = std::move(all.keys);
  }

  // Where the nodes of each block begin; sets the number of nodes.
  [[nodiscard]] std::vector<std::size_t> node_places(std::size_t& nodes) const {
    std::vector<std::size_t> place(block_count(sorted.size()));
    for_blocks(sorted.size(), default_block, [&](std::size_t begin, std::size_t end) {
      std::size_t count = 0;
      for (std::size_t k = begin; k < end; ++k) count += sorted.begins_node(k);
      place[begin / default_block] = count;
    });
    nodes = counts_to_places(place);
    return place;
  }

 private:
  // The points of the cloud lie anywhere. Inlined, lest the compiler drops it (see prefetch).
  [[gnu::always_inline]] void look_ahead(std::size_t k, std::size_t end) const {
    constexpr std::size_t ahead = 16;
    if (k + ahead < end) prefetch(&field.node_of_point[sorted.point[k + ahead]]);
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
  Sorted sorted = sort_points(filter, frame, field.cleaning, context);
  context.check();

  const Merger merger{options, sorted, field};
  std::size_t nodes = 0;
  const std::vector<std::size_t> place = merger.node_places(nodes);
  check_size(cloud, nodes, max_nodes, "different places in the plane");
  field.cleaning.duplicates = sorted.size() - nodes;
  if (field.cleaning.duplicates > 0 && options.duplicates == DuplicatePolicy::error)
    refuse_duplicates(cloud, field.cleaning.duplicates, sorted);
  field.node_of_point.resize(cloud.points.size());
  if (sorted.size() < cloud.points.size())
    for_each_index(cloud.points.size(), [&](std::size_t i) { field.node_of_point[i] = no_index; });
  if (nodes == sorted.size()) {
    merger.take_all(sorted);
    return field;
  }
  field.xy.resize(nodes), field.z.resize(nodes), field.keys.resize(nodes);
  field.cleaning.duplicate_max_spread = merger.make_nodes(place);
  return field;
}

Array<double> merged_spread(const CloudView& cloud, const Pose& pose, const Frame& frame, const HeightField& field) {
  if (field.cleaning.duplicates == 0) return {};
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

HeightField project_part(std::span<const Point3> in_frame, const Frame& frame, DuplicatePolicy duplicates,
                         Array<double>* spread, const Context& context) {
  if (in_frame.empty()) return {};
  Frame same;  // of points that are in it already
  same.curve = frame.curve;
  ProjectOptions options;
  options.duplicates = duplicates == DuplicatePolicy::error ? DuplicatePolicy::first : duplicates;
  const CloudView cloud{PointsView(in_frame)};
  HeightField field = project(cloud, Pose{}, same, options, context);
  if (spread != nullptr) *spread = merged_spread(cloud, Pose{}, same, field);
  return field;
}

}  // namespace isopach
