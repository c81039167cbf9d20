// Hilbert curve: the order of all arrays. Points near each other on the curve are near each other in the plane, and the
// points of a run of keys with a common prefix fill one square of a quadtree, which the divide and conquer of
// delaunay/build uses as its cut.
//
// Source: D. Hilbert 1891; the key is read off a table of 4 states, 4 bits an axis at a time.
#pragma once
#include <cstdint>
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/base/types.hpp"
#include "isopach/geom/disc.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// The square in which keys are counted: cell = floor((p − min) · scale), 32 bits an axis, clamped to the square.
struct CurveBox {
  Point2 min{0, 0};
  double scale = 1;  ///< cells per unit of length
};

/// Smallest such square around a box (a power-of-two number of units wide, so that scaling is exact).
[[nodiscard]] CurveBox curve_box(const Box2& box);

/// 64-bit Hilbert key of a point: 32 levels of the curve, most significant first.
[[nodiscard]] std::uint64_t curve_key(const CurveBox& box, const Point2& p);

/// The square of the quadtree, `level` levels down, that p lies in: every double is in one of them, since cells are a
/// monotone function of each coordinate. A point with another square lies outside of the open box, whose low sides are
/// the least coordinates of the square and whose high sides the least of the next ones; at the ends of an axis it is
/// open to infinity. 0 <= level <= 32. Cost: 64 steps of bisection a side. Oracle: CurveSquare.*,
/// tests/geom/disc_test.cpp.
[[nodiscard]] OpenBox curve_square(const CurveBox& box, const Point2& p, int level);

/// Ids of the points in curve order: by key, equal keys lexicographically, equal points by id. A function of the point
/// set up to the ids of equal points. Cost: a radix sort from the highest bits that differ; O(n) for all but
/// adversarial input, O(n log n) at worst. `keys` and `sorted`, if given, receive the keys and the points in that
/// order. Oracle: tests/geom/curve_test.cpp (std::sort by the same relation).
[[nodiscard]] Array<Index> curve_order(std::span<const Point2> points, const CurveBox& box,
                                       Array<std::uint64_t>* keys = nullptr, Array<Point2>* sorted = nullptr);

}  // namespace isopach
