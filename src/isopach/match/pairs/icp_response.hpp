// How the pull of ICP's pairs on the pose changes with the pose. Inside match alone: Eigen.
#pragma once
#include <Eigen/Core>

#include "isopach/match/equations.hpp"
#include "isopach/match/pairs/icp_search.hpp"

namespace isopach {

/// Derivative of the distance along `direction` at a point by the parameters: turns and scale about the centre times
/// the radius of `information`, shifts.
[[nodiscard]] Vector7 pair_row(const PairInformation& information, const Point3& at, const Point3& direction);

/// Adds Σ w JᵀJ of a link to `normal`: of its distance along the normal; of kind planes Σ w JᵀPJ of its precision.
void add_link(const PairInformation& information, const Link& link, PairKind kind, Symmetric7& normal);

/// Σ w JᵀJ of the pairs of `found`, of (3), which tells what motions they hold.
[[nodiscard]] Eigen::Matrix<double, 7, 7> pair_normal_matrix(const IcpState& found);

/// −∂(Σ w Jᵀr)/∂(parameters) within `basis` (orthonormal columns, eigenvectors of pair_normal_matrix), symmetric; in
/// the weights of `found`, r the pull() of the objective.
///
/// The normal matrix (add_link) is that derivative for fixed pairs. But a point that moves finds other partners, and
/// among noisy ones those that lie as it does: along the normal the distance grows by less than the motion, by half of
/// it where FIXED has many points within its noise. Normals that err hold nothing that partners do not follow; pairs
/// come in and go out, and weights follow the residuals. All of that is in differences of the pull between poses at
/// both sides of the one found, half a standard deviation of the residuals away, with pairs and weights of their own.
/// Its eigenvalues are kept within 0.1 and 1 times the normal matrix. Cost: a search of at most 8192 pairs a side for
/// each of 13 poses. Test: tests/match/pulls_test.cpp.
[[nodiscard]] Eigen::MatrixXd pull_response(const IcpState& found, const OrientedCloud& moving,
                                            const OrientedCloud& fixed, const MatchOptions& options,
                                            const Eigen::Matrix<double, 7, Eigen::Dynamic>& basis);

}  // namespace isopach
