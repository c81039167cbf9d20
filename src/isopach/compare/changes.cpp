#include "isopach/compare/changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "isopach/base/error.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/measure/changes/change_nodes.hpp"

namespace isopach::stages {
namespace {

constexpr double points_of_least = 10;  // of the sparser scan: the smallest object that is told, unless asked otherwise

void count_points(const Array<Index>& object_of, const UnitedNodes& nodes, const PointCounts& points,
                  std::vector<Change>& list) {
  const std::array<const Array<Index>*, 2> of_scan{&nodes.of_1, &nodes.of_2};
  for (std::size_t node = 0; node < object_of.size(); ++node) {
    if (object_of[node] == no_index) continue;
    for (std::size_t scan = 0; scan < 2; ++scan)
      if (const Index own = (*of_scan[scan])[node]; own != no_index)
        list[object_of[node]].points[scan] += points[scan][own];
  }
}

/// One object's weights on the nodes of a scan.
struct ObjectWeights {
  NodeWeights weights;
  Array<double> sigma;
  Array<Point2> xy;

  void add(double weight, double s) { weights.push_back({weight, 0, 0}), sigma.push_back(s); }
};

}  // namespace

ChangeLevel change_level(const Comparison& c) {
  if (c.options.changes.height > 0) return ChangeLevel(c.options.changes.height);
  if (c.options.uncertainty.lod > 0) return ChangeLevel(c.options.uncertainty.lod);
  return ChangeLevel(c.cells.lod);
}

double least_change_area(const Comparison& c) {
  if (c.options.changes.min_area) return *c.options.changes.min_area;
  const std::size_t fewer = std::min(c.compared_points[0], c.compared_points[1]);
  return points_of_least * c.domain_area / static_cast<double>(std::max<std::size_t>(1, fewer));
}

void check_changes(const CompareOptions& options) {
  const ChangeOptions& o = options.changes;
  const auto size = [](const char* option, double value, const char* what) {
    if (!(value >= 0) || std::isinf(value))
      throw UsageError(fmt::format("{}: {} is no {}, give one of 0 or more", option, value, what));
  };
  size("@change-height", o.height, "height");
  size("@min-change-volume", o.min_volume, "volume");
  size("@min-change-area", o.min_area.value_or(0), "area");
  if (!o.asked) {
    if (o.height > 0 || o.min_volume > 0 || o.min_area)
      throw UsageError(fmt::format("{}: acts with @changes alone", o.height > 0       ? "@change-height"
                                                                   : o.min_volume > 0 ? "@min-change-volume"
                                                                                      : "@min-change-area"));
    return;
  }
  if (options.surface == Surface::overlay)
    throw UsageError("@changes: they are cut out of the common triangulation: take @surface common or both");
  const UncertaintyOptions& u = options.uncertainty;
  if (!(o.height > 0) && !(u.lod > 0) && u.sigma1.kind == SigmaSource::Kind::none)
    throw UsageError(
        "@changes: what counts as changed? give a level of detection by @lod, or @sigma1 and @sigma2, or a height by "
        "@change-height");
}

void check_changes(const CompareOptions& options, const Frame& frame) {
  if (!options.changes.asked) return;
  if (frame.rotation[6] == 0 && frame.rotation[7] == 0 && frame.rotation[8] == 1) return;
  throw UsageError(
      "@changes: their outlines are in x and y, so they go with @direction z alone; leave the direction, or turn the "
      "scans by @pose");
}

Array<Index> points_of_nodes(const HeightField& field) {
  Array<Index> count(field.z.size(), 0);
  for (const Index node : field.node_of_point)
    if (node != no_index) ++count[node];
  return count;
}

PointCounts points_of_nodes(const Pair& pair, const CompareOptions& options) {
  if (!options.changes.asked) return {};
  return {points_of_nodes(pair.scan[0].field), points_of_nodes(pair.scan[1].field)};
}

void describe_changes(const UnitedNodes& nodes, const PointCounts& points, const Noise& noise, Comparison& c,
                      const Context& context) {
  if (!c.options.changes.asked) return;
  const ChangeLevel level = change_level(c);
  const CellView cells = bounded_cells(c);
  FoundChanges found = find_changes(cells, level, c.options.changes, least_change_area(c), context);
  std::vector<Change>& list = found.changes.list;
  count_points(object_of_nodes(cells, level, found), nodes, points, list);
  noise.describe_changes(nodes, cells, level, found);
  c.changes = std::move(found.changes);
}

// The weights of the nodes of T on the nodes of a scan that make its height there, object by object; within one in the
// order of the scan's nodes, so that sums do not depend on how T was made.
void Noise::add_variances(std::size_t scan, const UnitedNodes& nodes, const std::vector<ChangeWeight>& of_t,
                          std::vector<double>& variance) const {
  const Array<Index>&own = scan == 0 ? nodes.of_1 : nodes.of_2, &other = scan == 0 ? nodes.of_2 : nodes.of_1;
  std::vector<ChangeWeight> of_scan;
  for (const ChangeWeight& w : of_t) {
    if (own[w.node] != no_index) {
      of_scan.push_back({w.object, own[w.node], w.weight});
      continue;
    }
    const Stencil& s = in_other_[1 - scan][other[w.node]];
    for (std::size_t k = 0; k < 3; ++k)
      if (s.weight[k] > 0) of_scan.push_back({w.object, s.node[k], w.weight * s.weight[k]});
  }
  std::stable_sort(of_scan.begin(), of_scan.end(), [](const ChangeWeight& a, const ChangeWeight& b) {
    return a.object != b.object ? a.object < b.object : a.node < b.node;
  });
  const UncertaintyOptions& o = options_.uncertainty;
  const bool correlated = o.model != UncertaintyModel::independent && o.correlation_range > 0;
  for (std::size_t i = 0; i < of_scan.size();) {
    const Index object = of_scan[i].object;
    ObjectWeights w;
    Box2 box;
    while (i < of_scan.size() && of_scan[i].object == object) {
      const Index node = of_scan[i].node;
      double weight = 0;
      for (; i < of_scan.size() && of_scan[i].object == object && of_scan[i].node == node; ++i)
        weight += of_scan[i].weight;
      w.add(weight, sigma_[scan][node]);
      if (correlated) w.xy.push_back(xy_[scan][node]), box.add(xy_[scan][node]);
    }
    const bool has_extent = correlated && (box.max.x > box.min.x || box.max.y > box.min.y);
    variance[object] +=
        (has_extent ? correlated_variance(w.weights, w.sigma, w.xy, o.correlation, o.correlation_range, context_)
                    : independent_variance(w.weights, w.sigma))
            .net;
  }
}

void Noise::describe_changes(const UnitedNodes& nodes, const CellView& cells, const ChangeLevel& level,
                             FoundChanges& found) const {
  std::vector<Change>& list = found.changes.list;
  if (!has_model() || list.empty()) return;
  std::vector<double> variance(list.size(), 0);
  for (std::size_t scan = 0; has_sigmas() && scan < 2; ++scan)
    add_variances(scan, nodes, weights_in_changes(cells, level, found, scan), variance);
  std::vector<MotionGradient> motions;
  if (has_covariance()) motions = motions_of_changes(cells, level, found, covariance_->centre);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const double moved = has_covariance() ? std::sqrt(isopach::variance(motions[i], *covariance_))
                                          : options_.uncertainty.registration_error * list[i].area;
    list[i].sigma = std::hypot(std::sqrt(variance[i]), moved);
  }
}

}  // namespace isopach::stages
