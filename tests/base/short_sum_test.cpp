// Short sums against FixedSum: the same bits, or the word that they are none.
#include "isopach/base/short_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

struct Both {
  ShortSum brief;
  FixedSum exact;
};
Both sums_of(const std::vector<double>& values, const FixedScale& scale) {
  Both sums{{}, FixedSum(scale)};
  for (const double x : values) sums.brief.add(x, ShortSum::least_exact(scale)), sums.exact.add(x);
  return sums;
}

/// From `bound` down over `binades` orders of magnitude.
std::vector<double> summands(std::size_t n, double bound, std::size_t binades, Random& random) {
  std::vector<double> values;
  for (std::size_t i = 0; i < n; ++i)
    values.push_back(std::ldexp(random.uniform(0, 1) * bound, -static_cast<int>(random.below(binades))));
  return values;
}

TEST(ShortSum, HasTheBitsOfTheExactSumInAnyOrder) {
  Random random(1);
  for (const double bound : {1.0, 3e-9, 1e17, 1e-250, 1e290})
    for (const std::size_t n : {1, 2, 6, 40})
      for (int repeat = 0; repeat < 200; ++repeat) {
        std::vector<double> values = summands(n, bound, 40, random);
        values.push_back(0);
        const Both sums = sums_of(values, FixedScale{bound, static_cast<double>(n)});
        ASSERT_TRUE(sums.brief.is_exact());
        EXPECT_EQ(sums.brief.value(), sums.exact.value());
        std::reverse(values.begin(), values.end());
        EXPECT_EQ(sums_of(values, FixedScale{bound, static_cast<double>(n)}).brief.value(), sums.exact.value());
      }
}

TEST(ShortSum, IsExactOrSaysThatItIsNot) {
  Random random(2);
  int lost = 0, kept = 0;
  for (int repeat = 0; repeat < 20000; ++repeat) {
    const Both sums = sums_of(summands(1 + random.below(8), 1, 150, random), FixedScale{8});
    ++(sums.brief.is_exact() ? kept : lost);
    if (sums.brief.is_exact()) {
      ASSERT_EQ(sums.brief.value(), sums.exact.value());
    }
  }
  EXPECT_GT(lost, 1000);
  EXPECT_GT(kept, 1000);
}

TEST(ShortSum, IsNotExactForWhatTheGridRounds) {
  const FixedScale scale{1};
  const double least = ShortSum::least_exact(scale);
  for (const auto& [x, expected] : {std::pair{least, true}, {std::nextafter(least, 0), false}, {0.0, true}}) {
    ShortSum sum;
    sum.add(x, least);
    EXPECT_EQ(sum.is_exact(), expected) << x;
  }
}

TEST(ShortSum, OfWhatIsNoFiniteNumberIsNotExact) {
  for (const double x : {HUGE_VAL, std::nan(""), std::numeric_limits<double>::max()}) {
    ShortSum sum;
    sum.add(1, 0);
    sum.add(x, 0);
    sum.add(x, 0);
    EXPECT_FALSE(sum.is_exact()) << x;
    sum.add(1, 0);
    EXPECT_FALSE(sum.is_exact()) << x;
  }
}

}  // namespace
}  // namespace isopach::test
