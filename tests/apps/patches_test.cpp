// Patches: planes are taken off to rounding, degenerate places keep their degrees of freedom, the median of the
// variances is that of the noise.
#include "isopach/apps/patches.hpp"

#include <gtest/gtest.h>

#include "isopach/base/median.hpp"
#include "isopach/base/random.hpp"

namespace isopach {
namespace {

PatchValues<2> places(std::uint64_t seed, double scale) {
  const RandomStream random(seed, 1);
  PatchValues<2> xy;
  for (int k = 0; k < patch; ++k) {
    const auto i = static_cast<std::uint64_t>(2 * k);
    xy.row(k) << 1e6 + scale * random.uniform(i), -4e6 + scale * random.uniform(i + 1);
  }
  return xy;
}

TEST(Patches, PlanesAreTakenOffAndRoughnessStays) {
  const PatchValues<2> xy = places(3, 2);
  PatchValues<2> values;
  values.col(0) = 0.3 * xy.col(0) - 0.2 * xy.col(1);
  values.col(1) = values.col(0);
  values(5, 1) += 1;
  EXPECT_EQ(take_off_plane(xy, values), 13);
  EXPECT_LT(values.col(0).cwiseAbs().maxCoeff(), 1e-8);
  // The residuals of a plane of least squares have no mean and no slope.
  EXPECT_NEAR(values.col(1).sum(), 0, 1e-8);
  EXPECT_NEAR(values.col(1).dot(xy.col(0).array().matrix() - PatchValues<1>::Constant(xy.col(0).mean())), 0, 1e-7);
  EXPECT_GT(values(5, 1), 0.5);
}

TEST(Patches, PlacesOnALineOrInOne) {
  PatchValues<2> line = places(3, 1);
  line.col(1) = PatchValues<1>::Constant(7);
  PatchValues<1> values = 2 * line.col(0);
  EXPECT_EQ(take_off_plane(line, values), 14);
  EXPECT_LT(values.cwiseAbs().maxCoeff(), 1e-8);
  const PatchValues<2> one = PatchValues<2>::Constant(3);
  for (int k = 0; k < patch; ++k) values[k] = k;
  EXPECT_EQ(take_off_plane(one, values), 15);
  EXPECT_NEAR(values[0], -7.5, 1e-12);
}

TEST(Patches, TheMedianVarianceIsThatOfTheNoise) {
  const RandomStream random(5, 2);
  std::vector<double> variances;
  for (std::uint64_t p = 0; p < 20000; ++p) {
    const PatchValues<2> xy = places(p, 2);
    PatchValues<1> values = 0.4 * xy.col(0);
    for (int k = 0; k < patch; ++k) values[k] += 0.1 * random.normal(patch * p + static_cast<std::uint64_t>(k));
    if (p % 5 == 0) values[3] += 100;  // a fifth of the patches has an outlier
    variances.push_back(patch_variance(xy, values));
  }
  std::vector<double> clean;
  for (std::size_t p = 0; p < variances.size(); ++p)
    if (p % 5 != 0) clean.push_back(variances[p]);
  EXPECT_NEAR(std::sqrt(median(clean)), 0.1, 0.001);
  EXPECT_NEAR(std::sqrt(median(variances)), 0.1, 0.01);
}

}  // namespace
}  // namespace isopach
