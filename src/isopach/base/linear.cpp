#include "isopach/base/linear.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace isopach {

using Eigen::Dynamic, Eigen::MatrixXd, Eigen::VectorXd;

template <int n>
Spectrum<n> spectrum(const Eigen::Matrix<double, n, n>& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, n, n>> solver(m);
  return {solver.eigenvalues(), solver.eigenvectors()};
}
template Spectrum<3> spectrum<3>(const Eigen::Matrix3d&);
template Spectrum<6> spectrum<6>(const Eigen::Matrix<double, 6, 6>&);
template Spectrum<Dynamic> spectrum<Dynamic>(const MatrixXd&);

template <int n>
Eigen::Matrix<double, n, 1> eigenvalues(const Eigen::Matrix<double, n, n>& m) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, n, n>>(m, Eigen::EigenvaluesOnly).eigenvalues();
}
template Eigen::Matrix<double, 6, 1> eigenvalues<6>(const Eigen::Matrix<double, 6, 6>&);
template VectorXd eigenvalues<Dynamic>(const MatrixXd&);

Spectrum<3> rough_spectrum(const Eigen::Matrix3d& m) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(m);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <int n>
Ldlt<n>::Ldlt(const Eigen::Matrix<double, n, n>& m) : factors_(m) {}
template <int n>
typename Ldlt<n>::Vector Ldlt<n>::solve(const Vector& right) const {
  return factors_.solve(right);
}
template <int n>
typename Ldlt<n>::Matrix Ldlt<n>::solve_columns(const Matrix& right) const {
  return factors_.solve(right);
}
template class Ldlt<3>;
template class Ldlt<4>;
template class Ldlt<6>;
template class Ldlt<Dynamic>;

MatrixXd least_squares(const MatrixXd& a, const MatrixXd& b) { return a.colPivHouseholderQr().solve(b); }

VectorXd least_norm(const MatrixXd& a, const VectorXd& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
  if (threshold > 0) solver.setThreshold(threshold);
  return solver.compute(a).solve(b);
}
Eigen::Matrix<double, 4, 6> least_norm(const Eigen::Matrix4d& a, const Eigen::Matrix<double, 4, 6>& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

SingularValues singular_values(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.matrixV(), svd.singularValues()};
}

}  // namespace isopach
