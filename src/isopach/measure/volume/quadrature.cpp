#include "isopach/measure/volume/quadrature.hpp"

#include <Eigen/Dense>

#include <cmath>

namespace isopach {

namespace {

constexpr int degree = 4, monomials = (degree + 1) * (degree + 2) / 2;
constexpr int points = static_cast<int>(triangle_rule.size());

Eigen::Matrix<double, monomials, 1> values_at(const std::array<double, 3>& p) {
  Eigen::Matrix<double, monomials, 1> v;
  int n = 0;
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j) v[n++] = std::pow(p[0], i) * std::pow(p[1], j);
  return v;
}

std::array<BorderPoint, 6> make_border() {
  Eigen::Matrix<double, monomials, points> v;
  for (int k = 0; k < points; ++k) v.col(k) = values_at(triangle_rule[static_cast<std::size_t>(k)].at);
  const Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix<double, monomials, points>> solver(v);
  std::array<BorderPoint, 6> border{{{{1, 0, 0}, {}},
                                     {{0, 1, 0}, {}},
                                     {{0, 0, 1}, {}},
                                     {{0.5, 0.5, 0}, {}},
                                     {{0, 0.5, 0.5}, {}},
                                     {{0.5, 0, 0.5}, {}}}};
  for (BorderPoint& b : border) {
    const Eigen::Matrix<double, points, 1> w = solver.solve(values_at(b.at));
    for (int k = 0; k < points; ++k) b.prediction[static_cast<std::size_t>(k)] = w[k];
  }
  return border;
}

}  // namespace

const std::array<BorderPoint, 6>& triangle_border() {
  static const std::array<BorderPoint, 6> border = make_border();
  return border;
}

}  // namespace isopach
