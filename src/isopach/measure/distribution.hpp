// The distribution of the piecewise linear difference by area: percentiles and histograms exact, not from samples.
//
// On one cell of area A with sorted values d0 ≤ d1 ≤ d2 the area where d ≤ v is A (v−d0)²/((d1−d0)(d2−d0)) up to d1 and
// A − A (d2−v)²/((d2−d0)(d2−d1)) from there. Quantiles are found by summing that over all cells in bins, going on with
// the cells that the wanted bin cuts, and bisecting when few are left.
#pragma once
#include <vector>

#include "isopach/measure/measures.hpp"

namespace isopach {

/// Area of a cell where d ≤ v.
[[nodiscard]] double area_below(const Cell& cell, double v);

/// The variable whose distribution is asked for: d itself, or |d − centre|.
struct Variable {
  bool absolute = false;
  double centre = 0;
};

/// For each share p (0 < p < 1, ascending) the smallest v with area{variable ≤ v} ≥ p · area. `limit` bounds
/// |variable|.
[[nodiscard]] std::vector<double> quantiles(const CellView& cells, double area, Variable variable, double limit,
                                            const std::vector<double>& shares, const Context& context);

/// Area between successive edges; what lies outside the edges is counted in the outermost bins.
[[nodiscard]] std::vector<double> areas_between(const CellView& cells, const std::vector<double>& edges,
                                                const Context& context);

}  // namespace isopach
