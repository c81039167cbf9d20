// ShortSum: what FixedSum gives for a few summands, in 16 bytes instead of 48: for arrays of sums, one a node.
//
// The sum is kept as two doubles whose exact sum it is [Knuth1997, 4.2.2]: each addition is exact unless the rest needs
// more than 53 bits, which takes summands that lie 52 binary orders of magnitude apart. Then the sum says so, and so it
// does for a summand that the grid of a FixedSum would round; whoever asked adds these up again, as FixedSums. As long
// as it is exact, value() is the double nearest to it: the same bits as FixedSum::value(), in whatever order.
// Test: tests/base/short_sum_test.cpp (against FixedSum).
#pragma once
#include <cmath>
#include <limits>

#include "isopach/base/fixed_sum.hpp"

namespace isopach {

class ShortSum {
 public:
  /// The summands that are exact on a grid: 0, and finite ones that are not smaller than this.
  [[nodiscard]] static double least_exact(const FixedScale& scale) { return std::ldexp(1.0, scale.exponent() + 52); }

  /// x is 0 or more. `least`: least_exact() of the scale.
  void add(double x, double least) {
    const double sum = sum_ + x, part = sum - sum_;
    const double error = (sum_ - (sum - part)) + (x - part);
    const double rest = rest_ + error, rest_part = rest - rest_;
    const double lost = (rest_ - (rest - rest_part)) + (error - rest_part);
    const bool is_exact = lost == 0 && (x >= least || x == 0);  // false if any of these is no number
    sum_ = sum;
    rest_ = is_exact ? rest : std::numeric_limits<double>::quiet_NaN();
  }
  [[nodiscard]] bool is_exact() const { return !std::isnan(rest_); }
  /// Meaningless unless is_exact().
  [[nodiscard]] double value() const { return sum_ + rest_; }

 private:
  double sum_ = 0, rest_ = 0;
};

}  // namespace isopach
