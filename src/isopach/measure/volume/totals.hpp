// Sums and extremes over cells, from which the measures follow (docs/method/method.md, section 2).
#pragma once
#include <algorithm>

#include "isopach/base/sum.hpp"
#include "isopach/measure/measures.hpp"

namespace isopach {

struct Totals {
  Sum area, above, below, squares;  ///< ∫ 1, ∫ max(d, 0), ∫ max(−d, 0), ∫ d²
  double max_above = 0, max_below = 0;

  void add(const Cell& cell) {  // values sorted
    const Parts parts = split_volume(cell);
    const auto [d0, d1, d2] = cell.d;
    area.add(cell.area);
    above.add(parts.above);
    below.add(parts.below);
    // ∫ d² = A/6 (Σ di² + Σ di dj) = A/12 (Σ di² + (Σ di)²). Outer values together: see split_volume.
    const double s = d1 + (d0 + d2);
    squares.add(cell.area / 12 * (d1 * d1 + (d0 * d0 + d2 * d2) + s * s));
    max_above = std::max(max_above, d2);
    max_below = std::max(max_below, -d0);
  }
  void add(const Totals& other) {
    area.add(other.area);
    above.add(other.above);
    below.add(other.below);
    squares.add(other.squares);
    max_above = std::max(max_above, other.max_above);
    max_below = std::max(max_below, other.max_below);
  }
  [[nodiscard]] double largest() const { return std::max(max_above, max_below); }
};

}  // namespace isopach
