// Whether the circumscribed disc of a triangle lies in a box: what certifies a triangle of a part of the points as one
// of the whole (docs/method/tiles.md). A floating-point filter decides almost always, integers the rest
// (geom/predicates.hpp): no tolerance.
#pragma once
#include <limits>

#include "isopach/geom/vec.hpp"

namespace isopach {

/// An open box of the plane; sides that are infinite bound nothing. Default: the plane.
struct OpenBox {
  Point2 low{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  Point2 high{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};

  [[nodiscard]] bool holds(const Point2& p) const { return p.x > low.x && p.x < high.x && p.y > low.y && p.y < high.y; }
};

/// Whether the closed disc through a, b, c, which are not on one line, lies in the open box. Exact, whatever the
/// orientation. Oracle: tests/geom/disc_test.cpp (rational numbers).
[[nodiscard]] bool disc_inside(const Point2& a, const Point2& b, const Point2& c, const OpenBox& box);

namespace exact {
/// The exact stage alone.
[[nodiscard]] bool disc_inside(const Point2& a, const Point2& b, const Point2& c, const OpenBox& box);
}  // namespace exact

}  // namespace isopach
