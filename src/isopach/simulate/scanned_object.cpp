#include "isopach/simulate/scanned_object.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/base/types.hpp"
#include "isopach/simulate/sampling.hpp"

namespace isopach {
namespace {

constexpr std::uint64_t first_stream = 12000;
constexpr int waves = 8;
constexpr std::size_t least_points = 100;
const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));

double mean_height(const Point2& p, double radius) {
  constexpr int places = 96;  // Vogel's sunflower: equal areas
  double sum = 0;
  for (int i = 0; i < places; ++i) {
    const double r = radius * std::sqrt((i + 0.5) / places), angle = i * golden_angle;
    sum += object_height(p.x + r * std::cos(angle), p.y + r * std::sin(angle));
  }
  return sum / places;
}

Eigen::Affine3d to_scan(const ObjectScanner& s) {
  Eigen::Affine3d t = Eigen::Affine3d::Identity();
  if (s.moved)
    t = Eigen::Translation3d(30, 20, 10) * Eigen::AngleAxisd(0.04, Eigen::Vector3d(0.2, 0.1, 1).normalized());
  t.linear() *= s.scale;
  return t;
}

void check(const ObjectScanner& s) {
  if (s.points < least_points)
    throw UsageError(
        fmt::format("{} points are too few for a scan of the object: ask for at least {}", s.points, least_points));
  if (s.points > max_nodes) throw UsageError(fmt::format("{} points are too many: at most {}", s.points, max_nodes));
  const auto refuse = [](bool wrong, const char* what, double value, const char* remedy) {
    if (wrong) throw UsageError(fmt::format("{} {} of a scan makes no sense: {}", what, value, remedy));
  };
  refuse(!(s.noise >= 0) || !std::isfinite(s.noise), "noise", s.noise, "give a standard deviation of 0 or more");
  refuse(!std::isfinite(s.bias), "bias", s.bias, "give an offset");
  refuse(!(s.spot >= 0) || !std::isfinite(s.spot), "spot", s.spot, "give a diameter of 0 or more");
  refuse(!(s.reach > 0) || s.reach > 1, "reach", s.reach, "give a share above 0, at most 1");
  refuse(!(s.scale > 0) || !std::isfinite(s.scale), "scale", s.scale, "give a factor above 0");
}

}  // namespace

double object_height(double x, double y) {
  double z = 5 * std::sin(x / 20) * std::cos(y / 25) + 0.002 * x * y;
  for (int i = 0; i < waves; ++i) {
    const double direction = i * golden_angle, k = 2 * std::numbers::pi / (6 + i / 4.0);
    z += 0.05 * std::sin(k * (std::cos(direction) * x + std::sin(direction) * y) + i * i);
  }
  return z;
}

Pose object_pose(const ObjectScanner& scanner) {
  const Eigen::Matrix4d back = to_scan(scanner).inverse().matrix();
  Pose pose;
  for (Eigen::Index i = 0; i < 4; ++i)
    for (Eigen::Index j = 0; j < 4; ++j) pose.m[static_cast<std::size_t>(4 * i + j)] = back(i, j);
  return pose;
}

Cloud scan_object(const ObjectScanner& s, std::uint64_t seed, std::uint64_t scan) {
  check(s);
  const Array<Point2> nodes =
      bordered_nodes(rectangle({0, 0}, {s.reach * object_width, object_depth}), s.points, {seed, first_stream + scan});
  const RandomStream random(seed, first_stream + 100 + scan);
  const Eigen::Affine3d moved = to_scan(s);
  Cloud cloud;
  cloud.format = "simulated";
  cloud.unit = cloud.vertical_unit = "mm";
  cloud.points.resize(nodes.size());
  for_each_index(nodes.size(), [&](std::size_t i) {
    const Point2& p = nodes[i];
    const double height = s.spot > 0 ? mean_height(p, s.spot / 2) : object_height(p.x, p.y);
    const Eigen::Vector3d q = moved * Eigen::Vector3d(p.x, p.y, height + s.bias + s.noise * random.normal(i));
    cloud.points[i] = {q.x(), q.y(), q.z()};
  });
  return cloud;
}

}  // namespace isopach
