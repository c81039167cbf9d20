// The distribution of the piecewise linear difference by area: percentiles and histograms exact, not from samples.
//
// On one cell of area A with sorted values d0 ≤ d1 ≤ d2 the area where d ≤ v is A (v−d0)²/((d1−d0)(d2−d0)) up to d1 and
// A − A (d2−v)²/((d2−d0)(d2−d1)) from there: two quadratics. A sample of the cells tells about where a quantile lies;
// one pass over all cells makes the area exact as a function of v there: coefficients of quadratics added up, and the
// few cells that have a corner there kept; on those the bracket is narrowed to one double. A histogram comes from the
// same pass: coefficients are added to even bins, constant work a cell, however many bins it spans. A cell within one
// bin that no quantile lies in, as most are, only adds its area to it.
#pragma once
#include <vector>

#include "isopach/measure/parted_cells.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/volume/totals.hpp"

namespace isopach {

/// Area of a cell where d ≤ v.
[[nodiscard]] double area_below(const Cell& cell, double v);

/// The smallest v with area{variable ≤ v} ≥ share · area, 0 < share < 1. The variable is d, or |d − centre|.
struct Quantile {
  static constexpr std::size_t nothing = static_cast<std::size_t>(-1);
  double share = 0.5;
  bool absolute = false;
  double centre = 0;
  std::size_t about = nothing;  ///< if set, the centre is the quantile of that number, one that is asked for before
};

/// What describe() finds.
struct Described {
  Totals totals;
  std::vector<double> quantiles;  ///< as they were asked for; empty if the domain is
  Histogram histogram;            ///< even bins, symmetric round 0; what lies outside is counted in the outermost ones
};

/// Sums, quantiles and histogram over the cells of a source (source.hpp, parted_cells.hpp) in one pass (another
/// one, rarely, where the sample misled). Half-width of the histogram: 1.5 times the 99th percentile of |d|,
/// estimated from the sample, at most the largest |d| in it. Cost O(cells). Oracle:
/// tests/measure/distribution_test.cpp (every cell cut at the value in question).
template <class Source>
[[nodiscard]] Described describe(const Source& cells, const std::vector<Quantile>& wanted, std::size_t bins,
                                 const Context& context);
extern template Described describe(const CellView&, const std::vector<Quantile>&, std::size_t, const Context&);
extern template Described describe(const OverlayCells&, const std::vector<Quantile>&, std::size_t, const Context&);
extern template Described describe(const PartedCells&, const std::vector<Quantile>&, std::size_t, const Context&);

}  // namespace isopach
