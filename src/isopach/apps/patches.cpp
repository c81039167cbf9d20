#include "isopach/apps/patches.hpp"

#include <Eigen/QR>
#include <cmath>

namespace isopach {

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
template int take_off_plane<1>(const PatchValues<2>&, PatchValues<1>&);
template int take_off_plane<2>(const PatchValues<2>&, PatchValues<2>&);

void take_off_quadratic(const PatchValues<2>& xy, PatchValues<3>& values) {
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

double patch_variance(const PatchValues<2>& xy, PatchValues<1> values) {
  const int freedom = take_off_plane(xy, values);
  const double root = 1 - 2.0 / (9 * freedom);
  return values.squaredNorm() / (freedom * root * root * root);
}

}  // namespace isopach
