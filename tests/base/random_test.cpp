// The random numbers are a named algorithm, and their distributions are tested as such: fixed seed, limits that a good
// generator passes with probability 0.999 or better.
#include "isopach/base/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

namespace isopach {
namespace {

constexpr std::size_t n = 200000;

template <class F>
std::vector<double> draw(F&& f) {
  std::vector<double> values(n);
  for (std::size_t i = 0; i < n; ++i) values[i] = f(i);
  return values;
}

double mean(const std::vector<double>& values, const std::function<double(double)>& f) {
  double sum = 0;
  for (const double v : values) sum += f(v);
  return sum / static_cast<double>(values.size());
}

/// √n times the largest distance between the empirical distribution and `cdf`; above 1.95 with probability 0.001.
double kolmogorov(std::vector<double> values, const std::function<double(double)>& cdf) {
  std::sort(values.begin(), values.end());
  double worst = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double p = cdf(values[i]), low = static_cast<double>(i) / n, high = static_cast<double>(i + 1) / n;
    worst = std::max({worst, p - low, high - p});
  }
  return worst * std::sqrt(static_cast<double>(n));
}

/// Correlation coefficient times √n: standard normal if the two are independent.
double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const auto same = [](double v) { return v; };
  const double ma = mean(a, same), mb = mean(b, same);
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - ma) * (b[i] - mb);
    aa += (a[i] - ma) * (a[i] - ma);
    bb += (b[i] - mb) * (b[i] - mb);
  }
  return ab / std::sqrt(aa * bb) * std::sqrt(static_cast<double>(a.size()));
}

/// The sequential generator as published.
std::uint64_t split_mix(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

TEST(Random, IsTheSplitMixSequenceOfItsStream) {
  std::uint64_t zero = 0;
  ASSERT_EQ(split_mix(zero), 0xe220a8397b1dcdafU);  // first number of seed 0, as published
  const std::uint64_t seed = 42, stream = 7;
  std::uint64_t state = seed;
  state = split_mix(state) + stream - 0x9e3779b97f4a7c15;
  std::uint64_t sequence = split_mix(state);
  const RandomStream random(seed, stream);
  for (std::uint64_t i = 0; i < 1000; ++i) EXPECT_EQ(random.bits(i), split_mix(sequence)) << i;
}

TEST(Random, EveryBitIsSetHalfTheTime) {
  const RandomStream random(1, 2);
  std::array<int, 64> ones{};
  for (std::size_t i = 0; i < n; ++i)
    for (int b = 0; b < 64; ++b) ones[static_cast<std::size_t>(b)] += static_cast<int>(random.bits(i) >> b & 1);
  for (const int count : ones) EXPECT_NEAR(count, n / 2.0, 4.5 * std::sqrt(n / 4.0));
}

TEST(Random, UniformIsUniform) {
  const RandomStream random(1, 3);
  const std::vector<double> u = draw([&](std::size_t i) { return random.uniform(i); });
  EXPECT_GE(*std::min_element(u.begin(), u.end()), 0);
  EXPECT_LT(*std::max_element(u.begin(), u.end()), 1);
  EXPECT_LT(kolmogorov(u, [](double x) { return x; }), 1.95);
  for (int k = 1; k <= 4; ++k) {
    const double sd = std::sqrt((1.0 / (2 * k + 1) - 1.0 / ((k + 1) * (k + 1))) / n);
    EXPECT_NEAR(mean(u, [k](double x) { return std::pow(x, k); }), 1.0 / (k + 1), 4 * sd) << "moment " << k;
  }
}

TEST(Random, NormalIsNormal) {
  const RandomStream random(1, 4);
  const std::vector<double> z = draw([&](std::size_t i) { return random.normal(i); });
  EXPECT_LT(kolmogorov(z, [](double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }), 1.95);
  const double moments[] = {0, 1, 0, 3}, variances[] = {1, 2, 15, 96};  // of z, z², z³, z⁴
  for (int k = 1; k <= 4; ++k)
    EXPECT_NEAR(mean(z, [k](double x) { return std::pow(x, k); }), moments[k - 1], 4 * std::sqrt(variances[k - 1] / n))
        << "moment " << k;
  const double beyond_3 = 0.0026997960632601890;
  EXPECT_NEAR(mean(z, [](double x) { return std::fabs(x) > 3 ? 1.0 : 0.0; }), beyond_3, 4 * std::sqrt(beyond_3 / n));
}

TEST(Random, NeighboursStreamsAndSeedsAreIndependent) {
  const RandomStream random(5, 6);
  const std::vector<double> u = draw([&](std::size_t i) { return random.uniform(i); });
  for (const std::size_t lag : {1U, 2U, 64U, 4096U})
    EXPECT_LT(std::fabs(correlation(u, draw([&](std::size_t i) { return random.uniform(i + lag); }))), 4) << lag;
  for (const RandomStream& other : {RandomStream(5, 7), RandomStream(6, 6), RandomStream(6, 5), RandomStream(5, 0)}) {
    EXPECT_LT(std::fabs(correlation(u, draw([&](std::size_t i) { return other.uniform(i); }))), 4);
    EXPECT_LT(std::fabs(correlation(draw([&](std::size_t i) { return random.normal(i); }),
                                    draw([&](std::size_t i) { return other.normal(i); }))),
              4);
  }
}

TEST(Random, PairsFillTheSquareEvenly) {
  const RandomStream x(9, 1), y(9, 2);
  constexpr std::size_t cells = 50;
  std::vector<double> counts(cells * cells);
  for (std::size_t i = 0; i < n; ++i)
    counts[static_cast<std::size_t>(x.uniform(i) * cells) * cells + static_cast<std::size_t>(y.uniform(i) * cells)] +=
        1;
  const double expected = static_cast<double>(n) / (cells * cells);
  double chi2 = 0;
  for (const double c : counts) chi2 += (c - expected) * (c - expected) / expected;
  const double freedom = cells * cells - 1;
  EXPECT_NEAR(chi2, freedom, 4 * std::sqrt(2 * freedom));
}

TEST(Random, ExtremeCountersAndSeedsAreAllowed) {
  const std::uint64_t last = ~std::uint64_t{0};
  for (const std::uint64_t seed : {std::uint64_t{0}, last})
    for (const std::uint64_t i : {std::uint64_t{0}, last / 2, last}) {
      const RandomStream random(seed, last);
      EXPECT_GE(random.uniform(i), 0);
      EXPECT_LT(random.uniform(i), 1);
      EXPECT_TRUE(std::isfinite(random.normal(i)));
    }
}

}  // namespace
}  // namespace isopach
