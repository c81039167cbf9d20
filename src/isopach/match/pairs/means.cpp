#include "isopach/match/pairs/means.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/pairs/icp_response.hpp"

namespace isopach {
namespace {

constexpr std::size_t most_means = 16384, sampled = 1024;
constexpr double worth_all_points = 3;  // times what the means tell
constexpr double go_together = 8;
constexpr std::size_t of_a_run = 128;  // means, as in the clusters of the covariance
constexpr double same_side = 0.7;      // cosine of the normals of a pair

void orient_both(OrientedCloud& moving, OrientedCloud& fixed, const MatchOptions& options, const Context& context) {
  both([&] { orient(fixed, context, {}); }, [&] { orient(moving, context, {.boundary = options.icp.symmetric}); });
}

IcpFound by_means(const OrientedCloud& moving, const OrientedCloud& fixed, const MatchOptions& options,
                  const Context& context) {
  IcpFound found;
  both([&] { found.fixed = means_of(fixed, most_means).cloud; },
       [&] {
         Means means = means_of(moving, most_means);
         found.moving = std::move(means.cloud), found.of_point = std::move(means.of_point);
       });
  orient_both(found.moving, found.fixed, options, context);
  found.state = icp_search(found.moving, found.fixed, Motion{}, options, FirstLevel::twice, context);
  return found;
}

IcpFound by_points(OrientedCloud moving, OrientedCloud fixed, const MatchOptions& options, const Context& context) {
  IcpFound found;
  orient_both(moving, fixed, options, context);
  found.state = icp_search(moving, fixed, Motion{}, options, FirstLevel::twice, context);
  found.of_point.resize(moving.points.size());
  std::iota(found.of_point.begin(), found.of_point.end(), Index{0});
  found.moving = std::move(moving), found.fixed = std::move(fixed);
  return found;
}

/// A point of MOVING where it is now, and its nearest in FIXED.
struct Neighbours {
  Point3 place, normal;
  Index partner;
};

/// The lower third of the distances from the partners' planes, of pairs whose normals agree. 0: none do.
double lower_third(const Array<Neighbours>& pairs, const Array<Point3>& places, const Array<Point3>& normals) {
  Array<double> distances;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (std::fabs(dot(pairs[k].normal, normals[k])) >= same_side)
      distances.push_back(std::fabs(dot(pairs[k].place - places[k], normals[k])));
  if (distances.empty()) return 0;
  const auto third = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 3);
  std::nth_element(distances.begin(), third, distances.end());
  return *third;
}

/// Variance of what runs of neighbouring pairs pull, over that of pairs one by one, in the metric of the equations: 1
/// where the residuals of neighbours have nothing in common, at least.
double pull_of_runs(const IcpState& found, PairKind kind) {
  using Vector = Eigen::Matrix<double, 7, 1>;
  Matrix7 normal = pair_normal_matrix(found);
  normal.diagonal().array() += normal.trace() * 1e-9;  // what nothing holds, nothing pulls at
  const Ldlt<Eigen::Dynamic> metric(normal);
  const auto size = [&](const Vector& v) { return v.dot(Vector(metric.solve(v))); };
  double one_by_one = 0, together = 0;
  Vector run = Vector::Zero();
  for (std::size_t i = 0; i < found.links.size(); ++i) {
    const Link& l = found.links[i];
    const Vector7 row = pair_row(found.information, l.moving, pull(l, kind));
    const Vector v = l.weight * Eigen::Map<const Vector>(row.data());
    one_by_one += size(v), run += v;
    if (i + 1 < found.links.size() && found.links[i + 1].query / of_a_run == l.query / of_a_run) continue;
    together += size(run), run.setZero();
  }
  return one_by_one > 0 ? std::max(1.0, together / one_by_one) : 1;
}

}  // namespace

bool means_suffice(const OrientedCloud& moving, OrientedCloud& fixed, const IcpFound& found, PairKind kind) {
  const Motion& motion = found.state.motion;
  const std::size_t stride = std::max<std::size_t>(1, moving.points.size() / sampled);
  const std::size_t count = (moving.points.size() + stride - 1) / stride;
  if (!fixed.boxes) fixed.boxes = std::make_unique<BoxTree>(fixed.points);
  Array<Neighbours> points(count), means(count);
  for_each_index(count, [&](std::size_t k) {
    const Index mean = found.of_point[k * stride];
    const Point3 normal = motion.turn(found.moving.normals[mean]);
    points[k] = {motion.apply(moving.points[k * stride]), normal, no_index};
    means[k] = {motion.apply(found.moving.points[mean]), normal, no_index};
    points[k].partner = fixed.boxes->nearest_two(points[k].place).first;
    means[k].partner = found.fixed.boxes->nearest_two(means[k].place).first;
  });
  Array<Index> partners(count);
  Array<Point3> places(count), place_of_mean(count), normal_of_mean(count);
  for (std::size_t k = 0; k < count; ++k) {
    partners[k] = points[k].partner, places[k] = fixed.points[partners[k]];
    place_of_mean[k] = found.fixed.points[means[k].partner], normal_of_mean[k] = found.fixed.normals[means[k].partner];
  }
  const double of_means = lower_third(means, place_of_mean, normal_of_mean),
               of_points = lower_third(points, places, normals_at(fixed, partners));
  const double more = static_cast<double>(moving.points.size()) / static_cast<double>(found.moving.points.size());
  const bool tell_as_much = more * of_means * of_means <= worth_all_points * of_points * of_points;
  return tell_as_much || pull_of_runs(found.state, kind) >= go_together;
}

IcpFound find_by_pairs(OrientedCloud moving, OrientedCloud fixed, const MatchOptions& options, const Context& context) {
  if (options.objective == Objective::icp_point || std::max(moving.points.size(), fixed.points.size()) <= most_means)
    return by_points(std::move(moving), std::move(fixed), options, context);
  IcpFound found = by_means(moving, fixed, options, context);
  if (means_suffice(moving, fixed, found, pair_kind(options.objective))) return found;
  const IcpState first = std::move(found.state);
  orient_both(moving, fixed, options, context);
  MatchOptions rest = options;
  rest.max_iterations = std::max(1, options.max_iterations - first.iterations);
  found.state = icp_search(moving, fixed, first.motion, rest, FirstLevel::none, context);
  found.state.iterations += first.iterations;
  found.state.history.insert(found.state.history.begin(), first.history.begin(), first.history.end());
  std::iota(found.of_point.begin(), found.of_point.end(), Index{0});
  found.moving = std::move(moving), found.fixed = std::move(fixed);
  return found;
}

}  // namespace isopach
