#include "isopach/apps/motions.hpp"

#include <Eigen/Geometry>

#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

Eigen::Matrix3d rotation_of(const Pose& pose) {
  Eigen::Matrix3d r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = pose.m[static_cast<std::size_t>(4 * i + j)];
  return r;
}

}  // namespace

Motion inverted(const Motion& motion) {
  Motion result;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) result.rotation[3 * i + j] = motion.rotation[3 * j + i];
  result.scale = 1 / motion.scale;
  result.shift = motion.undo({0, 0, 0});
  return result;
}

Pose inverted(const Pose& pose) {
  Pose result;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) result.m[4 * i + j] = pose.m[4 * j + i];
  const Point3 back = turned(result, {pose.m[3], pose.m[7], pose.m[11]});
  result.m[3] = -back.x, result.m[7] = -back.y, result.m[11] = -back.z;
  return result;
}

Point3 turned(const Pose& pose, const Point3& v) {
  const auto& m = pose.m;
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
          m[8] * v.x + m[9] * v.y + m[10] * v.z};
}

Point3 rotation_vector(const Pose& pose) {
  Eigen::Quaterniond q(rotation_of(pose));
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  const double scale = sine > 0 ? 2 * std::atan2(sine, q.w()) / sine : 2;
  return {scale * q.x(), scale * q.y(), scale * q.z()};
}

Screw screw_of(const Pose& pose, const Point3& near) {
  Screw screw;
  const Point3 w = rotation_vector(pose);
  screw.angle = length(w);
  screw.point = near;
  if (!(screw.angle > 0)) return screw;
  screw.direction = (1 / screw.angle) * w;
  const Point3 moved = pose.apply(near) - near;
  screw.slide = dot(moved, screw.direction);
  // Across the direction: moved = (R − 1)(near − point), whose inverse in that plane is −(1 + cot(angle/2) u×)/2.
  const Point3 across = moved - screw.slide * screw.direction;
  const double half = 0.5 / std::tan(screw.angle / 2);
  screw.point = near + 0.5 * across + half * cross(screw.direction, across);
  return screw;
}

}  // namespace isopach
