// Measures: the numbers of one comparison, from cells with the difference at their corners (METHOD section 3).
// d = f̂2 − f̂1, positive where the second scan lies above. All by area over the domain, on the piecewise linear d.
#pragma once
#include <array>
#include <vector>

namespace isopach {

struct Volume {
  double above = 0;     ///< ∫ max(d, 0)
  double below = 0;     ///< ∫ max(−d, 0)
  double net = 0;       ///< above − below
  double absolute = 0;  ///< above + below
};

struct Histogram {
  std::vector<double> edges;  ///< k + 1 values of d, ascending, symmetric round 0
  std::vector<double> areas;  ///< k areas; d outside the edges is counted in the outermost bins
};

struct DifferenceStatistics {
  double mean = 0, rms = 0, std = 0;
  double median = 0, nmad = 0;           ///< nmad = 1.4826 · median |d − median(d)|
  double max_above = 0, max_below = 0;   ///< largest d and largest −d, both ≥ 0
  std::array<double, 4> abs_percentiles{};  ///< of |d|, see percentile_levels
  Histogram histogram;
};
inline constexpr std::array<int, 4> percentile_levels{50, 90, 95, 99};

struct Measures {
  double area = 0;  ///< of the domain
  double rho = 0;   ///< (7): ∫ |d| / area
  double error_estimate = 0;
  Volume volume;
  DifferenceStatistics difference;
};

}  // namespace isopach
