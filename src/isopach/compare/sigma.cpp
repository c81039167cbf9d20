// σ of points and nodes, from a constant, an attribute or a raster.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/compare/noise.hpp"

namespace isopach::stages {

namespace {

// σ of each point that became (part of) a node; of no interest elsewhere.
Array<double> sigma_of_points(const CloudView& cloud, const Pose& pose, const SigmaSource& source,
                              const std::string& option) {
  Array<double> sigma(cloud.points.size());
  if (source.kind == SigmaSource::Kind::attribute) {
    const AttributeView* attribute = cloud.find_attribute(source.name);
    if (attribute == nullptr)
      throw InputError(fmt::format("{}: {} has no attribute '{}': `isopach info` lists the attributes of a file",
                                   option, cloud.path.empty() ? "the scan" : cloud.path, source.name));
    return attribute->values.copy();
  }
  if (source.kind == SigmaSource::Kind::raster) {
    if (!source.raster)
      throw UsageError(
          fmt::format("{}: the raster '{}' was named but not read: give its values, too", option, source.name));
    const RasterValues& raster = *source.raster;
    for_each_index(sigma.size(), [&](std::size_t i) {
      sigma[i] = raster.at(pose.is_identity() ? cloud.points[i] : pose.apply(cloud.points[i]));
    });
    return sigma;
  }
  std::fill(sigma.begin(), sigma.end(), source.value);
  return sigma;
}

[[noreturn]] void refuse(double value, std::size_t point, const SigmaSource& source, const std::string& option) {
  if (source.kind == SigmaSource::Kind::raster && std::isnan(value))
    throw InputError(fmt::format("{}: {} has no value at point {} of the scan: the raster must reach all of it", option,
                                 source.name, point + 1));
  throw InputError(
      fmt::format("{}: {} at point {} is no standard deviation: give values of 0 or more", option, value, point + 1));
}

}  // namespace

Array<double> sigma_of_nodes(const CloudView& cloud, const Pose& pose, const HeightField& field,
                             const SigmaSource& source, DuplicatePolicy policy, const std::string& option,
                             const Context& context) {
  context.check();
  const Array<double> of_point = sigma_of_points(cloud, pose, source, option);
  const std::size_t nodes = field.z.size();
  Array<Index> count(nodes);
  std::fill(count.begin(), count.end(), 0);
  Array<double> sigma(nodes);
  for (std::size_t i = 0; i < of_point.size(); ++i) {
    const Index node = field.node_of_point[i];
    if (node == no_index) continue;
    if (!(of_point[i] >= 0) || std::isinf(of_point[i])) refuse(of_point[i], i, source, option);
    sigma[node] = count[node] == 0 ? of_point[i] : std::max(sigma[node], of_point[i]);
    ++count[node];
  }
  if (policy != DuplicatePolicy::mean || nodes == cloud.points.size()) return sigma;
  std::vector<std::pair<Index, double>> merged;  // sorted: a sum that does not depend on the order of the points
  for (std::size_t i = 0; i < of_point.size(); ++i) {
    const Index node = field.node_of_point[i];
    if (node != no_index && count[node] > 1) merged.emplace_back(node, of_point[i]);
  }
  std::sort(merged.begin(), merged.end());
  for (std::size_t i = 0; i < merged.size();) {
    const Index node = merged[i].first;
    Sum squares;
    for (; i < merged.size() && merged[i].first == node; ++i) squares.add(merged[i].second * merged[i].second);
    sigma[node] = std::sqrt(squares.value()) / static_cast<double>(count[node]);
  }
  return sigma;
}

}  // namespace isopach::stages
