// FixedSum: a sum of doubles that is the same, to the last bit, in whatever order they are added and however partial
// sums are put together. Each summand is rounded once to a grid of binary fractions; integers on that grid are added,
// which is exact. (After the long accumulators of [Kulisch2011], of which this keeps the part that a sum can reach.)
//
// The grid comes from a bound B on the sum of the absolute values of all summands, whatever their number and order.
// Let B < 2^e, or e = 1024 if B is beyond all doubles. A step is 2^(e − 184), never finer
// than 2^−1074, the smallest double; integers have 192 bits.
//
//   Headroom. A summand is at most B in size, and rounding moves it by half a step at most. With n < 2^64 summands any
//   partial sum is below 2^e + 2^63 · 2^(e − 184) < 2^(e + 1) in size, and the integers reach to 2^(e + 7): 64 times
//   the bound. If the bound is kept there is no overflow; if it is not, the addition that would overflow throws
//   instead, as does a summand that is not finite, or beyond the range by itself.
//   Error. Summands of size 2^(e − 131) and more lie on the grid as they are: their 53 bits end at 2^(e − 184) or
//   before. Smaller ones are off by 2^(e − 185) at most. So the sum that value() rounds, once and to the nearest
//   double, is exact, or off by n · 2^(e − 185): with n below 2^33 less than half an ulp of any result above
//   2^(e − 98). Bounds may be far too large, by a factor of 10^20, and the result is still right to the last bit.
//
// Cost of an addition: 2.5 ns where a compensated one takes 1.6. Test:
// tests/base/fixed_sum_test.cpp (against whole numbers).
#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <initializer_list>

namespace isopach {

/// The grid of a sum.
class FixedScale {
 public:
  /// For summands whose absolute values add up to at most the product of `factors`, which itself may be larger than the
  /// largest double. Factors are 0 or more; InputError for one that is not finite.
  explicit FixedScale(std::initializer_list<double> factors);

  /// A step is 2^exponent().
  [[nodiscard]] int exponent() const { return exponent_; }

 private:
  int exponent_;
};

class FixedSum {
 public:
  /// An empty sum, which takes the grid of the first sum added to it. It cannot take a summand: it has no grid.
  FixedSum() = default;
  explicit FixedSum(const FixedScale& scale) : base_(static_cast<std::uint64_t>(scale.exponent() + to_base)) {}

  /// InputError for a summand that is not finite; Error (internal) for one, or a sum, beyond the range of the grid.
  /// Inlined always: compilers think it too long, and a call would cost as much as it does.
  [[gnu::always_inline]] void add(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const std::uint64_t shift = (bits >> 52 & 0x7ff) - base_;
    if (shift > 63) [[unlikely]]
      return add_rare(x);  // 0, small, or nearly as large as the bound
    const std::uint64_t size = (bits & 0xfffffffffffff) | 0x10000000000000;
    const UInt128 summand = UInt128{size >> 1 >> (63 - shift)} << 64 | size << shift;
    const bool overflows = static_cast<std::int64_t>(bits) < 0
                               ? __builtin_sub_overflow(high_, static_cast<Int128>(summand), &high_)
                               : __builtin_add_overflow(high_, static_cast<Int128>(summand), &high_);
    if (overflows) [[unlikely]]
      refuse_sum();
  }
  /// Sums on one grid, or empty ones; Error (internal) if the grids differ.
  void add(const FixedSum& other) { combine(other, other.high_, other.low_); }
  void subtract(const FixedSum& other) {
    const std::uint64_t low = ~other.low_ + 1;
    combine(other, ~other.high_ + (low == 0 ? 1 : 0), low);
  }

  /// The sum as four words, to be kept in a file; and the sum that they are of.
  [[nodiscard]] std::array<std::uint64_t, 4> words() const {
    return {static_cast<std::uint64_t>(static_cast<UInt128>(high_) >> 64), static_cast<std::uint64_t>(high_), low_,
            base_};
  }
  [[nodiscard]] static FixedSum of_words(const std::array<std::uint64_t, 4>& words) {
    FixedSum sum;
    sum.high_ = static_cast<Int128>(UInt128{words[0]} << 64 | words[1]);
    sum.low_ = words[2], sum.base_ = words[3];
    return sum;
  }

  /// The double nearest to the sum, the even one of two; 0 for an empty sum.
  [[nodiscard]] double value() const;

 private:
  __extension__ using Int128 = __int128;
  __extension__ using UInt128 = unsigned __int128;

  // Biased exponent of a double whose last bit has the weight of the last bit of high_.
  static constexpr int to_base = 1075 + 64;
  static constexpr std::uint64_t no_base = 1 << 20;

  void add_rare(double x);
  void add_words(Int128 high, std::uint64_t low);
  void combine(const FixedSum& other, Int128 high, std::uint64_t low);
  [[noreturn]] static void refuse_sum();

  Int128 high_ = 0;        // with low_ behind it one integer of 192 bits, two's complement
  std::uint64_t low_ = 0;  // bits of summands far below the bound; 0 in most sums
  std::uint64_t base_ = no_base;
};

/// a − b, rounded once.
[[nodiscard]] inline double difference(FixedSum a, const FixedSum& b) {
  a.subtract(b);
  return a.value();
}
/// a + b, rounded once.
[[nodiscard]] inline double total(FixedSum a, const FixedSum& b) {
  a.add(b);
  return a.value();
}

}  // namespace isopach
