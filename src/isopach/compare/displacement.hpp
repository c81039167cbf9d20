// displacement: whether B lies off A as a whole, as it does where two scans were never put into one frame.
//
// Such a d is, nearly everywhere, that of a small motion of B: an offset along the direction, a tilt, and what a shift
// across the direction makes of the slopes of the surface. It is fitted to d at the nodes by least absolute deviations
// (reweighted least squares, weights by area), which a change of less than half of the area hardly moves; whether it
// is there is asked of the medians of |d| with and without it, which such a change hardly moves either.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/compare/comparison.hpp"

namespace isopach {

/// In the frame of the comparison, at the middle of the area compared; d ≈ offset + what the tilt and the shift add.
struct Displacement {
  enum class Kind {
    offset,
    tilt,
    shift
  } kind = Kind::offset;  ///< the simplest that explains d; each holds those before
  double offset = 0;      ///< of B along the direction, unit of heights
  double tilt = 0;        ///< radians
  double shift = 0;       ///< of B across the direction, unit of x and y
  double before = 0;      ///< median of |d| by area as measured, unit of heights
  double after = 0;       ///< the same without the displacement
};

/// The simplest displacement that takes the median of |d| down to a fifth or less, or nothing: where the scans agree,
/// where they differ by noise alone, where a part of the surface changed, and where less than 30 nodes are compared. A
/// surface that has risen or sunk by the same everywhere cannot be told from a displaced scan, and is found, too. At
/// most 5000 nodes are looked at. Cost O(cells). Test: tests/compare/displacement_test.cpp.
[[nodiscard]] std::optional<Displacement> plain_displacement(const Comparison& c, const Context& context = {});

/// A node that is looked at: its number on the curve among all nodes of T divided by displacement_step, and what one
/// cell round it adds.
struct DisplacementCorner {
  std::size_t place;
  Point2 at;
  double d;
  double area, slope_x, slope_y;  ///< a third of the cell's; slopes of A times that area
};

/// Of nodes every which one is looked at.
[[nodiscard]] std::size_t displacement_step(std::size_t nodes);

/// Adds the corners of a cell that are looked at: numbers[k] is that of corner k.
void add_corners(const std::array<Corner, 3>& cell, const std::array<std::size_t, 3>& numbers, std::size_t step,
                 std::vector<DisplacementCorner>& corners);

/// From the corners of all whole cells of the domain, in any order.
[[nodiscard]] std::optional<Displacement> plain_displacement(std::vector<DisplacementCorner> corners,
                                                             const Frame& frame);

}  // namespace isopach
