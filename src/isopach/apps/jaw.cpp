#include "isopach/apps/jaw.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/apps/motions.hpp"
#include "isopach/base/linear.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

Eigen::Vector3d vec(const Point3& p) { return {p.x, p.y, p.z}; }
Point3 point(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

}  // namespace

std::optional<HingeAxis> hinge_axis(std::span<const Pose> motions, const Point3& near, double least_angle) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double widest = 0;
  Point3 opening{0, 0, 0};
  for (const Pose& m : motions) {
    Eigen::Matrix3d r;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) r(i, j) = m.m[static_cast<std::size_t>(4 * i + j)] - (i == j ? 1 : 0);
    normal += r.transpose() * r;
    right -= r.transpose() * vec(m.apply(near) - near);
    const Point3 turn = rotation_vector(m);
    if (length(turn) > widest) widest = length(turn), opening = turn;
  }
  if (!(widest >= least_angle) || !(widest > 0)) return std::nullopt;
  const Spectrum<3> axes = spectrum(normal);
  HingeAxis axis;
  axis.direction = point(axes.vectors.col(0));
  if (dot(axis.direction, opening) < 0) axis.direction = -1.0 * axis.direction;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  for (int k = 1; k < 3; ++k) {
    const Eigen::Vector3d v = axes.vectors.col(k);
    shift += (v.dot(right) / axes.values[k]) * v;
  }
  axis.point = near + point(shift);
  double sum = 0;
  for (const Pose& m : motions) sum += squared_length(m.apply(axis.point) - axis.point);
  axis.rest = std::sqrt(sum / static_cast<double>(motions.size()));
  return axis;
}

double turn_about(const Pose& motion, const Point3& axis) {
  const Point3 w = rotation_vector(motion);
  const double angle = length(w);
  if (!(angle > 0)) return 0;
  return 2 * std::atan2(std::sin(angle / 2) * dot(w, axis) / angle, std::cos(angle / 2));
}

Pose hinge_frame(const HingeAxis& axis, const Point3& front) {
  const Point3 x = axis.direction, away = front - axis.point;
  Point3 z = away - dot(away, x) * x;
  if (!(length(z) > 1e-9 * length(away))) {
    const Point3 other = std::fabs(x.x) < 0.9 ? Point3{1, 0, 0} : Point3{0, 1, 0};
    z = other - dot(other, x) * x;
  }
  z = (1 / length(z)) * z;
  const Point3 y = cross(z, x);
  Pose pose;
  pose.m = {x.x, y.x, z.x, axis.point.x, x.y, y.y, z.y, axis.point.y, x.z, y.z, z.z, axis.point.z, 0, 0, 0, 1};
  return pose;
}

std::vector<Point3> smooth_path(std::span<const double> times, std::span<const Point3> values, double width) {
  std::vector<Point3> result(values.begin(), values.end());
  if (!(width > 0)) return result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::vector<std::pair<double, std::size_t>> near;  // weight, place
    for (std::size_t j = 0; j < values.size(); ++j) {
      const double t = std::fabs(times[j] - times[i]) / (width + 1);
      if (t < 1) near.emplace_back(std::pow(1 - t * t * t, 3), j);
    }
    const int terms = near.size() >= 4 ? 3 : near.size() == 3 ? 2 : 1;
    Eigen::MatrixXd a(static_cast<Eigen::Index>(near.size()), terms), b(static_cast<Eigen::Index>(near.size()), 3);
    for (std::size_t k = 0; k < near.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      const auto& [weight, j] = near[k];
      const double root = std::sqrt(weight), t = (times[j] - times[i]) / (width + 1);
      for (int e = 0; e < terms; ++e) a(row, e) = root * std::pow(t, e);
      b.row(row) = root * vec(values[j]).transpose();
    }
    const Eigen::MatrixXd solution = least_squares(a, b);
    result[i] = point(solution.row(0).transpose());
  }
  return result;
}

}  // namespace isopach
