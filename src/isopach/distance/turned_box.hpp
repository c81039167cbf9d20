// TurnedBox: bounds of the distance to triangles that are long, thin and oblique to the axes.
#pragma once
#include <array>
#include <limits>
#include <span>

#include "isopach/geom/vec.hpp"

namespace isopach {

/// A box along axes of its own. Of a fan, triangles that share a corner, also the pyramid with its tip at that corner,
/// as the corner may be the closest point of all of them and every box reaches beyond it.
class TurnedBox {
 public:
  using Triangles = std::span<const std::array<Point3, 3>>;

  /// Along the longest way between two corners, nearly, or from the tip; then along what lies farthest beside that.
  /// Degenerate: corners on one line or in one place give a flat box along any axes. Cost O(triangles).
  explicit TurnedBox(Triangles triangles);
  TurnedBox() = default;

  struct Bound {
    double distance2 = 0;
    bool at_tip = false;  ///< the tip is the closest point of every triangle
  };
  /// At most the squared distance to any of the triangles.
  [[nodiscard]] Bound bound(const Point3& p) const;

  /// Where the line p + t·direction meets it, in the coordinates of `box`, which is the wider by rounding.
  struct Line {
    Point3 p, direction;
    Box3 box;
  };
  [[nodiscard]] Line turned(const Point3& p, const Point3& direction) const;

  /// Sum of the three faces' areas.
  [[nodiscard]] double area() const;
  [[nodiscard]] bool is_fan() const { return fan_; }
  [[nodiscard]] const Point3& tip() const { return origin_; }

 private:
  [[nodiscard]] Point3 inside(const Point3& vector) const;  ///< by the axes
  void turn(Triangles triangles, const Point3& way);
  void find_pyramid(Triangles triangles);
  [[nodiscard]] Bound to_pyramid(const Point3& q, double rounding, double pad) const;

  Point3 origin_{0, 0, 0};  ///< a corner, so that rounding is relative to the size of the box
  std::array<Point3, 3> axes_{};
  Box3 box_;
  bool fan_ = false;
  std::array<double, 2> low_{}, high_{};  ///< slopes of the pyramid's sides: the second and third axis by the first
  double reach2_ = 0;                     ///< squared distance from the tip to the nearest opposite side
};

/// Of a box along x, y and z: the sum of its three faces' areas.
[[nodiscard]] double area_of(const Box3& box);

}  // namespace isopach
