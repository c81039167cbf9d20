// ConvexHull: the convex hull of points that come in parts, each looked at once and not kept.
//
// Andrew's monotone chain [Andrew1979] over the corners so far and the points outside of them, by exact orientations.
#pragma once
#include <span>
#include <vector>

#include "isopach/geom/vec.hpp"

namespace isopach {

class ConvexHull {
 public:
  /// Cost O(m log h), and a sort of those of the m points that lie outside of the h corners so far.
  void add(std::span<const Point2> points);

  /// Counter-clockwise, the lexicographically least first, no three on a line. Less than three: all points lie on one
  /// line. A function of the set of points. Oracle: tests/geom/convex_hull_test.cpp (all sides against all points).
  [[nodiscard]] std::vector<Point2> corners() const;
  /// Whether the closed hull holds a point. Exact.
  [[nodiscard]] bool holds(const Point2& p) const;

 private:
  std::vector<Point2> lower_, upper_;  // from the least corner to the greatest, both in lexicographic order
};

}  // namespace isopach
