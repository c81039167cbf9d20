#include "isopach/match/motion.hpp"

#include <cmath>

namespace isopach {

namespace {

/// Rotation by the vector w (Rodrigues).
std::array<double, 9> rotation_by(double x, double y, double z) {
  const double angle2 = x * x + y * y + z * z, angle = std::sqrt(angle2);
  const double a = angle < 1e-4 ? 1 - angle2 / 6 : std::sin(angle) / angle;
  const double half = std::sin(angle / 2);
  const double b = angle < 1e-4 ? 0.5 - angle2 / 24 : 2 * half * half / angle2;
  return {1 - b * (y * y + z * z), b * x * y - a * z,       b * x * z + a * y,
          b * x * y + a * z,       1 - b * (x * x + z * z), b * y * z - a * x,
          b * x * z - a * y,       b * y * z + a * x,       1 - b * (x * x + y * y)};
}

}  // namespace

Motion composed(const Motion& second, const Motion& first) {
  Motion result;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      result.rotation[3 * i + j] = second.rotation[3 * i] * first.rotation[j] +
                                   second.rotation[3 * i + 1] * first.rotation[3 + j] +
                                   second.rotation[3 * i + 2] * first.rotation[6 + j];
  result.scale = second.scale * first.scale;
  result.shift = second.apply(first.shift);
  return result;
}

Pose composed(const Pose& second, const Pose& first) {
  Pose result;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      double sum = j == 3 ? second.m[4 * i + 3] : 0;
      for (std::size_t k = 0; k < 3; ++k) sum += second.m[4 * i + k] * first.m[4 * k + j];
      result.m[4 * i + j] = sum;
    }
  return result;
}

Motion moved(const Motion& motion, const Twist& twist, const Point3& centre) {
  Motion step;
  step.rotation = rotation_by(twist[0], twist[1], twist[2]);
  step.scale = std::exp(twist[6]);
  const Point3 c = step.apply(centre);
  step.shift = {centre.x - c.x + twist[3], centre.y - c.y + twist[4], centre.z - c.z + twist[5]};
  return composed(step, motion);
}

Pose pose_of(const Motion& motion, const Frame& frame, const Pose& start) {
  using Real = long double;
  const auto& f = frame.rotation;
  const std::array<Real, 3> origin{frame.origin.x, frame.origin.y, frame.origin.z};
  const std::array<Real, 3> shift{motion.shift.x, motion.shift.y, motion.shift.z};
  // linear = fᵀ · (scale · rotation) · f
  std::array<Real, 9> turned{}, linear{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k)
        turned[3 * i + j] += Real{motion.scale} * Real{motion.rotation[3 * i + k]} * Real{f[3 * k + j]};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) linear[3 * i + j] += Real{f[3 * k + i]} * turned[3 * k + j];
  Pose pose;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      Real sum = 0;
      for (std::size_t k = 0; k < 3; ++k) sum += linear[3 * i + k] * Real{start.m[4 * k + j]};
      pose.m[4 * i + j] = static_cast<double>(sum);
    }
    Real sum = origin[i];
    for (std::size_t k = 0; k < 3; ++k)
      sum += linear[3 * i + k] * (Real{start.m[4 * k + 3]} - origin[k]) + Real{f[3 * k + i]} * shift[k];
    pose.m[4 * i + 3] = static_cast<double>(sum);
  }
  return pose;
}

}  // namespace isopach
