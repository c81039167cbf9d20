// Patches of 16 neighbouring places: what of the values there a plane, or a quadratic surface, does not explain.
#pragma once
#include <Eigen/Dense>

#include "isopach/geom/vec.hpp"

namespace isopach {

inline constexpr int patch = 16;

template <int columns>
using PatchValues = Eigen::Matrix<double, patch, columns>;

/// Takes the plane of least squares off each column of `values`, which belong to the places `xy` (one row each).
/// Gives the degrees of freedom that are left: 13, or more where the places lie on a line (14) or are one (15).
template <int columns>
int take_off_plane(const PatchValues<2>& xy, PatchValues<columns>& values) {
  PatchValues<3> plane;
  plane.col(0).setOnes();
  plane.col(1) = xy.col(0).array() - xy.col(0).mean();
  plane.col(2) = xy.col(1).array() - xy.col(1).mean();
  const Eigen::ColPivHouseholderQR<PatchValues<3>> qr(plane);
  values -= plane * qr.solve(values).eval();
  return patch - static_cast<int>(qr.rank());
}

/// Takes the quadratic surface of least squares off each column of `values`: what a patch shows of waves much longer
/// than itself is curvature, and that is none of its detail. Test: Scanners.TheCurvatureOfLongWavesIsNoDetail.
template <int columns>
void take_off_quadratic(const PatchValues<2>& xy, PatchValues<columns>& values) {
  PatchValues<2> at = xy.rowwise() - xy.colwise().mean();
  if (const double reach = at.cwiseAbs().maxCoeff(); reach > 0) at /= reach;
  PatchValues<6> quadratic;
  quadratic.col(0).setOnes();
  quadratic.col(1) = at.col(0), quadratic.col(2) = at.col(1);
  quadratic.col(3) = at.col(0).cwiseProduct(at.col(0));
  quadratic.col(4) = at.col(0).cwiseProduct(at.col(1));
  quadratic.col(5) = at.col(1).cwiseProduct(at.col(1));
  const Eigen::ColPivHouseholderQR<PatchValues<6>> qr(quadratic);
  values -= quadratic * qr.solve(values).eval();
}

/// Variance of `values` about their plane, so scaled that the median over many patches is that of normal noise: the
/// median of chi² over its degrees of freedom is (1 − 2/(9 n))³ [Wilson1931].
inline double patch_variance(const PatchValues<2>& xy, PatchValues<1> values) {
  const int freedom = take_off_plane(xy, values);
  const double root = 1 - 2.0 / (9 * freedom);
  return values.squaredNorm() / (freedom * root * root * root);
}

}  // namespace isopach
