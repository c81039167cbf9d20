// Motion: a rigid motion with a uniform scale in frame coordinates, as the search moves it; Pose is its form in input
// coordinates.
#pragma once
#include <array>

#include "isopach/field/height_field.hpp"
#include "isopach/geom/rigid.hpp"

namespace isopach {

/// A small motion about a centre: rotation vector, shift, and the logarithm of the scale.
using Twist = std::array<double, 7>;  ///< turn x, y, z (rad); shift x, y, z; scale

/// p ↦ scale · rotation · p + shift, in frame coordinates.
struct Motion {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major
  double scale = 1;
  Point3 shift{0, 0, 0};

  [[nodiscard]] Point3 turn(const Point3& v) const {
    const auto& r = rotation;
    return {r[0] * v.x + r[1] * v.y + r[2] * v.z, r[3] * v.x + r[4] * v.y + r[5] * v.z,
            r[6] * v.x + r[7] * v.y + r[8] * v.z};
  }
  [[nodiscard]] Point3 turn_back(const Point3& v) const {
    const auto& r = rotation;
    return {r[0] * v.x + r[3] * v.y + r[6] * v.z, r[1] * v.x + r[4] * v.y + r[7] * v.z,
            r[2] * v.x + r[5] * v.y + r[8] * v.z};
  }
  [[nodiscard]] Point3 apply(const Point3& p) const {
    const Point3 q = turn(p);
    return {scale * q.x + shift.x, scale * q.y + shift.y, scale * q.z + shift.z};
  }
  [[nodiscard]] Point3 undo(const Point3& p) const {
    const Point3 q = turn_back({p.x - shift.x, p.y - shift.y, p.z - shift.z});
    return {q.x / scale, q.y / scale, q.z / scale};
  }
};

/// `first`, then `second`.
[[nodiscard]] Motion composed(const Motion& second, const Motion& first);
[[nodiscard]] Pose composed(const Pose& second, const Pose& first);

/// `motion`, then the twist about `centre`.
[[nodiscard]] Motion moved(const Motion& motion, const Twist& twist, const Point3& centre);

/// The pose that takes input to input: `start`, then `motion` as seen in `frame`. Sums of large coordinates are made in
/// long double, so that the pose itself costs no more than the rounding of its sixteen numbers.
[[nodiscard]] Pose pose_of(const Motion& motion, const Frame& frame, const Pose& start);

}  // namespace isopach
