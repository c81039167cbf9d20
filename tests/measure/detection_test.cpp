// Levels of detection: shares of a cell against derivatives and areas found otherwise, the significant part against the
// closed forms of the whole.
#include "isopach/measure/uncertainty/detection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "isopach/measure/volume/distribution.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

std::array<double, 3> values(Random& random) {
  const auto value = [&] {
    return random.below(4) == 0 ? static_cast<double>(random.below(3)) - 1 : random.uniform(-1, 1);
  };
  return {value(), value(), value()};
}

TEST(NormalDeviations, AreThoseOfTheTables) {
  EXPECT_NEAR(normal_deviations(0.95), 1.9599639845400543, 1e-14);
  EXPECT_NEAR(normal_deviations(0.99), 2.5758293035489004, 1e-14);
  EXPECT_NEAR(normal_deviations(std::erf(1 / std::numbers::sqrt2)), 1, 1e-14);
  EXPECT_NEAR(normal_deviations(0.5), 0.6744897501960817, 1e-14);
}

TEST(PositiveShares, AreTheDerivativesOfTheVolumeAbove) {
  Random random(401);
  for (int i = 0; i < 20000; ++i) {
    const auto s = values(random);
    const auto shares = positive_shares(s);
    EXPECT_NEAR(shares[0] + shares[1] + shares[2], 1 - area_below({1, s}, 0), 1e-14);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_GE(shares[k], 0);
      if (s[0] == 0 || s[1] == 0 || s[2] == 0) continue;
      auto more = s, less = s;
      more[k] += 1e-7, less[k] -= 1e-7;
      EXPECT_NEAR(shares[k], (split_volume({1, more}).above - split_volume({1, less}).above) / 2e-7, 2e-6);
    }
  }
}

TEST(Detect, IsTheVolumeOverTheLevelAndTheLevelBelowIt) {
  Random random(402);
  for (int i = 0; i < 20000; ++i) {
    const auto d = values(random);
    const double lod = random.uniform(0, 0.8), area = random.uniform(0.1, 3);
    const Detected found = detect(Cell{area, d}, {lod, lod, lod});
    const Cell over{area, {d[0] - lod, d[1] - lod, d[2] - lod}}, under{area, {d[0] + lod, d[1] + lod, d[2] + lod}};
    const double area_over = area - area_below(over, 0), area_under = area_below({area, d}, std::nextafter(-lod, -1));
    EXPECT_NEAR(found.area, area_over + area_under, 1e-13);
    EXPECT_NEAR(found.above, split_volume(over).above + lod * area_over, 1e-13);
    EXPECT_NEAR(found.below, split_volume(under).below + lod * area_under, 1e-13);
  }
}

TEST(Detect, FollowsALevelThatVaries) {
  // d = x, level 1 − x on the triangle (0,0), (1,0), (0,1): significant where x > 1/2.
  const Detected found = detect(Cell{0.5, {0, 1, 0}}, {1, 0, 1});
  EXPECT_NEAR(found.area, 0.125, 1e-15);
  EXPECT_NEAR(found.above, 1. / 12, 1e-15);  // ∫ x (1 − x) dx over [1/2, 1]
  EXPECT_EQ(found.below, 0);
}

TEST(Detect, HasTheRawGrossAtLevelZero) {
  Random random(403);
  for (int i = 0; i < 1000; ++i) {
    const Cell cell{1, values(random)};
    const Detected found = detect(cell, {0, 0, 0});
    EXPECT_NEAR(found.above, split_volume(cell).above, 1e-14);
    EXPECT_NEAR(found.below, split_volume(cell).below, 1e-14);
  }
}

}  // namespace
}  // namespace isopach::test
