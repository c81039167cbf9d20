// The products of base/linear.hpp, apart from the decompositions: the build optimises this file less, because Eigen's
// templates for products take the compiler longest, and what they compute is small.
#include <Eigen/Core>

#include "isopach/base/linear.hpp"

namespace isopach {

using Eigen::MatrixXd, Eigen::VectorXd;

MatrixXd from_spectrum(const MatrixXd& vectors, const VectorXd& values) {
  return vectors * values.asDiagonal() * vectors.transpose();
}

MatrixXd from_spectrum_between(const MatrixXd& m, const MatrixXd& vectors, const VectorXd& values) {
  return m * vectors * values.asDiagonal() * vectors.transpose() * m;
}
MatrixXd from_spectrum_scaled(const VectorXd& scale, const MatrixXd& vectors, const VectorXd& values) {
  return scale.asDiagonal() * vectors * values.asDiagonal() * vectors.transpose() * scale.asDiagonal();
}

MatrixXd product(const MatrixXd& a, const MatrixXd& b) { return a * b; }
VectorXd product(const MatrixXd& a, const VectorXd& x) { return a * x; }
MatrixXd product_of_transposed(const MatrixXd& a, const MatrixXd& b) { return a.transpose() * b; }
VectorXd product_of_transposed(const MatrixXd& a, const VectorXd& x) { return a.transpose() * x; }
MatrixXd product_with_transposed(const MatrixXd& a, const MatrixXd& b) { return a * b.transpose(); }

MatrixXd within(const Basis7& basis, const Matrix7& m) { return basis.transpose() * m * basis; }
MatrixXd within(const MatrixXd& basis, const Matrix7& m) { return basis.transpose() * m * basis; }
MatrixXd within(const MatrixXd& inner, const MatrixXd& basis, const Matrix7& m) {
  return inner.transpose() * (basis.transpose() * m * basis) * inner;
}
MatrixXd outside(const MatrixXd& a, const MatrixXd& b, const MatrixXd& m) {
  return a * b * m * b.transpose() * a.transpose();
}
Eigen::Matrix<double, 7, 1> from_basis(const Basis7& basis, const VectorXd& coordinates) { return basis * coordinates; }
VectorXd along_basis(const Basis7& basis, const Eigen::Matrix<double, 7, 1>& x) { return basis.transpose() * x; }
Matrix7 between_inverses(const Basis7& basis, const MatrixXd& bread_inverse, const MatrixXd& meat) {
  return basis * bread_inverse * meat * bread_inverse * basis.transpose();
}

}  // namespace isopach
