// Points and boxes in the plane and in space. Plain doubles, no unit: the unit travels with the Cloud.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace isopach {

struct Point2 {
  double x, y;
  friend bool operator==(const Point2&, const Point2&) = default;
};

/// Lexicographic order: the order behind every tie rule.
[[nodiscard]] inline bool lexicographic_less(const Point2& a, const Point2& b) {
  return a.x < b.x || (a.x == b.x && a.y < b.y);
}

/// Signed: positive where a, b, c turn left. Rounded, and by which corner comes first (delaunay/first_corner.hpp).
[[nodiscard]] inline double triangle_area(const Point2& a, const Point2& b, const Point2& c) {
  return 0.5 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
}

struct Point3 {
  double x, y, z;
  friend bool operator==(const Point3&, const Point3&) = default;
};

struct Box2 {
  Point2 min{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Point2 max{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  [[nodiscard]] bool empty() const { return !(min.x <= max.x); }
  void add(const Point2& p) {
    min = {std::min(min.x, p.x), std::min(min.y, p.y)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y)};
  }
  void add(const Box2& b) {
    if (!b.empty()) add(b.min), add(b.max);
  }
  [[nodiscard]] double area() const { return empty() ? 0 : (max.x - min.x) * (max.y - min.y); }
};
[[nodiscard]] inline Box2 box_of(std::span<const Point2> points) {
  Box2 box;
  for (const Point2& p : points) box.add(p);
  return box;
}

struct Box3 {
  Point3 min{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
             std::numeric_limits<double>::infinity()};
  Point3 max{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
             -std::numeric_limits<double>::infinity()};
  [[nodiscard]] bool empty() const { return !(min.x <= max.x); }
  void add(const Point3& p) {
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
  void add(const Box3& b) {
    if (!b.empty()) add(b.min), add(b.max);
  }
};

[[nodiscard]] inline bool is_finite(const Point3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

}  // namespace isopach
