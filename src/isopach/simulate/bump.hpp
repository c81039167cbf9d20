// A smooth hill (or hollow) on an elliptical support whose volume is known in closed form: the change that a scene
// hides between its two epochs.
//
// With u along `axis`, v across it and q = 1 − (u/a)² − ((v − bend·u²)/b)²:
//   height(x, y) = h q³ (1 + skew·u/a)  where q > 0, exactly 0 elsewhere   (twice continuously differentiable)
//   volume = π a b h / 4
// Neither `bend` nor `skew` changes the volume: v − bend·u² is a shear, and the skewed term is odd in u. |skew| <= 1
// keeps one sign. Test: tests/simulate/scene_test.cpp
#pragma once
#include <numbers>

#include "isopach/geom/vec.hpp"

namespace isopach {

struct Bump {
  Point2 centre{0, 0};
  double h = 0;         ///< height; negative: a hollow
  double a = 1, b = 1;  ///< half-axes of the support
  Point2 axis{1, 0};    ///< unit vector
  double bend = 0;      ///< per unit of length
  double skew = 0;

  [[nodiscard]] double volume() const { return std::numbers::pi * a * b * h / 4; }

  [[nodiscard]] double at(double x, double y) const {
    const double dx = x - centre.x, dy = y - centre.y;
    const double u = axis.x * dx + axis.y * dy;
    const double v = axis.x * dy - axis.y * dx - bend * u * u;
    const double q = 1 - (u / a) * (u / a) - (v / b) * (v / b);
    return q > 0 ? h * q * q * q * (1 + skew * u / a) : 0;
  }
};

}  // namespace isopach
