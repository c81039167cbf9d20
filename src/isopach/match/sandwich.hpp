// Covariance of a pose from its equations: H⁻¹ M H⁻¹, with M over clusters (clusters.hpp). Inside match alone: Eigen.
#pragma once
#include <Eigen/Core>
#include <span>

#include "isopach/match/equations.hpp"

namespace isopach {

[[nodiscard]] Eigen::Matrix<double, 7, 7> matrix(const Symmetric7& s);

/// Within the span of `basis` (orthonormal columns), 0 outside. Derivatives that carry noise seem to know more than
/// they do: the bread is the information of the cells less the share that noise has of `known`, at most four fifths,
/// times `curvature`, the second derivative of the loss over its weights.
[[nodiscard]] Eigen::Matrix<double, 7, 7> sandwich(std::span<const ScoreCell> cells, const Information& known,
                                                   const Eigen::Matrix<double, 7, Eigen::Dynamic>& basis,
                                                   double curvature);

/// The same with `bread`, within the basis, from elsewhere.
[[nodiscard]] Eigen::Matrix<double, 7, 7> sandwich(std::span<const ScoreCell> cells,
                                                   const Eigen::Matrix<double, 7, Eigen::Dynamic>& basis,
                                                   const Eigen::MatrixXd& bread);

}  // namespace isopach
