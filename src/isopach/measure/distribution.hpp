// The distribution of the piecewise linear difference by area: percentiles and histograms exact, not from samples.
//
// On one cell of area A with sorted values d0 ≤ d1 ≤ d2 the area where d ≤ v is A (v−d0)²/((d1−d0)(d2−d0)) up to d1 and
// A − A (d2−v)²/((d2−d0)(d2−d1)) from there: two quadratics. A sample of the cells tells about where a quantile lies;
// one pass over all cells makes the area exact as a function of v there: coefficients of quadratics added up, and the
// few cells that have a corner there kept; on those the bracket is narrowed to one double. A histogram is one pass,
// too: coefficients are added to even bins, constant work a cell, however many bins it spans.
#pragma once
#include <vector>

#include "isopach/measure/cells.hpp"

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

/// Of the cells of a source, a CellView or an Overlay (see cells.hpp).
template <class Source>
class Distribution {
 public:
  /// `area` of the domain, `limit` ≥ |d| everywhere, > 0.
  Distribution(const Source& cells, double area, double limit, const Context& context);

  /// One pass for all that are asked for (another one, rarely, where the sample misled). Oracle:
  /// tests/measure/distribution_test.cpp.
  [[nodiscard]] std::vector<double> quantiles(const std::vector<Quantile>& wanted) const;

  /// Area between successive edges (even bins of [low, high]); what lies outside them is counted in the outermost bins.
  [[nodiscard]] std::vector<double> areas_between(double low, double high, std::size_t count) const;

 private:
  [[nodiscard]] std::vector<double> area_up_to_edges(double low, double high, std::size_t count) const;

  const Source& cells_;
  const Context& context_;
  double area_, limit_;
};
extern template class Distribution<CellView>;
extern template class Distribution<Overlay>;

}  // namespace isopach
