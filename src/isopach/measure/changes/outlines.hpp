// outlines: rings of the sides that bound a part of the plane.
#pragma once
#include <array>
#include <vector>

#include "isopach/geom/vec.hpp"

namespace isopach {

/// Closed rings without the first corner repeated: the outer one counter-clockwise, holes clockwise.
struct PolygonWithHoles {
  std::vector<std::vector<Point2>> rings;
};

/// Signed area of a ring: positive counter-clockwise.
[[nodiscard]] double ring_area(const std::vector<Point2>& ring);

/// A directed side, what it bounds on its left.
using OutlineSide = std::array<Point2, 2>;

/// Collects the sides of an outline.
class OutlineBuilder {
 public:
  /// A side of the outline for certain.
  void add(const OutlineSide& side) { firm_.push_back(side); }
  /// A side along which something else may lie, of which the sides are computed elsewhere, so that corners may differ
  /// by rounding and one long side may face several short ones. Where two of these lie on one another, they cancel.
  /// This is for the drawing alone: corners within 2^-36 of the size of the coordinates are taken for the same. `firm`:
  /// its corners are those of firm sides.
  void add_loose(const OutlineSide& side, bool firm) { (firm ? loose_firm_ : loose_).push_back(side); }

  /// The largest polygon first; a function of the set of sides. Where the outline touches itself rings part, so that
  /// none crosses or touches itself. Cost O(n log n). Oracle: tests/measure/changes_test.cpp (areas).
  [[nodiscard]] std::vector<PolygonWithHoles> polygons() const;

 private:
  std::vector<OutlineSide> firm_, loose_firm_, loose_;
};

}  // namespace isopach
