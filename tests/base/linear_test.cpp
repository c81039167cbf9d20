#include "isopach/base/linear.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random.hpp"

namespace isopach {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

MatrixXd any(std::uint64_t seed, Eigen::Index rows, Eigen::Index columns) {
  test::Random random(seed);
  MatrixXd m(rows, columns);
  for (Eigen::Index j = 0; j < columns; ++j)
    for (Eigen::Index i = 0; i < rows; ++i) m(i, j) = random.bell();
  return m;
}

MatrixXd multiplied(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd m = MatrixXd::Zero(a.rows(), b.cols());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < b.cols(); ++j)
      for (Eigen::Index k = 0; k < a.cols(); ++k) m(i, j) += a(i, k) * b(k, j);
  return m;
}

MatrixXd transposed(const MatrixXd& m) { return m.transpose(); }

MatrixXd symmetric(std::uint64_t seed, Eigen::Index n) {
  const MatrixXd m = any(seed, n, n);
  return m + transposed(m);
}

void expect_near(const MatrixXd& a, const MatrixXd& b, double tolerance) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
  EXPECT_LE((a - b).cwiseAbs().maxCoeff(), tolerance) << a << "\n\n" << b;
}

void expect_spectrum(const MatrixXd& m, const VectorXd& values, const MatrixXd& vectors, double tolerance) {
  const Eigen::Index n = m.rows();
  for (Eigen::Index k = 1; k < n; ++k) EXPECT_LE(values(k - 1), values(k));
  expect_near(multiplied(transposed(vectors), vectors), MatrixXd::Identity(n, n), tolerance);
  expect_near(multiplied(m, vectors), vectors * values.asDiagonal(), tolerance);
}

TEST(Linear, EigenvectorsAreTurnedIntoTheirMultiples) {
  const MatrixXd m = symmetric(1, 6);
  const Spectrum<3> three = spectrum<3>(m.topLeftCorner<3, 3>());
  expect_spectrum(m.topLeftCorner(3, 3), three.values, three.vectors, 1e-13);
  const Spectrum<6> six = spectrum<6>(m);
  expect_spectrum(m, six.values, six.vectors, 1e-13);
  const MatrixXd large = symmetric(2, 11);
  const Spectrum<Eigen::Dynamic> any_size = spectrum(large);
  expect_spectrum(large, any_size.values, any_size.vectors, 1e-13);
  expect_near(from_spectrum(any_size.vectors, any_size.values), large, 1e-13);
  const VectorXd scale = any(3, 11, 1).cwiseAbs();
  expect_near(from_spectrum_scaled(scale, any_size.vectors, any_size.values),
              scale.asDiagonal() * large * scale.asDiagonal(), 1e-12);
  const MatrixXd between = any(4, 11, 11);
  expect_near(from_spectrum_between(between, any_size.vectors, any_size.values),
              multiplied(between, multiplied(large, between)), 1e-11);
  expect_near(eigenvalues<6>(m), six.values, 1e-13);
  expect_near(eigenvalues(large), any_size.values, 1e-13);
}

TEST(Linear, OfASymmetricMatrixTheLowerTriangleIsRead) {
  const MatrixXd m = symmetric(3, 6);
  MatrixXd lower = m;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(1e9);
  EXPECT_EQ(spectrum<6>(lower).vectors, spectrum<6>(m).vectors);
  const Eigen::Matrix<double, 6, 1> right = any(4, 6, 1);
  EXPECT_EQ(Ldlt<6>(lower).solve(right), Ldlt<6>(m).solve(right));
}

TEST(Linear, TheClosedFormHasHalfOfTheDigits) {
  for (std::uint64_t seed = 10; seed < 30; ++seed) {
    const Eigen::Matrix3d m = symmetric(seed, 3);
    const Spectrum<3> rough = rough_spectrum(m);
    expect_spectrum(m, rough.values, rough.vectors, 1e-6);
  }
}

template <int n>
void expect_solved(const MatrixXd& m, std::uint64_t seed) {
  const Ldlt<n> ldlt(m);
  const MatrixXd right = any(seed, m.rows(), m.rows());
  const VectorXd one = right.col(0);
  expect_near(multiplied(m, ldlt.solve(one)), one, 1e-11);
  expect_near(multiplied(m, ldlt.solve_columns(right)), right, 1e-11);
  EXPECT_TRUE(ldlt.succeeded());
}

TEST(Linear, FactorsSolve) {
  expect_solved<3>(symmetric(5, 3), 6);
  expect_solved<4>(symmetric(5, 4), 6);
  expect_solved<6>(symmetric(5, 6), 6);
  expect_solved<Eigen::Dynamic>(symmetric(5, 9), 6);
}

TEST(Linear, PivotsTellWhetherAMatrixIsPositiveAndWhetherItIsSingular) {
  const MatrixXd a = any(7, 6, 6), flat = any(8, 6, 2);
  const Ldlt<6> positive(multiplied(a, transposed(a))), negative(-multiplied(a, transposed(a))),
      singular(multiplied(flat, transposed(flat)));
  EXPECT_TRUE(positive.is_positive());
  EXPECT_GT(positive.pivots().minCoeff(), 0);
  EXPECT_FALSE(negative.is_positive());
  EXPECT_LT(std::fabs(singular.pivots().minCoeff()), 1e-13 * singular.pivots().maxCoeff());
}

TEST(Linear, LeastSquaresLeavesNothingAlongTheColumns) {
  const MatrixXd a = any(11, 20, 4), b = any(12, 20, 3), x = least_squares(a, b);
  expect_near(multiplied(transposed(a), multiplied(a, x) - b), MatrixXd::Zero(4, 3), 1e-12);
}

TEST(Linear, OfAllSolutionsTheShortestOneIsTaken) {
  MatrixXd a = any(13, 20, 4);
  a.col(3) = a.col(2);
  const VectorXd b = any(14, 20, 1), x = least_norm(a, b);
  expect_near(multiplied(transposed(a), multiplied(a, x) - b), MatrixXd::Zero(4, 1), 1e-12);
  EXPECT_NEAR(x(2), x(3), 1e-13);  // any difference between the two would make it longer
  a.col(3) += 1e-9 * any(15, 20, 1);
  EXPECT_NEAR(least_norm(a, b, 1e-6)(2), least_norm(a, b, 1e-6)(3), 1e-6);
  EXPECT_GT(least_norm(a, b).norm(), 1e3 * x.norm());  // the columns differ by more than the rounding errors
  Eigen::Matrix4d m = symmetric(16, 4);
  m.row(3) = m.row(2), m.col(3) = m.col(2);
  const Eigen::Matrix<double, 4, 6> right = multiplied(m, any(17, 4, 6));
  const Eigen::Matrix<double, 4, 6> all = least_norm(m, right);
  expect_near(multiplied(m, all), right, 1e-12);
  expect_near(all.row(2), all.row(3), 1e-12);
}

TEST(Linear, SingularVectorsAreTurnsAndMirrorings) {
  const Eigen::Matrix3d m = any(18, 3, 3);
  const SingularValues s = singular_values(m);
  EXPECT_TRUE(s.values(0) >= s.values(1) && s.values(1) >= s.values(2) && s.values(2) >= 0);
  expect_near(multiplied(transposed(s.u), s.u), MatrixXd::Identity(3, 3), 1e-14);
  expect_near(multiplied(transposed(s.v), s.v), MatrixXd::Identity(3, 3), 1e-14);
  expect_near(multiplied(s.u * s.values.asDiagonal(), transposed(s.v)), m, 1e-14);
}

TEST(Linear, ProductsAreSumsOfProducts) {
  for (const Eigen::Index n : {1, 3, 7, 50}) {  // small ones and large ones go other ways in Eigen
    const MatrixXd a = any(20, n, n + 1), b = any(21, n + 1, n + 2);
    const VectorXd x = any(22, n + 1, 1);
    expect_near(product(a, b), multiplied(a, b), 1e-12);
    expect_near(product(a, x), multiplied(a, x), 1e-12);
    expect_near(product_of_transposed(transposed(a), b), multiplied(a, b), 1e-12);
    expect_near(product_of_transposed(transposed(a), x), multiplied(a, x), 1e-12);
    expect_near(product_with_transposed(a, transposed(b)), multiplied(a, b), 1e-12);
  }
}

TEST(Linear, ABasisTakesAMatrixToItsSpanAndBack) {
  for (const Eigen::Index p : {1, 4, 7}) {
    const Basis7 basis = any(23, 7, p);
    const MatrixXd columns = basis, m = symmetric(24, 7), inner = any(25, p, p), meat = any(26, p, p);
    const MatrixXd expected = multiplied(transposed(columns), multiplied(m, columns));
    expect_near(within(basis, Matrix7(m)), expected, 1e-12);
    expect_near(within(columns, Matrix7(m)), expected, 1e-12);
    expect_near(within(inner, columns, Matrix7(m)), multiplied(transposed(inner), multiplied(expected, inner)), 1e-11);
    expect_near(outside(columns, inner, meat),
                multiplied(multiplied(columns, inner), multiplied(meat, transposed(multiplied(columns, inner)))),
                1e-11);
    const VectorXd x = any(27, p, 1), y = any(28, 7, 1);
    expect_near(from_basis(basis, x), multiplied(columns, x), 1e-12);
    expect_near(along_basis(basis, y), multiplied(transposed(columns), y), 1e-12);
    expect_near(between_inverses(basis, inner, meat),
                multiplied(columns, multiplied(multiplied(inner, multiplied(meat, inner)), transposed(columns))),
                1e-10);
  }
}

}  // namespace
}  // namespace isopach
