#include "isopach/apps/part_fit.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t query_block = 256;
constexpr double on_surface = 4;  // standard deviations within which a point lies on the frame
// Of the roughness of both scans: what fits worse is another surface, however well it fits by its own measure. Points
// on planes of their neighbours err by about 0.4 of it; two faces fitted to one another by 10.
constexpr double worst_scale = 1.0;
constexpr std::size_t start_sample = 500;

MatchOptions fit_options() {
  MatchOptions o;
  o.objective = Objective::icp_plane;
  o.overlap = 1;
  o.max_iterations = 60;
  o.tolerance = 1e-6;
  return o;
}

}  // namespace

std::string not_on_frame(bool moving) {
  return moving ? "the part that moves does not lie on it within the noise of the scans: it is not seen there, or went "
                  "too far since the frame before; give the frames between, or leave this one out"
                : "the part that stays does not lie on it within the noise of the scans: another object, or turned or "
                  "shifted against the frame before; bring it there with isopach match @coarse, or leave it out";
}

double surface_distance(const OrientedCloud& frame, const Point3& place, double reach) {
  const PointTree::Two two = frame.tree->nearest_two(place);
  const double far = std::sqrt(two.first2);
  const Point3 normal = frame.normals[two.first];
  if (far > reach || squared_length(normal) == 0) return far;
  return std::fabs(dot(place - frame.points[two.first], normal));
}

double misfit(const OrientedCloud& part, const OrientedCloud& frame, const Motion& motion) {
  const std::size_t n = part.points.size(), stride = std::max<std::size_t>(1, n / start_sample);
  Array<double> far((n + stride - 1) / stride);
  for_blocks(far.size(), query_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      far[k] = frame.tree->nearest_distance2(motion.apply(part.points[k * stride]));
  });
  return median(far);
}

OrientedCloud part_of(const OrientedCloud& model, std::span<const unsigned char> flag) {
  OrientedCloud part;
  part.slope_noise = model.slope_noise;
  part.roughness = model.roughness;
  for (std::size_t i = 0; i < flag.size(); ++i) {
    if (flag[i] == 0) continue;
    part.points.push_back(model.points[i]);
    part.ids.push_back(model.ids[i]);
    part.normals.push_back(model.normals[i]);
    part.boundary.push_back(model.boundary[i]);
    part.areas.push_back(model.areas[i]);
  }
  return part;
}

FrameScale frame_scale(const OrientedCloud& model, const OrientedCloud& frame, const PartFit& fit) {
  const std::size_t n = model.points.size(), stride = std::max<std::size_t>(1, n / (4 * start_sample));
  Array<double> far((n + stride - 1) / stride);
  for_blocks(far.size(), query_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      far[k] = frame.tree->nearest_distance2(fit.motion.apply(model.points[k * stride]));
  });
  return {fit.scale, 3 * std::sqrt(median(far))};
}

std::optional<PartFit> fit_part(const OrientedCloud& part, const OrientedCloud& frame, std::span<const Motion> starts,
                                const Context& context) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < starts.size() && starts.size() > 1; ++i) {
    const double value = misfit(part, frame, starts[i]);
    if (value < least) least = value, best = i;
  }
  try {
    IcpState state = icp_search(part, frame, starts[best], fit_options(), FirstLevel::once, context);
    PartFit fit;
    fit.motion = state.motion;
    fit.rms = std::sqrt(state.information.error);
    fit.information = state.information;
    Array<double> sizes(state.links.size());
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      const Link& l = state.links[i];
      sizes[i] = std::fabs(dot(l.moving - l.fixed, l.normal));
    }
    fit.scale = mad_to_sigma * median(sizes);
    const double within = on_surface * std::min(fit.scale, worst_scale * std::hypot(part.roughness, frame.roughness));
    std::size_t on = 0;
    for (const Link& l : state.links)
      if (std::fabs(dot(l.moving - l.fixed, l.normal)) <= within) ++on;
    fit.support = static_cast<double>(on) / static_cast<double>(part.points.size());
    return fit;
  } catch (const OverlapError&) {
    return std::nullopt;
  }
}

std::array<double, 36> covariance_of(const PartFit& fit, double floor, std::vector<std::string>& weak_directions) {
  const double n = fit.information.weight / static_cast<double>(normal_neighbours);
  const double sigma2 = fit.information.error * n / std::max(1.0, n - 6);
  return pair_covariance(fit.information, sigma2, n, floor, {"x", "y", "z"}, weak_directions);
}

void flatten(OrientedCloud& cloud) {
  for_each_index(cloud.points.size(),
                 [&](std::size_t i) { cloud.points[i] = cloud.points[i] - cloud.height[i] * cloud.normals[i]; });
  cloud.tree = std::make_unique<PointTree>(cloud.points);
  cloud.boxes = std::make_unique<BoxTree>(cloud.points);
}

OrientedCloud thinned(const OrientedCloud& cloud, std::size_t most) {
  const std::size_t stride = std::max<std::size_t>(1, (cloud.points.size() + most / 2) / most);
  OrientedCloud result;
  result.slope_noise = cloud.slope_noise;
  result.roughness = cloud.roughness;
  for (std::size_t i = 0; i < cloud.points.size(); i += stride) {
    result.points.push_back(cloud.points[i]);
    result.ids.push_back(cloud.ids[i]);
    if (cloud.normals.empty()) continue;
    result.normals.push_back(cloud.normals[i]);
    result.boundary.push_back(cloud.boundary[i]);
    result.areas.push_back(cloud.areas[i]);
  }
  return result;
}

}  // namespace isopach
