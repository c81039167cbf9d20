// Where a scanner measures: nodes in the plane, in the order of acquisition, inside a convex polygon given
// counter-clockwise. All are functions of (footprint, count, random numbers); the same bits for any number of threads.
// Cost: O(count). Tests: tests/simulate/sampling_test.cpp
#pragma once
#include <cstdint>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/geom/vec.hpp"
#include "isopach/overlay/hulls.hpp"

namespace isopach {

/// Convex, counter-clockwise, at least three corners.
using Outline = std::vector<Point2>;

[[nodiscard]] Outline rectangle(const Point2& min, const Point2& max);
[[nodiscard]] bool contains(const Outline& polygon, const Point2& p);  ///< border included, up to rounding

/// Who draws: nodes of different scans of one scene must not share random numbers.
struct Draw {
  std::uint64_t seed = 1, scan = 0;
};

/// Strips of scan lines, as an airborne scanner (or, with one strip, a raster) draws them.
struct ScanPattern {
  double heading = 0;  ///< of the flight, radians, counter-clockwise from x
  int strips = 1;
  double overlap = 0;   ///< of neighbouring strips, as a part of their width, in [0, 1): there the density doubles
  bool zigzag = false;  ///< an oscillating mirror; otherwise every line starts on the same side
  double stretch = 1;   ///< distance of lines over distance of points in a line
  double jitter = 0;    ///< largest deviation along and across the line, as a part of these distances
};

/// About `count` nodes. Lines run over the border of the footprint and are cut there: no node is put on it.
[[nodiscard]] Array<Point2> scan_nodes(const Outline& footprint, std::size_t count, const ScanPattern& pattern,
                                       const Draw& draw);

/// Exactly `count` nodes, independent and uniform: a Poisson-like, irregular scan.
[[nodiscard]] Array<Point2> irregular_nodes(const Outline& footprint, std::size_t count, const Draw& draw);

/// The corners, and nodes about `spacing` apart on the sides. Where the corners are whole numbers below 2^20 they lie
/// on the sides exactly.
[[nodiscard]] Array<Point2> border_nodes(const Outline& footprint, double spacing, const Draw& draw);

/// max(count, corners) nodes whose convex hull is the footprint: its corners, nodes on its sides as dense as inside,
/// and irregular ones. Where the corners are whole numbers below 2^20, those on the sides lie on them exactly.
[[nodiscard]] Array<Point2> bordered_nodes(const Outline& footprint, std::size_t count, const Draw& draw);

}  // namespace isopach
