#include "isopach/compare/weighting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/expression.hpp"
#include "isopach/overlay/interpolate.hpp"

namespace isopach::stages {

namespace {

using Kind = WeightSource::Kind;
using Scan = WeightSource::Scan;

std::string name_of(const Cloud& cloud, const char* role) {
  return cloud.path.empty() ? std::string("scan ") + role : cloud.path;
}

}  // namespace

Array<double> attribute_of_nodes(const Cloud& cloud, const Attribute& attribute, const HeightField& field,
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
      throw InputError(fmt::format("--weight: attribute '{}' of {} is {} at point {}: weights are finite and 0 or more",
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
    throw UsageError(
        "--weight: it is of two piecewise linear surfaces: leave --interpolation cubic out, or the weight");
  if (options.weight.kind == Kind::expression) (void)Expression(options.weight.text, "--weight");
}

void Weighting::take_points(const Cloud& a, const Cloud& b, const HeightField& field_a, const HeightField& field_b,
                            Comparison& c) {
  if (!asked()) return;
  const auto& r = c.frame.rotation;
  const Point3& o = c.frame.origin;
  origin_ = {r[0] * o.x + r[1] * o.y + r[2] * o.z, r[3] * o.x + r[4] * o.y + r[5] * o.z,
             r[6] * o.x + r[7] * o.y + r[8] * o.z};
  const std::string& text = options_.weight.text;
  if (is_attribute()) {
    const Scan scan = options_.weight.scan;
    const Attribute* of_a = scan == Scan::b ? nullptr : a.find_attribute(text);
    const Attribute* of_b = scan == Scan::a ? nullptr : b.find_attribute(text);
    if (of_a == nullptr && of_b == nullptr)
      throw InputError(fmt::format("--weight: {} attribute '{}': `isopach info` lists the attributes of a file",
                                   scan == Scan::a ? name_of(a, "A") + " has no"
                                   : scan == Scan::b
                                       ? name_of(b, "B") + " has no"
                                       : "neither " + name_of(a, "A") + " nor " + name_of(b, "B") + " has an",
                                   text));
    of_b_ = of_b != nullptr;
    own_ = of_b_ ? attribute_of_nodes(b, *of_b, field_b, name_of(b, "B"))
                 : attribute_of_nodes(a, *of_a, field_a, name_of(a, "A"));
  }
  if (options_.weight.kind != Kind::raster) return;
  if (r != std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1})
    throw UsageError(
        "--weight: a raster is in x and y, so it goes with --direction z alone: leave the direction, or "
        "give a formula");
  raster_.emplace(text, "--weight", context_);
  const std::string& crs = !a.crs.empty() ? a.crs : b.crs;
  if (!crs.empty() && !raster_->crs().empty() && crs != raster_->crs())
    c.warnings.push_back("--weight: " + text +
                         " names its coordinate system differently from the scans; it is taken as it stands");
}

void Weighting::take_meshes(const OverlayMesh& m1, const OverlayMesh& m2) {
  if (!is_attribute()) return;
  const OverlayMesh &own = of_b_ ? m2 : m1, &other = of_b_ ? m1 : m2;
  at_other_ = interpolate(other.in_other, other.xy, own.t, own.xy, own_, context_);
}

void Weighting::take_overlay(const Overlay& overlay, const OverlayMesh& m1, const OverlayMesh& m2, const Clip* clip) {
  of_overlay_ = weigh(overlay, m1, m2, own_, of_b_, weight(), clip, context_);
}

void Weighting::take_union(const UnitedNodes& nodes) {
  if (!is_attribute()) return;
  const Array<Index>&own = of_b_ ? nodes.of_2 : nodes.of_1, &other = of_b_ ? nodes.of_1 : nodes.of_2;
  at_union_.resize(own.size());
  for_each_index(own.size(),
                 [&](std::size_t i) { at_union_[i] = own[i] != no_index ? own_[own[i]] : at_other_[other[i]]; });
}

void Weighting::describe(Comparison& c) const {
  if (!asked()) return;
  c.weighted = of_overlay_ ? *of_overlay_ : weigh(c.cells.view(), at_union_, weight(), context_);
  if (!(c.weighted->integral > 0))
    c.warnings.push_back("--weight: it is 0 everywhere on the area compared: check its coordinates");
}

Weight Weighting::weight() const {
  if (is_attribute()) return LinearWeight{};
  if (raster_) return RasterWeight{*raster_, options_.weight.text, origin_};
  return ExpressionWeight{options_.weight.text, origin_};
}

}  // namespace isopach::stages
