// Sums and extremes over cells, from which the measures follow (docs/method/method.md, section 2).
#pragma once
#include <algorithm>

#include "isopach/base/fixed_sum.hpp"
#include "isopach/measure/measures.hpp"

namespace isopach {

/// The grids of sums over cells. Cells do not overlap, so that their areas add up to no more than the box of all nodes,
/// and integrals of |d| and d² to no more than that times the largest |d| and its square. Whoever adds cells several
/// times over, or pieces of them that overlap, says how often: `times`.
struct SumScales {
  FixedScale area, volume, square;
  explicit SumScales(const SumBounds& b, double times = 1)
      : area{times, b.area}, volume{times, b.area, b.difference}, square{times, b.area, b.difference, b.difference} {}
};

/// Area and both volumes of some cells.
struct VolumeSums {
  FixedSum area, above, below;

  VolumeSums() = default;  ///< takes its grid from the first that is added
  explicit VolumeSums(const SumScales& scales) : area(scales.area), above(scales.volume), below(scales.volume) {}

  void add(const Cell& cell) {
    area.add(cell.area);
    add_volume(split_volume(cell));
  }
  void add_volume(const Parts& parts) {
    if (parts.above != 0) above.add(parts.above);
    if (parts.below != 0) below.add(parts.below);
  }
  void add(const VolumeSums& other) {
    area.add(other.area);
    above.add(other.above);
    below.add(other.below);
  }
  void subtract(const VolumeSums& other) {
    area.subtract(other.area);
    above.subtract(other.above);
    below.subtract(other.below);
  }
  /// Each rounded once: net is not above − below as they are rounded, but as they are.
  [[nodiscard]] Volume volume() const {
    return {above.value(), below.value(), difference(above, below), total(above, below)};
  }
};

/// split_volume() of a cell with ascending values: most have one sign, and take no call.
[[nodiscard]] inline Parts split_sorted(const Cell& cell) {
  const auto [d0, d1, d2] = cell.d;
  if (d0 >= 0) return {cell.area * (d1 + (d0 + d2)) / 3, 0};
  if (d2 <= 0) return {0, cell.area * -(d1 + (d0 + d2)) / 3};
  return split_volume(cell);
}

struct Totals {
  VolumeSums of;     ///< ∫ 1, ∫ max(d, 0), ∫ max(−d, 0)
  FixedSum squares;  ///< ∫ d²
  double max_above = 0, max_below = 0;

  Totals() = default;  ///< takes its grid from the first that is added
  explicit Totals(const SumScales& scales) : of(scales), squares(scales.square) {}

  void add(const Cell& cell) {  // values sorted
    of.area.add(cell.area);
    add_heights(cell);
  }
  /// All but the area, which the caller adds by himself.
  void add_heights(const Cell& cell) {
    of.add_volume(split_sorted(cell));
    const auto [d0, d1, d2] = cell.d;
    // ∫ d² = A/6 (Σ di² + Σ di dj) = A/12 (Σ di² + (Σ di)²). Outer values together: see split_volume.
    const double s = d1 + (d0 + d2);
    squares.add(cell.area / 12 * (d1 * d1 + (d0 * d0 + d2 * d2) + s * s));
    max_above = std::max(max_above, d2);
    max_below = std::max(max_below, -d0);
  }
  void add(const Totals& other) {
    of.add(other.of);
    squares.add(other.squares);
    max_above = std::max(max_above, other.max_above);
    max_below = std::max(max_below, other.max_below);
  }
  [[nodiscard]] double largest() const { return std::max(max_above, max_below); }
};

}  // namespace isopach
