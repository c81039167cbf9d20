#include "isopach/apps/mirror.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/match/surface/surface.hpp"

namespace isopach {
namespace {

constexpr double steepest = 0.8;  // of the cosine between a normal and the direction of projection

Point3 scaled(const Point3& v, double s) { return {s * v.x, s * v.y, s * v.z}; }
Point3 sum(const Point3& a, const Point3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

Point3 unit_vector(const Point3& v) { return scaled(v, 1 / std::sqrt(dot(v, v))); }

/// Rows x, y, z from x and the z nearest to (0, 0, 1).
std::array<double, 9> axes_of(const Point3& x) {
  const Point3 z = unit_vector(sum({0, 0, 1}, scaled(x, -x.z)));
  const Point3 y = cross(z, x);
  return {x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z};
}

Box3 box_of(const PointsView& points, const Upright& place) {
  return reduce_blocks<Box3>(
      points.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Box3 box;
        for (std::size_t i = begin; i < end; ++i) box.add(place.apply(points[i]));
        return box;
      },
      [](Box3& left, const Box3& right) { left.add(right); });
}

}  // namespace

Reflection reflection_of(const Pose& pose) {
  Eigen::Matrix3d a;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a(i, j) = (j == 0 ? -1 : 1) * pose.m[static_cast<std::size_t>(4 * i + j)];
  const Eigen::Vector3d t(pose.m[3], pose.m[7], pose.m[11]);
  Eigen::Vector3d n = spectrum<3>((a + a.transpose()) / 2).vectors.col(0).normalized();
  if (n.x() < 0) n = -n;
  Reflection r;
  r.normal = {n.x(), n.y(), n.z()};
  r.offset = n.dot(t) / 2;
  const double sine = std::hypot(a(2, 1) - a(1, 2), a(0, 2) - a(2, 0), a(1, 0) - a(0, 1)) / 2;
  r.twist = std::atan2(sine, (a.trace() + 1) / 2) * degrees_per_radian;
  r.glide = (t - n * n.dot(t)).norm();
  return r;
}

void describe_sigma(const Matching& m, double& sigma_angle, double& sigma_offset) {
  const auto variance = [&](std::size_t k) { return 2 * m.covariance[7 * k]; };
  sigma_angle = std::sqrt(variance(1) + variance(2)) / 2 * degrees_per_radian;
  sigma_offset = std::sqrt(variance(3)) / 2;
}

Upright Upright::after(const Reflection& found, const Point3& towards) const {
  const Point3& n = found.normal;
  Point3 x = unit_vector(sum(sum(scaled(axis(0), n.x), scaled(axis(1), n.y)), scaled(axis(2), n.z)));
  const Point3 foot = sum(origin, scaled(x, found.offset));
  if (dot(x, towards) < 0) x = scaled(x, -1);
  if (std::fabs(x.z) > steepest)
    throw OverlapError(
        "the plane about which the scan is most nearly symmetric lies across the direction of projection: give "
        "@direction from the front of the face, and @across from side to side");
  return {foot, axes_of(x)};
}

Upright Upright::turned_and_shifted(double roll, double turn, double shift) const {
  const double a = roll / degrees_per_radian, b = turn / degrees_per_radian;
  const Point3 level = sum(scaled(axis(0), std::cos(a)), scaled(axis(1), std::sin(a)));
  const Point3 x = sum(scaled(level, std::cos(b)), scaled(axis(2), std::sin(b)));
  return {sum(origin, scaled(x, shift)), axes_of(x)};
}

Upright Upright::recentred(const Array<Point3>& points) const {
  const Box3 box = box_of(points, *this);
  Upright moved = *this;
  moved.origin =
      sum(origin, sum(scaled(axis(1), (box.min.y + box.max.y) / 2), scaled(axis(2), (box.min.z + box.max.z) / 2)));
  return moved;
}

Upright upright_through_middle(const Array<Point3>& points, const Point3& across) {
  const Point3 level{across.x, across.y, 0};
  const double length = std::sqrt(dot(level, level));
  if (!(length > 1e-6 * std::sqrt(dot(across, across))))
    throw UsageError("@across: is the direction of projection: give the one from side to side, e.g. x");
  Upright place{{0, 0, 0}, axes_of(scaled(level, 1 / length))};
  const Box3 box = box_of(points, place);
  place.origin =
      sum(sum(scaled(place.axis(0), (box.min.x + box.max.x) / 2), scaled(place.axis(1), (box.min.y + box.max.y) / 2)),
          scaled(place.axis(2), (box.min.z + box.max.z) / 2));
  return place;
}

Point3 in_view(const Point3& v, const Frame& frame) {
  const auto& r = frame.rotation;
  return {r[0] * v.x + r[1] * v.y + r[2] * v.z, r[3] * v.x + r[4] * v.y + r[5] * v.z,
          r[6] * v.x + r[7] * v.y + r[8] * v.z};
}

Point3 across_in_view(const std::optional<Point3>& across, const Frame& frame) {
  return across ? in_view(*across, frame) : Point3{1, 0, 0};
}

Cloud placed(const Array<Point3>& points, const Upright& place) {
  Cloud cloud;
  cloud.points.resize(points.size());
  for_each_index(points.size(), [&](std::size_t i) { cloud.points[i] = place.apply(points[i]); });
  return cloud;
}

Cloud mirrored(const CloudView& cloud) {
  Cloud mirror;
  mirror.unit = cloud.unit, mirror.vertical_unit = cloud.vertical_unit;
  mirror.points.resize(cloud.points.size());
  for_each_index(cloud.points.size(), [&](std::size_t i) {
    const Point3& p = cloud.points[i];
    mirror.points[i] = {p.x == 0 ? 0 : -p.x, p.y, p.z};
  });
  return mirror;
}

double size_of(const CloudView& cloud) {
  const Box3 box = box_of(cloud.points, {});
  return box.empty() ? 0 : std::hypot(box.max.x - box.min.x, box.max.y - box.min.y);
}

std::string unit_in_space(const CloudView& description, const CompareOptions& options,
                          std::vector<std::string>& warnings) {
  Comparison units;  // what compare says of units and CRS holds here too
  units.options.unit = options.unit;
  units.options.allow_crs = options.allow_crs;
  const CloudView& c = description;
  if (options.unit.empty() && c.unit != "unknown" && c.vertical_unit != "unknown" && c.unit != c.vertical_unit) {
    const std::string what = fmt::format("{}: x and y are in {} but heights in {}",
                                         c.path.empty() ? std::string("the scan") : c.path, c.unit, c.vertical_unit);
    if (!options.allow_crs)
      throw InputError(what +
                       ", so turning it would mean nothing: convert it, or say @unit or @allow-crs to take "
                       "the numbers as they are");
    units.options.unit = "unknown";
    warnings.push_back(what + ": turning mixes the two as if they were one");
  }
  stages::check_units(c, c, units.options, units);
  for (const std::string& w : units.warnings)
    if (std::find(warnings.begin(), warnings.end(), w) == warnings.end()) warnings.push_back(w);
  return units.unit;
}

HeightField field_of(const Array<Point3>& points, DuplicatePolicy duplicates, CurveBox& curve, const Context& context) {
  Cloud cloud;
  cloud.points = points;
  ProjectOptions options;
  options.duplicates = duplicates;
  const Frame own = choose_frame(cloud, cloud, Pose{}, options, context);
  HeightField field = project(cloud, Pose{}, own, options, context);
  curve = own.curve;
  for (Point2& p : field.xy) p = {p.x + own.origin.x, p.y + own.origin.y};
  for (double& z : field.z) z += own.origin.z;
  return field;
}

Array<Point3> means_of_neighbours(const HeightField& field, std::size_t run, const Context& context) {
  MatchSurface nodes;  // thinning asks for no triangles
  nodes.xy = field.xy, nodes.z = field.z;
  const MatchSurface few = thinned(nodes, run, false, context);
  Array<Point3> means(few.xy.size());
  for (std::size_t i = 0; i < means.size(); ++i) means[i] = {few.xy[i].x, few.xy[i].y, few.z[i]};
  return means;
}

}  // namespace isopach
