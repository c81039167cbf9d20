// Known motions of clouds, and how far a found pose is from undoing them.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "isopach/cloud/cloud.hpp"
#include "isopach/geom/rigid.hpp"

namespace isopach::test {

inline Point3 middle_of(const Cloud& cloud) {
  Point3 sum{0, 0, 0};
  for (const Point3& p : cloud.points) sum = {sum.x + p.x, sum.y + p.y, sum.z + p.z};
  const auto n = static_cast<double>(cloud.points.size());
  return {sum.x / n, sum.y / n, sum.z / n};
}

/// Rotation by `degrees` about `axis` through `centre`, then a shift.
inline Pose turn_and_shift(const Point3& axis, double degrees, const Point3& centre, const Point3& shift) {
  const double length = std::hypot(axis.x, axis.y, axis.z), angle = degrees * std::numbers::pi / 180;
  const double x = axis.x / length, y = axis.y / length, z = axis.z / length, c = std::cos(angle), s = std::sin(angle),
               k = 1 - c;
  Pose pose;
  pose.m = {c + x * x * k,
            x * y * k - z * s,
            x * z * k + y * s,
            0,
            y * x * k + z * s,
            c + y * y * k,
            y * z * k - x * s,
            0,
            z * x * k - y * s,
            z * y * k + x * s,
            c + z * z * k,
            0,
            0,
            0,
            0,
            1};
  const Point3 turned = pose.apply(centre);
  pose.m[3] = centre.x - turned.x + shift.x;
  pose.m[7] = centre.y - turned.y + shift.y;
  pose.m[11] = centre.z - turned.z + shift.z;
  return pose;
}

inline Cloud posed(Cloud cloud, const Pose& pose) {
  for (Point3& p : cloud.points) p = pose.apply(p);
  return cloud;
}

/// b after a.
inline Pose chained(const Pose& b, const Pose& a) {
  Pose c;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      c.m[4 * i + j] = 0;
      for (std::size_t k = 0; k < 4; ++k) c.m[4 * i + j] += b.m[4 * i + k] * a.m[4 * k + j];
    }
  return c;
}

struct PoseError {
  double degrees, shift;  ///< rotation, and how far the middle is from its place
};

/// Of `pose`, which should be the identity, about `middle`.
inline PoseError off_identity(const Pose& pose, const Point3& middle) {
  const auto& m = pose.m;
  const double sine = std::hypot(m[9] - m[6], m[2] - m[8], m[4] - m[1]) / 2, cosine = (m[0] + m[5] + m[10] - 1) / 2;
  const Point3 p = pose.apply(middle);
  return {std::atan2(sine, cosine) * 180 / std::numbers::pi,
          std::hypot(p.x - middle.x, p.y - middle.y, p.z - middle.z)};
}

}  // namespace isopach::test
