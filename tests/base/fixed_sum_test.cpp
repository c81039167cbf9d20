// Exact sums against sums of integers.
#include "isopach/base/fixed_sum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "isopach/base/error.hpp"
#include "tests/support/exact.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

constexpr double largest = std::numeric_limits<double>::max(), smallest = std::numeric_limits<double>::denorm_min();

/// Both signs, `binades` orders of magnitude below `bound`.
std::vector<double> summands(std::size_t n, double bound, std::size_t binades, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> values;
  for (std::size_t i = 0; i < n; ++i)
    values.push_back(std::ldexp(random.uniform(-1, 1) * bound, -static_cast<int>(random.below(binades))));
  return values;
}

FixedSum sum_of(const std::vector<double>& values, const FixedScale& scale) {
  FixedSum sum(scale);
  for (const double x : values) sum.add(x);
  return sum;
}

ExactSum exact(const std::vector<double>& values) {
  ExactSum sum;
  for (const double x : values) sum.add(x);
  return sum;
}

TEST(FixedSum, IsTheDoubleNearestToTheSum) {
  std::uint64_t seed = 1;
  for (const double bound : {1.0, 3e-9, 1e17, 1e-300, 1e290, 5e-324})
    for (const std::size_t binades : {1, 20, 60, 78})
      for (const std::size_t n : {1, 2, 3, 1000}) {
        const std::vector<double> values = summands(n, bound, binades, seed++);
        const double found = sum_of(values, FixedScale{bound, static_cast<double>(n)}).value();
        EXPECT_TRUE(exact(values).rounds_to(found)) << bound << " " << binades << " " << n << " " << found;
      }
}

TEST(FixedSum, OfTiesIsTheEvenOne) {
  for (const double sign : {1.0, -1.0})
    for (const auto& [x, y, expected] : {std::array{1.0, 0x1p-53, 1.0},
                                         {1 + 0x1p-52, 0x1p-53, 1 + 0x1p-51},
                                         {1.0, 0x1.8p-53, 1 + 0x1p-52},
                                         {0x1p53, 1.0, 0x1p53}}) {
      FixedSum sum(FixedScale{0x1p60});
      sum.add(sign * x), sum.add(sign * y);
      EXPECT_EQ(sum.value(), sign * expected);
      sum.add(sign * 0x1p-100);  // no tie any more
      EXPECT_EQ(sum.value() > sign * x, sign > 0);
    }
}

TEST(FixedSum, KeepsWhatCancels) {
  FixedSum sum(FixedScale{1e20});
  for (const double x : {1e20, 1.0, -1e20, 0x1p-40}) sum.add(x);
  EXPECT_EQ(sum.value(), 1 + 0x1p-40);
  sum.add(-1), sum.add(-0x1p-40);
  EXPECT_EQ(sum.value(), 0);
}

TEST(FixedSum, HoldsForBoundsThatAreFarTooLarge) {
  const std::vector<double> values = summands(3000, 1, 30, 7);
  for (const double factor : {1.0, 1e6, 1e12, 1e20})
    EXPECT_TRUE(exact(values).rounds_to(sum_of(values, FixedScale{3000, factor}).value())) << factor;
  // And where the grid shows: off by half a step for each summand, no more.
  for (const double factor : {1e40, 1e45, 1e50}) {
    const FixedScale scale{3000, factor};
    const ExactSum sum = exact(values);
    EXPECT_LE(sum.off_by(sum_of(values, scale).value(), scale.exponent()), 1500 + 1) << factor;
    EXPECT_FALSE(sum.rounds_to(sum_of(values, scale).value())) << factor;
  }
}

TEST(FixedSum, DoesNotDependOnTheOrderOrOnHowPartsArePutTogether) {
  std::vector<double> values = summands(5000, 1, 120, 8);  // some below the grid
  const FixedScale scale{5000};
  const double expected = sum_of(values, scale).value();
  Random random(9);
  for (int round = 0; round < 20; ++round) {
    random.shuffle(values);
    std::vector<FixedSum> parts(1 + random.below(40), FixedSum(scale));
    for (const double x : values) parts[random.below(parts.size())].add(x);
    FixedSum sum;  // takes its grid from the first
    for (const FixedSum& part : parts) sum.add(part);
    EXPECT_EQ(sum.value(), expected);
  }
}

TEST(FixedSum, ChangesItsSignWithTheSummands) {
  std::vector<double> values = summands(1000, 1, 150, 10);
  const double expected = sum_of(values, FixedScale{1000}).value();
  for (double& x : values) x = -x;
  EXPECT_EQ(sum_of(values, FixedScale{1000}).value(), -expected);
}

TEST(FixedSum, SubtractsAndAddsSumsWithOneRounding) {
  const std::vector<double> a = summands(1000, 1, 60, 11), b = summands(1000, 1, 60, 12);
  const FixedScale scale{1000};
  ExactSum less = exact(a), more = exact(a);
  for (const double x : b) less.subtract(x), more.add(x);
  EXPECT_TRUE(less.rounds_to(difference(sum_of(a, scale), sum_of(b, scale))));
  EXPECT_TRUE(more.rounds_to(total(sum_of(a, scale), sum_of(b, scale))));
  EXPECT_EQ(difference(sum_of(a, scale), sum_of(a, scale)), 0);
  std::vector<double> below = summands(500, 1e-50, 20, 13);  // words below those of usual summands
  EXPECT_EQ(difference(FixedSum(scale), sum_of(below, scale)), -sum_of(below, scale).value());
}

TEST(FixedSum, ReachesFromTheSmallestDoubleToTheLargest) {
  FixedSum least(FixedScale{smallest});
  least.add(smallest), least.add(smallest), least.add(-3 * smallest);
  EXPECT_EQ(least.value(), -smallest);
  FixedSum most(FixedScale{largest, 2});
  most.add(largest), most.add(-largest), most.add(largest);
  EXPECT_EQ(most.value(), largest);
  FixedSum beyond(FixedScale{largest, 4});
  beyond.add(largest), beyond.add(largest);
  EXPECT_EQ(beyond.value(), HUGE_VAL) << "as doubles round";
  FixedSum back(FixedScale{1e300, 1e300});  // a bound beyond all doubles
  back.add(1e300), back.add(1e290);
  EXPECT_EQ(back.value(), 1e300 + 1e290);
  EXPECT_EQ(FixedSum(FixedScale{0}).value(), 0);
  EXPECT_EQ(FixedSum().value(), 0);
}

TEST(FixedSum, RefusesWhatItCannotHold) {
  FixedSum sum(FixedScale{1.0});
  for (const double x : {HUGE_VAL, -HUGE_VAL, std::nan("")}) EXPECT_THROW(sum.add(x), InputError) << x;
  for (const double bound : {HUGE_VAL, std::nan("")}) EXPECT_THROW((void)FixedScale({2.0, bound}), InputError);
  for (const double x : {256.0, -256.0, 1e30}) EXPECT_THROW(sum.add(x), Error) << "one summand beyond 128 times";
  EXPECT_EQ(sum.value(), 0) << "what was refused is not in it";
  EXPECT_THROW(FixedSum().add(1), Error) << "no grid";
  EXPECT_THROW(sum.add(FixedSum(FixedScale{4.0})), Error) << "another grid";
  for (const double sign : {1.0, -1.0}) {
    FixedSum full(FixedScale{1.0});
    const auto fill = [&] {
      for (int i = 0; i < 1000; ++i) full.add(sign);
    };
    EXPECT_THROW(fill(), Error) << "more than the bound, many times over";
    FixedSum half(FixedScale{1.0});
    for (int i = 0; i < 100; ++i) half.add(sign);
    EXPECT_EQ(half.value(), 100 * sign);
    half.add(half);
    EXPECT_EQ(half.value(), 200 * sign);
    EXPECT_THROW(half.add(half), Error);
  }
}

}  // namespace
}  // namespace isopach::test
