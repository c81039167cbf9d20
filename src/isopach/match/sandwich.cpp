#include "isopach/match/sandwich.hpp"

#include <vector>

#include "isopach/base/linear.hpp"
#include "isopach/match/clusters.hpp"

namespace isopach {

namespace {

using Matrix = Eigen::MatrixXd;

constexpr double most_noise = 0.8;  // of the information: the rest cannot be told

/// `all`, less the share that `noise` has of `h`.
Matrix without_noise(const Matrix& all, const Matrix& h, const Matrix& noise) {
  const Spectrum<Eigen::Dynamic> of_h = spectrum(h);
  const Eigen::VectorXd size = of_h.values.cwiseMax(1e-14 * of_h.values.maxCoeff()).cwiseSqrt();
  const Matrix root = from_spectrum(of_h.vectors, size);
  const Matrix inverse = from_spectrum(of_h.vectors, size.cwiseInverse());
  const Spectrum<Eigen::Dynamic> shares = spectrum(product(product(inverse, noise), inverse));
  const Eigen::VectorXd left = (1 - shares.values.array()).cwiseMax(1 - most_noise);
  const Matrix keep = from_spectrum(shares.vectors, left.cwiseSqrt());
  // inverse · all · inverse is nearly a multiple of the unit matrix: the order of the factors hardly matters.
  return product(product(product(product(root, keep), product(product(inverse, all), inverse)), keep), root);
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
  const auto part = [&](const Symmetric7& s) { return within(basis, matrix(s)); };
  return sandwich(cells, basis, curvature * without_noise(part(all), part(known.h), part(known.noise)));
}

Eigen::Matrix<double, 7, 7> sandwich(std::span<const ScoreCell> cells,
                                     const Eigen::Matrix<double, 7, Eigen::Dynamic>& basis,
                                     const Eigen::MatrixXd& bread) {
  if (basis.cols() == 0) return Eigen::Matrix<double, 7, 7>::Zero();
  std::vector<Vector7> columns(static_cast<std::size_t>(basis.cols()));
  for (std::size_t c = 0; c < columns.size(); ++c)
    for (std::size_t k = 0; k < parameters; ++k)
      columns[c][k] = basis(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(c));
  const Matrix score = within(basis, matrix(clustered_scores(cells, columns)));
  const Matrix inverse = Ldlt(bread).solve_columns(Matrix::Identity(bread.rows(), bread.cols()));
  return between_inverses(basis, inverse, score);
}

}  // namespace isopach
