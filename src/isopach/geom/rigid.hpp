// Pose: a 4×4 row-major matrix T_target_source that takes source coordinates to target coordinates (rotation, shift
// and, where asked for, a uniform scale), always in input coordinates.
#pragma once
#include <array>

#include "isopach/geom/vec.hpp"

namespace isopach {

struct Pose {
  std::array<double, 16> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};  ///< row-major

  [[nodiscard]] bool is_identity() const { return m == Pose{}.m; }
  [[nodiscard]] Point3 apply(const Point3& p) const {
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
  }
};

}  // namespace isopach
