// Decompositions and products of small matrices, compiled once: Eigen's templates for them take half a minute of the
// compiler in every file that uses them. Files of the library include this header and no <Eigen/Dense>.
//
// These are Eigen's own algorithms on the types that stand here: another type (a fixed size for a dynamic one, or the
// reverse) may sum in another order and change the last bits, and so may a chain of products in pieces, because Eigen
// keeps what lies between them in rows or in columns as the whole chain says. Test: Linear.* in
// tests/base/linear_test.cpp, against the definitions.
#pragma once
#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace isopach {

/// Eigenvalues of a symmetric matrix, in increasing order, and its eigenvectors of length 1, one a column.
template <int n>
struct Spectrum {
  Eigen::Matrix<double, n, 1> values;
  Eigen::Matrix<double, n, n> vectors;
};

/// Of a symmetric matrix of 3, 6 or Eigen::Dynamic rows, of which the lower triangle is read. By QL steps on its
/// tridiagonal form (Eigen::SelfAdjointEigenSolver); O(n³).
template <int n>
[[nodiscard]] Spectrum<n> spectrum(const Eigen::Matrix<double, n, n>& m);

/// The eigenvalues alone, of 6 or Eigen::Dynamic rows.
template <int n>
[[nodiscard]] Eigen::Matrix<double, n, 1> eigenvalues(const Eigen::Matrix<double, n, n>& m);

/// In closed form: faster by far, to half of the digits.
[[nodiscard]] Spectrum<3> rough_spectrum(const Eigen::Matrix3d& m);

/// V diag(values) Vᵀ.
[[nodiscard]] Eigen::MatrixXd from_spectrum(const Eigen::MatrixXd& vectors, const Eigen::VectorXd& values);
/// m V diag(values) Vᵀ m.
[[nodiscard]] Eigen::MatrixXd from_spectrum_between(const Eigen::MatrixXd& m, const Eigen::MatrixXd& vectors,
                                                    const Eigen::VectorXd& values);
/// diag(scale) V diag(values) Vᵀ diag(scale).
[[nodiscard]] Eigen::MatrixXd from_spectrum_scaled(const Eigen::VectorXd& scale, const Eigen::MatrixXd& vectors,
                                                   const Eigen::VectorXd& values);

/// Factors L D Lᵀ, with pivots, of a symmetric matrix of 3, 4, 6 or Eigen::Dynamic rows, of which the lower triangle is
/// read. A singular matrix gives a solution that need not solve anything: ask `pivots` where that may be.
template <int n>
class Ldlt {
 public:
  using Vector = Eigen::Matrix<double, n, 1>;
  using Matrix = Eigen::Matrix<double, n, n>;

  explicit Ldlt(const Eigen::Matrix<double, n, n>& m);
  [[nodiscard]] Vector solve(const Vector& right) const;
  /// Solves for every column.
  [[nodiscard]] Matrix solve_columns(const Matrix& right) const;
  [[nodiscard]] Vector pivots() const { return factors_.vectorD(); }
  [[nodiscard]] bool succeeded() const { return factors_.info() == Eigen::Success; }
  [[nodiscard]] bool is_positive() const { return factors_.isPositive(); }

 private:
  Eigen::LDLT<Matrix> factors_;
};

/// x of least |a x − b|, column by column; `a` has full column rank. Householder QR with column pivots.
[[nodiscard]] Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Of all x of least |a x − b| the one of least |x|. Pivots below `threshold` times the largest count as 0; 0: below
/// the rounding errors. Complete orthogonal decomposition.
[[nodiscard]] Eigen::VectorXd least_norm(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold = 0);
[[nodiscard]] Eigen::Matrix<double, 4, 6> least_norm(const Eigen::Matrix4d& a, const Eigen::Matrix<double, 4, 6>& b);

/// m = u diag(values) vᵀ with values in decreasing order.
struct SingularValues {
  Eigen::Matrix3d u, v;
  Eigen::Vector3d values;
};
[[nodiscard]] SingularValues singular_values(const Eigen::Matrix3d& m);

// --- Products of matrices whose size is known when the program runs ---

[[nodiscard]] Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
[[nodiscard]] Eigen::VectorXd product(const Eigen::MatrixXd& a, const Eigen::VectorXd& x);
/// aᵀ b, aᵀ x.
[[nodiscard]] Eigen::MatrixXd product_of_transposed(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
[[nodiscard]] Eigen::VectorXd product_of_transposed(const Eigen::MatrixXd& a, const Eigen::VectorXd& x);
/// a bᵀ.
[[nodiscard]] Eigen::MatrixXd product_with_transposed(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// --- Motions of seven parameters, and those of them that a basis spans ---

using Matrix7 = Eigen::Matrix<double, 7, 7>;
/// A motion a column.
using Basis7 = Eigen::Matrix<double, 7, Eigen::Dynamic>;

/// basisᵀ m basis.
[[nodiscard]] Eigen::MatrixXd within(const Basis7& basis, const Matrix7& m);
[[nodiscard]] Eigen::MatrixXd within(const Eigen::MatrixXd& basis, const Matrix7& m);
/// innerᵀ basisᵀ m basis inner.
[[nodiscard]] Eigen::MatrixXd within(const Eigen::MatrixXd& inner, const Eigen::MatrixXd& basis, const Matrix7& m);
/// a b m bᵀ aᵀ.
[[nodiscard]] Eigen::MatrixXd outside(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, const Eigen::MatrixXd& m);
/// The vector of `basis` with these coordinates.
[[nodiscard]] Eigen::Matrix<double, 7, 1> from_basis(const Basis7& basis, const Eigen::VectorXd& coordinates);
/// basisᵀ x.
[[nodiscard]] Eigen::VectorXd along_basis(const Basis7& basis, const Eigen::Matrix<double, 7, 1>& x);
/// basis bread⁻¹ meat bread⁻¹ basisᵀ.
[[nodiscard]] Matrix7 between_inverses(const Basis7& basis, const Eigen::MatrixXd& bread_inverse,
                                       const Eigen::MatrixXd& meat);

}  // namespace isopach
