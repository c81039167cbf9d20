#include "isopach/match/checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isopach {

void check_options(const MatchOptions& o) {
  if (!(o.overlap >= 0 && o.overlap <= 1))
    throw UsageError(fmt::format("@overlap: {} is no share: auto, or a number above 0 and up to 1", o.overlap));
  if (o.max_iterations < 1) throw UsageError("@max-iterations: at least 1");
  if (!(o.tolerance >= 0) || o.tolerance >= 1)
    throw UsageError(
        fmt::format("@tolerance: {} is no share of the extent: a number above 0 and below 1, e.g. 1e-8", o.tolerance));
  if (o.objective != Objective::currents && o.sigma != 0)
    throw UsageError("@sigma: it is the width of the kernel of currents: add @objective currents");
  if (!(o.sigma >= 0) || std::isinf(o.sigma))
    throw UsageError(fmt::format("@sigma: {} is no width, give a length above 0", o.sigma));
  const Freedom& f = o.freedom;
  if (!(f.shift_x || f.shift_y || f.shift_z || f.turn_x || f.turn_y || f.turn_z || f.scale))
    throw UsageError("@freedom: no motion is left to search: allow at least one");
  if (o.objective != Objective::measure && o.compare.weight.kind != WeightSource::Kind::none)
    throw UsageError("@weight: it weighs surfaces: leave it out, or take @objective measure");
  if (!o.compare.pose.is_identity()) throw UsageError("@pose: a matching starts at @start and finds the pose itself");
  const IcpOptions& icp = o.icp;
  if (!(icp.reject_distance >= 0) || !std::isfinite(icp.reject_distance))
    throw UsageError(
        fmt::format("@reject-distance: {} is no distance: a length, medians such as 3x, or none", icp.reject_distance));
  if (!(icp.reject_normal >= 0) || icp.reject_normal > 90)
    throw UsageError(fmt::format(
        "@reject-normal: {} is no angle between normals: above 0 and up to 90 degrees, or none", icp.reject_normal));
  const bool pairs = of_pairs(o.objective);
  if (pairs && o.compare.weight.kind != WeightSource::Kind::none)
    throw UsageError("@weight: pairs of points have weights of their own: leave it out, or take @objective measure");
  if (!pairs && icp != IcpOptions{})
    throw UsageError(
        "@reject-distance, @reject-normal, @reject-boundary, @one-to-one, @symmetric and @pair-weights speak of "
        "pairs: they need @objective icp-plane, icp-gicp or icp-point");
}

namespace {

/// The rows and columns of what an undetermined motion changes, by more than a twentieth of what it changes most.
void blank(const std::array<double, 6>& motion, double radius, std::array<double, 36>& covariance) {
  constexpr double noticeable = 0.05;
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const auto size = [&](std::size_t i) { return std::fabs(motion[i]) * (i < 3 ? radius : 1); };
  double largest = 0;
  for (std::size_t i = 0; i < 6; ++i) largest = std::max(largest, size(i));
  for (std::size_t i = 0; i < 6; ++i) {
    if (!(size(i) > noticeable * largest)) continue;
    for (std::size_t j = 0; j < 6; ++j) covariance[6 * i + j] = covariance[6 * j + i] = unknown;
  }
}

}  // namespace

bool all_rigid_motions(const Freedom& f) {
  return f.shift_x && f.shift_y && f.shift_z && f.turn_x && f.turn_y && f.turn_z;
}

std::array<std::string, 3> axis_names(const Frame& frame) {
  std::array<std::string, 3> names{"u", "v", "w"};
  if (!frame.axis_aligned) return names;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      if (frame.rotation[3 * i + k] != 0) names[i] = std::string(1, "xyz"[k]);
  return names;
}

void take_covariance(const SearchResult& found, const Frame& frame, Matching& m) {
  const auto& r = frame.rotation;  // input = rᵀ · field, for the rotation vector and for the shift alike
  const auto turned = [&](std::size_t i, std::size_t j, std::size_t block_i, std::size_t block_j) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 0; l < 3; ++l)
        sum += r[3 * k + i] * r[3 * l + j] * found.covariance[7 * (3 * block_i + k) + 3 * block_j + l];
    return sum;
  };
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) m.covariance[6 * i + j] = turned(i % 3, j % 3, i / 3, j / 3);
  m.undetermined.clear();
  for (const Twist& t : found.undetermined) {
    std::array<double, 6> motion{};
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t k = 0; k < 3; ++k) motion[i] += r[3 * k + i % 3] * t[i / 3 * 3 + k];
    blank(motion, found.radius, m.covariance);
    m.undetermined.push_back(motion);
  }
}

void take(const SearchResult& found, const Frame& frame, const Array<Index>& node_of_point, Matching& m) {
  m.pose = pose_of(found.motion, frame, m.options.start);
  m.scale = found.motion.scale;
  m.iterations = found.iterations;
  m.converged = found.converged;
  m.reason = found.reason;
  m.history = found.history;
  m.overlap = found.overlap;
  m.weak_directions = found.weak_directions;
  m.centre = frame.to_input(found.centre);
  take_covariance(found, frame, m);
  m.stable.resize(node_of_point.size());
  for (std::size_t i = 0; i < node_of_point.size(); ++i)
    m.stable[i] = node_of_point[i] == no_index ? 0 : found.stable[node_of_point[i]];
}

void describe(const Comparison& c, Matching& m) {
  m.fixed = c.a, m.moving = c.b;
  m.fixed.role = "fixed", m.moving.role = "moving";
  m.unit = c.unit;
  m.warnings.insert(m.warnings.end(), c.warnings.begin(), c.warnings.end());
}

void warn(Matching& m) {
  for (const std::string& weak : m.weak_directions) m.warnings.push_back(weak);
  if (!m.converged) m.warnings.push_back("the search did not converge: " + m.reason);
}

}  // namespace isopach
