#include "isopach/match/pairs/icp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/match/checks.hpp"
#include "isopach/match/pairs/icp_covariance.hpp"
#include "isopach/match/pairs/means.hpp"

namespace isopach {
namespace {

void check(const MatchOptions& o) {
  check_options(o);
  if (!of_pairs(o.objective)) throw UsageError("icp: the objective is icp-plane, icp-gicp or icp-point");
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
  if (apart) throw OverlapError("the scans do not overlap at the start: give @start, or let @coarse look for one");
}

Matching run(const CloudView& moving, const CloudView& fixed, const Pose& start, const MatchOptions& options,
             const Context& context) {
  check(options);
  const ProjectOptions& project = options.compare.project;
  const Frame frame = choose_frame(fixed, moving, start, project, context);
  OrientedCloud a, b;
  both([&] { a = order_points(fixed, Pose{}, frame, project, 0, context); },
       [&] { b = order_points(moving, start, frame, project, 0, context); });
  check_boxes(b, a);
  const Array<Index> ids = b.ids;
  const IcpFound by_pairs = find_by_pairs(std::move(b), std::move(a), options, context);
  const IcpState& found = by_pairs.state;

  Matching m;
  m.options = options;
  m.pose = pose_of(found.motion, frame, start);
  m.scale = found.motion.scale;
  m.iterations = found.iterations;
  m.converged = found.converged;
  m.reason = found.reason;
  m.history = found.history;
  m.overlap = found.share;
  SearchResult judged;
  find_icp_covariance(found, by_pairs.moving, by_pairs.fixed, options, axis_names(frame), judged);
  take_covariance(judged, frame, m);
  m.weak_directions = judged.weak_directions;
  m.centre = frame.to_input(found.information.centre);
  Array<unsigned char> linked(by_pairs.moving.points.size(), 0);
  for (const Link& link : found.links) linked[link.query] = 1;
  m.stable.assign(moving.points.size(), 0);
  for (std::size_t i = 0; i < ids.size(); ++i) m.stable[ids[i]] = linked[by_pairs.of_point[i]];
  return m;
}

}  // namespace

Matching icp(const CloudView& moving, const CloudView& fixed, const Pose& start, const MatchOptions& options,
             const Context& context) {
  Matching result;
  run_with_threads(context, [&] { result = run(moving, fixed, start, options, context); });
  return result;
}

}  // namespace isopach
