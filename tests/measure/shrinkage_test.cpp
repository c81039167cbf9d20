// Shrinkage: pure noise goes, a step that stands out stays where it is, and symmetries hold to the last bit.
#include "isopach/measure/uncertainty/shrinkage.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

using Values = std::vector<double>;

Values noise(std::size_t n, std::uint64_t seed, double deviation) {
  Random random(seed);
  Values v(n);
  for (double& x : v) x = deviation * random.bell();
  return v;
}

TEST(Shrink, TakesNoiseAway) {
  for (const std::size_t n : {1000UL, 4096UL, 20001UL}) {
    const Values v = noise(n, n, 0.5);
    const Array<double> found = shrink(v, Values(n, 1), Values(n, 0.25), noise(n, n + 1, 0.5), {});
    double largest = 0;
    for (const double x : found) largest = std::max(largest, std::fabs(x));
    EXPECT_LT(largest, 4 * 0.5 / std::sqrt(static_cast<double>(n)));  // the mean, that always stays
  }
}

TEST(Shrink, KeepsWhatStandsOut) {
  const std::size_t n = 4096;
  Values v = noise(n, 1, 0.1);
  for (std::size_t i = 1024; i < 2048; ++i) v[i] += 1;
  const Array<double> found = shrink(v, Values(n, 1), Values(n, 0.01), noise(n, 2, 0.1), {});
  for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(found[i], i >= 1024 && i < 2048 ? 1 : 0, 0.06);
}

TEST(Shrink, GivesTheValuesBackWithoutVariance) {
  const std::size_t n = 777;
  const Values v = noise(n, 3, 1);
  const Array<double> found = shrink(v, Values(n, 2), Values(n, 0), Values(n, 0), {});
  for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(found[i], v[i], 1e-13);
}

TEST(Shrink, AllowsForCorrelationByTheSample) {
  // Runs of 16 equal values: as independent ones their means would stand out.
  const std::size_t n = 16384;
  Values v = noise(n, 4, 1), sample = noise(n, 5, 1);
  for (std::size_t i = 0; i < n; ++i) v[i] = v[i - i % 16], sample[i] = sample[i - i % 16];
  const Array<double> with = shrink(v, Values(n, 1), Values(n, 1), sample, {});
  double squares = 0;
  for (const double x : with) squares += x * x;
  EXPECT_LT(std::sqrt(squares / static_cast<double>(n)), 0.1);
}

TEST(Shrink, ChangesSignsWithTheValuesAndIgnoresWeightZero) {
  const std::size_t n = 1000;
  Values v = noise(n, 6, 1), weight(n, 1);
  for (std::size_t i = 0; i < n; i += 3) weight[i] = 0;
  for (std::size_t i = 500; i < n; ++i) v[i] += 10;
  Values minus = v, changed = v;
  for (double& x : minus) x = -x;
  for (std::size_t i = 0; i < n; i += 3) changed[i] = 1e6;
  const Values variance(n, 1), sample = noise(n, 7, 1);
  const Array<double> found = shrink(v, weight, variance, sample, {});
  EXPECT_EQ(found, shrink(changed, weight, variance, sample, {}));
  const Array<double> mirrored = shrink(minus, weight, variance, sample, {});
  for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(mirrored[i], -found[i]);
  EXPECT_TRUE(shrink({}, {}, {}, {}, {}).empty());
}

}  // namespace
}  // namespace isopach::test
