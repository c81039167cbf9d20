#include "isopach/compare/weighting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/overlay/interpolate.hpp"

namespace isopach::stages {

namespace {

using Kind = WeightSource::Kind;
using From = WeightSource::Scan;

std::string name_of(const CloudView& cloud, const char* role) {
  return cloud.path.empty() ? std::string("scan ") + role : cloud.path;
}

}  // namespace

Array<double> attribute_of_nodes(const CloudView& cloud, const AttributeView& attribute, const HeightField& field,
                                 const std::string& file) {
  Index nodes = 0;
  for (const Index node : field.node_of_point)
    if (node != no_index) nodes = std::max(nodes, node + 1);
  std::vector<std::pair<Index, double>> of_node;
  of_node.reserve(attribute.values.size());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Index node = field.node_of_point[i];
    if (node == no_index) continue;
    const double value = attribute.values[i];
    if (!(value >= 0) || std::isinf(value))
      throw InputError(fmt::format("@weight: attribute '{}' of {} is {} at point {}: weights are finite and 0 or more",
                                   attribute.name, file, value, i + 1));
    of_node.emplace_back(node, value);
  }
  std::sort(of_node.begin(), of_node.end());
  Array<double> values(nodes);
  for (std::size_t i = 0; i < of_node.size();) {
    const Index node = of_node[i].first;
    Sum sum;
    const std::size_t first = i;
    for (; i < of_node.size() && of_node[i].first == node; ++i) sum.add(of_node[i].second);
    values[node] = sum.value() / static_cast<double>(i - first);
  }
  return values;
}

void check_weight(const CompareOptions& options) {
  if (options.weight.kind == Kind::none) return;
  if (options.interpolation == Interpolation::cubic)
    throw UsageError("@weight: it is of two piecewise linear surfaces: leave @interpolation cubic out, or the weight");
}

void check_read(const WeightSource& source) {
  const bool lacks_formula = source.kind == Kind::expression && !source.formula;
  if (lacks_formula || (source.kind == Kind::raster && !source.raster))
    throw UsageError(fmt::format("@weight: the {} '{}' was named but not read: give {}, too",
                                 lacks_formula ? "formula" : "raster", source.text,
                                 lacks_formula ? "the function" : "its values"));
}

NodeWeight weight_of_nodes(const CloudView& a, const CloudView& b, const Pair& pair, Comparison& c) {
  const WeightSource& source = c.options.weight;
  NodeWeight w;
  if (source.kind == Kind::none) return w;
  const auto& r = pair.frame.rotation;
  const Point3& o = pair.frame.origin;
  w.origin = {r[0] * o.x + r[1] * o.y + r[2] * o.z, r[3] * o.x + r[4] * o.y + r[5] * o.z,
              r[6] * o.x + r[7] * o.y + r[8] * o.z};
  const std::string& text = source.text;
  check_read(source);
  if (source.kind == Kind::attribute) {
    const AttributeView* of_a = source.scan == From::b ? nullptr : a.find_attribute(text);
    const AttributeView* of_b = source.scan == From::a ? nullptr : b.find_attribute(text);
    if (of_a == nullptr && of_b == nullptr)
      throw InputError(fmt::format("@weight: {} attribute '{}': `isopach info` lists the attributes of a file",
                                   source.scan == From::a ? name_of(a, "A") + " has no"
                                   : source.scan == From::b
                                       ? name_of(b, "B") + " has no"
                                       : "neither " + name_of(a, "A") + " nor " + name_of(b, "B") + " has an",
                                   text));
    w.scan = of_b != nullptr ? 1 : 0;
    w.own = of_b != nullptr ? attribute_of_nodes(b, *of_b, pair.scan[1].field, name_of(b, "B"))
                            : attribute_of_nodes(a, *of_a, pair.scan[0].field, name_of(a, "A"));
  }
  if (source.kind != Kind::raster) return w;
  if (r != std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1})
    throw UsageError(
        "@weight: a raster is in x and y, so it goes with @direction z alone: leave the direction, or "
        "give a formula");
  w.raster = source.raster;
  const std::string& crs = !a.crs.empty() ? a.crs : b.crs;
  if (!crs.empty() && !w.raster->crs().empty() && crs != w.raster->crs())
    c.warnings.push_back("@weight: " + text +
                         " names its coordinate system differently from the scans; it is taken as it stands");
  return w;
}

Weighting::Weighting(NodeWeight weight, const Pair& pair, const CompareOptions& options, const Context& context)
    : options_(options), context_(context), weight_(std::move(weight)) {
  if (!is_attribute()) return;
  const Scan &own = pair.scan[weight_.scan], &other = pair.scan[1 - weight_.scan];
  at_other_ =
      isopach::interpolate(pair.seen[1 - weight_.scan].at, other.field.xy, own.t, own.field.xy, weight_.own, context_);
}

WeightedMeasures Weighting::over(const OverlayCells& cells, const Pair& pair) const {
  const OverlayMesh m1 = pair.mesh(0), m2 = pair.mesh(1);
  return weigh(cells, {m1, m2, weight_.own, weight_.scan == 1}, weight(), context_);
}

Array<double> Weighting::at(const UnitedNodes& nodes) const {
  Array<double> values;
  if (!is_attribute()) return values;
  const bool of_b = weight_.scan == 1;
  const Array<Index>&own = of_b ? nodes.of_2 : nodes.of_1, &other = of_b ? nodes.of_1 : nodes.of_2;
  values.resize(own.size());
  for_each_index(own.size(),
                 [&](std::size_t i) { values[i] = own[i] != no_index ? weight_.own[own[i]] : at_other_[other[i]]; });
  return values;
}

void Weighting::describe(const Array<double>& at_nodes, const std::optional<WeightedMeasures>& over_overlay,
                         Comparison& c) const {
  if (!asked()) return;
  c.weighted = over_overlay ? *over_overlay : weigh(c.cells.view(), at_nodes, weight(), context_);
  if (!(c.weighted->integral > 0))
    c.warnings.push_back("@weight: it is 0 everywhere on the area compared: check its coordinates");
}

Weight Weighting::weight() const {
  if (is_attribute()) return LinearWeight{};
  if (weight_.raster) return RasterWeight{*weight_.raster, options_.weight.text, weight_.origin};
  return ExpressionWeight{options_.weight.text, options_.weight.formula, weight_.origin};
}

}  // namespace isopach::stages
