#include "isopach/match/sandwich.hpp"

#include <Eigen/Dense>
#include <vector>

#include "isopach/match/clusters.hpp"

namespace isopach {

namespace {

using Matrix = Eigen::MatrixXd;

constexpr double most_noise = 0.8;  // of the information: the rest cannot be told

/// `all`, less the share that `noise` has of `h`.
Matrix without_noise(const Matrix& all, const Matrix& h, const Matrix& noise) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(h);
  const Eigen::VectorXd size = solver.eigenvalues().cwiseMax(1e-14 * solver.eigenvalues().maxCoeff()).cwiseSqrt();
  const Matrix& v = solver.eigenvectors();
  const Matrix root = v * size.asDiagonal() * v.transpose();
  const Matrix inverse = v * size.cwiseInverse().asDiagonal() * v.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix> shares(inverse * noise * inverse);
  const Eigen::VectorXd left = (1 - shares.eigenvalues().array()).cwiseMax(1 - most_noise);
  const Matrix keep = shares.eigenvectors() * left.cwiseSqrt().asDiagonal() * shares.eigenvectors().transpose();
  // inverse · all · inverse is nearly a multiple of the unit matrix: the order of the factors hardly matters.
  return root * keep * (inverse * all * inverse) * keep * root;
}

}  // namespace

Eigen::Matrix<double, 7, 7> matrix(const Symmetric7& s) {
  Eigen::Matrix<double, 7, 7> m;
  std::size_t i = 0;
  for (int r = 0; r < 7; ++r)
    for (int c = r; c < 7; ++c) m(r, c) = m(c, r) = s.m[i++];
  return m;
}

Eigen::Matrix<double, 7, 7> sandwich(std::span<const ScoreCell> cells, const Information& known,
                                     const Eigen::Matrix<double, 7, Eigen::Dynamic>& basis, double curvature) {
  if (basis.cols() == 0) return Eigen::Matrix<double, 7, 7>::Zero();
  Symmetric7 all;
  for (const ScoreCell& c : cells) all.add(c.information);
  const auto within = [&](const Symmetric7& s) -> Matrix { return basis.transpose() * matrix(s) * basis; };
  return sandwich(cells, basis, curvature * without_noise(within(all), within(known.h), within(known.noise)));
}

Eigen::Matrix<double, 7, 7> sandwich(std::span<const ScoreCell> cells,
                                     const Eigen::Matrix<double, 7, Eigen::Dynamic>& basis,
                                     const Eigen::MatrixXd& bread) {
  if (basis.cols() == 0) return Eigen::Matrix<double, 7, 7>::Zero();
  std::vector<Vector7> columns(static_cast<std::size_t>(basis.cols()));
  for (std::size_t c = 0; c < columns.size(); ++c)
    for (std::size_t k = 0; k < parameters; ++k)
      columns[c][k] = basis(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(c));
  const Matrix score = basis.transpose() * matrix(clustered_scores(cells, columns)) * basis;
  const Matrix inverse = bread.ldlt().solve(Matrix::Identity(bread.rows(), bread.cols()));
  return basis * inverse * score * inverse * basis.transpose();
}

}  // namespace isopach
