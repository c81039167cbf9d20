// Arithmetic on Point3 as a vector in space.
#pragma once
#include <cmath>

#include "isopach/geom/vec.hpp"

namespace isopach {

[[nodiscard]] inline Point3 operator-(const Point3& p, const Point3& q) { return {p.x - q.x, p.y - q.y, p.z - q.z}; }
[[nodiscard]] inline Point3 operator+(const Point3& p, const Point3& q) { return {p.x + q.x, p.y + q.y, p.z + q.z}; }
[[nodiscard]] inline Point3 operator*(double s, const Point3& p) { return {s * p.x, s * p.y, s * p.z}; }
[[nodiscard]] inline double dot(const Point3& p, const Point3& q) { return p.x * q.x + p.y * q.y + p.z * q.z; }
[[nodiscard]] inline Point3 cross(const Point3& p, const Point3& q) {
  return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}
[[nodiscard]] inline double squared_length(const Point3& p) { return dot(p, p); }
[[nodiscard]] inline double length(const Point3& p) { return std::sqrt(dot(p, p)); }

}  // namespace isopach
