// Arithmetic on rigid motions and poses: backwards, angle and screw.
#pragma once
#include "isopach/geom/rigid.hpp"
#include "isopach/match/motion.hpp"

namespace isopach {

[[nodiscard]] Motion inverted(const Motion& motion);
/// Of a rigid pose (rotation and shift alone).
[[nodiscard]] Pose inverted(const Pose& pose);

/// The linear part alone.
[[nodiscard]] Point3 turned(const Pose& pose, const Point3& v);

/// Rotation vector of a rigid pose: unit axis times angle (rad) in [0, pi].
[[nodiscard]] Point3 rotation_vector(const Pose& pose);

/// A rigid motion as a turn about a line and a slide along it (Chasles).
struct Screw {
  Point3 direction{0, 0, 0};  ///< unit; zero where the angle is 0
  Point3 point{0, 0, 0};      ///< of the line, the nearest to the point that was asked about
  double angle = 0;           ///< rad, in [0, pi]
  double slide = 0;           ///< along direction
};
[[nodiscard]] Screw screw_of(const Pose& pose, const Point3& near);

}  // namespace isopach
