// Cluster-robust scores: how much the pulls on a pose vary, where residuals near one another may be correlated.
//
// The covariance of an estimate from weighted equations is H⁻¹ M H⁻¹ (the sandwich of [Huber1967]), M the covariance
// of the score Σ w Jᵀn. Residuals of a pose are not independent: the noise of one node is in the residuals of all nodes
// of the other scan that lie over its facets, strips of a scanner that drifts are shifted as a whole, and a change that
// is not kept out entirely pulls over all of its area. M is therefore summed over clusters [Liang1986]: within one,
// residuals may be correlated in any way. How large they must be is asked of the residuals.
#pragma once
#include <span>
#include <vector>

#include "isopach/match/equations.hpp"

namespace isopach {

/// Covariance of the whole score within the span of `basis` (its vectors orthonormal), from cells in an order in which
/// neighbours are near (a space-filling curve).
///
/// Clusters are runs of sixteen cells; they grow to longer runs where the sum of squares over these is larger than
/// chance makes it (two standard deviations of the trace, in the metric of the information): of the lengths that are,
/// the one with the largest, along no motion less than the small clusters say. No length has less than two clusters a
/// parameter; with less cells runs are shorter. The residuals of a cluster are small since the pose was fitted to them:
/// corrected by its leverage ([Bell2002], CR2). With independent noise M is a multiple of the
/// information; from few clusters it is drawn there, as far as their scatter says [Ledoit2004].
///
/// Strips across the scans in one of four directions (12, 24 or 48) may err in height as a whole. The variance of their
/// offsets, one number, is what the squares of their height scores have beyond chance, less what the fit took off; it
/// adds the pull that such offsets have on each motion. Of directions and widths, those that add most.
///
/// 0 outside the span, and without cells. Cost O(cells). Test: tests/match/clusters_test.cpp.
[[nodiscard]] Symmetric7 clustered_scores(std::span<const ScoreCell> cells, std::span<const Vector7> basis);

}  // namespace isopach
