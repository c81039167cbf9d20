#include "isopach/base/fixed_sum.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "isopach/base/error.hpp"

namespace isopach {

namespace {

constexpr int bits_below_bound = 184, smallest_exponent = -1074;
constexpr int largest_exponent = 1024;  // of sums that are doubles; infinity is then beyond the range of summands

[[noreturn]] void refuse(const char* what) {
  throw Error(ExitCode::internal, std::string("an exact sum has ") + what + ": this is a defect, please report it");
}

[[noreturn]] void refuse_number() {
  throw InputError(
      "an area, a volume or an integral of squares is no finite number: coordinates or heights are too large, give "
      "them in a larger unit");
}

// Of x, which is not 0, finite, and not negative: size · 2^exponent.
struct Digits {
  std::uint64_t size;
  int exponent;
};
Digits digits_of(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const auto biased = static_cast<int>(bits >> 52);
  const std::uint64_t fraction = bits & 0xfffffffffffff;
  return biased == 0 ? Digits{fraction, smallest_exponent} : Digits{fraction | 0x10000000000000, biased - 1075};
}

// size / 2^digits to the nearest integer, the even one of two.
std::uint64_t without(std::uint64_t size, int digits) {
  if (digits > 54) return 0;
  const std::uint64_t kept = size >> digits, rest = size - (kept << digits), half = std::uint64_t{1} << (digits - 1);
  return kept + (rest > half || (rest == half && (kept & 1) != 0) ? 1 : 0);
}

}  // namespace

FixedScale::FixedScale(std::initializer_list<double> factors) {
  int exponent = 0;
  for (const double factor : factors) {
    if (!std::isfinite(factor)) refuse_number();
    int of_factor = smallest_exponent;
    if (factor > 0) (void)std::frexp(factor, &of_factor);
    exponent += of_factor;
  }
  exponent_ = std::max(std::min(exponent, largest_exponent) - bits_below_bound, smallest_exponent);
}

void FixedSum::add_rare(double x) {
  if (x == 0) return;
  if (!std::isfinite(x)) refuse_number();
  if (base_ == no_base) refuse("no scale");
  const auto [size, exponent] = digits_of(std::fabs(x));
  const int shift = exponent - (static_cast<int>(base_) - to_base);
  if (shift > 64 + 127 - 54) refuse("a summand beyond its bound");
  Int128 high = 0;
  std::uint64_t low = 0;
  if (shift >= 64) {
    high = Int128{size} << (shift - 64);
  } else if (shift >= 0) {
    const UInt128 on_grid = UInt128{size} << shift;
    low = static_cast<std::uint64_t>(on_grid);
    high = static_cast<Int128>(on_grid >> 64);
  } else {
    low = without(size, -shift);
  }
  if (x > 0) return add_words(high, low);
  add_words(~high + (low == 0 ? 1 : 0), ~low + 1);
}

void FixedSum::add_words(Int128 high, std::uint64_t low) {
  low_ += low;
  const Int128 carry = low_ < low ? 1 : 0;
  if (__builtin_add_overflow(high_, high, &high_)) refuse_sum();
  if (__builtin_add_overflow(high_, carry, &high_)) refuse_sum();
}

void FixedSum::combine(const FixedSum& other, Int128 high, std::uint64_t low) {
  if (other.base_ == no_base) return;
  if (base_ == no_base) base_ = other.base_;
  if (base_ != other.base_) refuse("parts of different scales");
  add_words(high, low);
}

void FixedSum::refuse_sum() { refuse("a value beyond its bound"); }

double FixedSum::value() const {
  const bool is_negative = high_ < 0;
  std::array<std::uint64_t, 3> word{low_, static_cast<std::uint64_t>(high_),
                                    static_cast<std::uint64_t>(static_cast<UInt128>(high_) >> 64)};
  if (is_negative) {
    std::uint64_t carry = 1;
    for (std::uint64_t& w : word) {
      w = ~w + carry;
      carry = carry != 0 && w == 0 ? 1 : 0;
    }
  }
  std::size_t top = 2;
  while (top > 0 && word[top] == 0) --top;
  if (word[top] == 0) return 0;
  // The first 64 bits from the leading one on; the last of them stands for all that follow, too.
  const int space = std::countl_zero(word[top]);
  std::uint64_t leading = word[top] << space, rest = 0;
  if (top > 0 && space > 0) leading |= word[top - 1] >> (64 - space);
  if (top > 0) rest = word[top - 1] << space;
  for (std::size_t k = 0; k + 1 < top; ++k) rest |= word[k];
  leading |= rest != 0 ? 1 : 0;
  const int exponent = static_cast<int>(base_) - to_base + 64 * static_cast<int>(top) - space;
  const double size = std::ldexp(static_cast<double>(without(leading, 11)), exponent + 11);
  return is_negative ? -size : size;
}

}  // namespace isopach
