#include "isopach/match/icp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/match/checks.hpp"
#include "isopach/match/icp_search.hpp"

namespace isopach {
namespace {

constexpr double freedoms = 6;

void check(const MatchOptions& o) {
  check_options(o);
  if (o.objective != Objective::icp_point && o.objective != Objective::icp_plane)
    throw UsageError("icp: the objective is icp-point or icp-plane");
}

Box3 box_of(const Array<Point3>& points) {
  Box3 box;
  for (const Point3& p : points) box.add(p);
  return box;
}

/// Boxes that do not touch share no area; grown by a little, since noise may keep flat scans apart.
void check_boxes(const OrientedCloud& moving, const OrientedCloud& fixed) {
  const Box3 a = box_of(moving.points), b = box_of(fixed.points);
  const double slack = 0.01 * std::max({a.max.x - a.min.x, a.max.y - a.min.y, a.max.z - a.min.z});
  const bool apart =
      a.min.x > b.max.x + slack || b.min.x > a.max.x + slack || a.min.y > b.max.y + slack || b.min.y > a.max.y + slack;
  if (apart) throw OverlapError("the scans do not overlap at the start: give --start, or let --coarse look for one");
}

/// rᵀ · block · r for the four 3×3 blocks.
std::array<double, 36> to_input_axes(const std::array<double, 36>& c, const std::array<double, 9>& r) {
  std::array<double, 36> result{};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t l = 0; l < 3; ++l)
          result[6 * i + j] += r[3 * k + i % 3] * r[3 * l + j % 3] * c[6 * (i / 3 * 3 + k) + j / 3 * 3 + l];
  return result;
}

Matching run(const Cloud& moving, const Cloud& fixed, const Pose& start, const MatchOptions& options,
             const Context& context) {
  check(options);
  const ProjectOptions& project = options.compare.project;
  const Frame frame = choose_frame(fixed, moving, start, project, context);
  OrientedCloud a, b;
  both([&] { a = order_points(fixed, Pose{}, frame, project, 0, context); },
       [&] { b = order_points(moving, start, frame, project, 0, context); });
  check_boxes(b, a);
  both([&] { orient(a, context); }, [&] { orient(b, context); });
  const IcpState found = icp_search(b, a, Motion{}, options, FirstLevel::twice, context);

  Matching m;
  m.options = options;
  m.pose = pose_of(found.motion, frame, start);
  m.scale = found.motion.scale;
  m.iterations = found.iterations;
  m.converged = found.converged;
  m.reason = found.reason;
  m.history = found.history;
  m.overlap = found.share;
  const PairInformation& in = found.information;
  const double count = in.weight / (options.icp.symmetric ? 2 : 1);  // both ways see the same noise
  const double sigma2 = in.error * count / std::max(1.0, count - freedoms);
  m.covariance =
      to_input_axes(pair_covariance(in, sigma2, count, information_floor(b, a), axis_names(frame), m.weak_directions),
                    frame.rotation);
  m.centre = frame.to_input(in.centre);
  m.stable.assign(moving.points.size(), 0);
  for (const Link& link : found.links) m.stable[b.ids[link.query]] = 1;
  return m;
}

}  // namespace

Matching icp(const Cloud& moving, const Cloud& fixed, const Pose& start, const MatchOptions& options,
             const Context& context) {
  Matching result;
  run_with_threads(context.threads, [&] { result = run(moving, fixed, start, options, context); });
  return result;
}

}  // namespace isopach
