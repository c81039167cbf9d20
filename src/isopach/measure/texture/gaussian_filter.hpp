// gaussian_mean: the mean surface of a scan on its own irregular nodes, by the areal Gaussian filter.
//
// Source: [ISO16610], parts 61 (linear areal Gaussian filter), 28 (end effects, moment criterion), 31 and 71 (robust
// Gaussian regression filter). The weighting function of cut-off λc is
//   s(r) = exp(−π r² / (α λc)²) / (α λc)²,   α = √(ln 2 / π):
// a sine wave of wavelength λc keeps half of its amplitude, one of λ keeps exp(−π (α λc / λ)²).
// For many points in the reach of the kernel the sums are evaluated as in the fast Gauss transform
// [Greengard1991], with Chebyshev interpolation of the kernel in square boxes [Fong2009].
#pragma once
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// What one pass of the filter does to a sine wave of wavelength λ: the share of its amplitude that stays.
[[nodiscard]] double gaussian_transmission(double cutoff, double wavelength);

struct GaussianOptions {
  double cutoff = 0;  ///< nesting index λc, unit of x and y; above 0
  /// 0: the weighted mean. 1: the value of the weighted least-squares plane at the node: planes stay planes up to the
  /// rim, and where the points are uneven. Both are the Gaussian filter where weights are even.
  unsigned degree = 1;
};

/// The filtered height at every node: with weights area_j s(|p_j − p_i|), normalised by their sum, of all nodes j
/// within 1.3 λc (the kernel is 10⁻¹¹ of its peak there). `area` is the part of the plane each node stands for (0 or
/// more; nodes of area 0 lend nothing and get NaN). Within 1e-8 of the range of heights of the sum over all pairs.
/// Errors: UsageError where the cut-off is not above 0 or so short against the extent that it cannot be counted in.
/// Degenerate: nodes on one line get the weighted mean whatever the degree. Cost: O(n) boxes and nodes where the kernel
/// reaches many points, O(points in its reach) a node otherwise; the same bits for any number of threads.
/// Oracle: all pairs, tests/measure/gaussian_filter_test.cpp.
[[nodiscard]] Array<double> gaussian_mean(std::span<const Point2> xy, std::span<const double> area,
                                          std::span<const double> z, const GaussianOptions& options,
                                          const Context& context);

/// The same, not drawn by deep valleys and high peaks: heights further than c = 4.4478 × the median of |z − mean| from
/// it have no weight, nearer ones (1 − ((z − mean)/c)²)², until c changes by less than a thousandth (at most 10
/// passes). A node without any weight near it keeps the mean of the pass before.
[[nodiscard]] Array<double> robust_gaussian_mean(std::span<const Point2> xy, std::span<const double> area,
                                                 std::span<const double> z, const GaussianOptions& options,
                                                 const Context& context);

}  // namespace isopach
