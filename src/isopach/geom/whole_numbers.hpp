// Whole numbers that exact predicates are decided by: coordinates over one power of two, and integers wide enough for
// polynomials of them. Internal to geom/.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>

namespace isopach::whole {

__extension__ using Int128 = __int128;
__extension__ using UInt128 = unsigned __int128;

// A double as mantissa · 2^exponent with an odd (or zero) mantissa.
struct Dyadic {
  std::int64_t mantissa = 0;
  int exponent = 0;
};

inline Dyadic dyadic(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const int biased = static_cast<int>((bits >> 52) & 0x7ff);
  std::uint64_t fraction = bits & 0xfffffffffffffULL;
  if (biased != 0) fraction |= 1ULL << 52;
  if (fraction == 0) return {};
  const int zeros = std::countr_zero(fraction);
  const auto magnitude = static_cast<std::int64_t>(fraction >> zeros);
  const int exponent = (biased == 0 ? 1 : biased) - 1075 + zeros;
  return {(bits >> 63) != 0 ? -magnitude : magnitude, exponent};
}

// The coordinates of up to four points over one power of two: value = integer · 2^low.
template <std::size_t N>
struct CommonScale {
  std::array<Dyadic, N> parts;
  int low = 0;
  int width = 0;  // bits of the largest integer

  explicit CommonScale(const std::array<double, N>& values) {
    low = 5000;
    int high = -5000;
    for (std::size_t i = 0; i < N; ++i) {
      parts[i] = dyadic(values[i]);
      if (parts[i].mantissa == 0) continue;
      low = std::min(low, parts[i].exponent);
      const auto magnitude = static_cast<std::uint64_t>(parts[i].mantissa < 0 ? -parts[i].mantissa : parts[i].mantissa);
      high = std::max(high, parts[i].exponent + static_cast<int>(std::bit_width(magnitude)));
    }
    width = high > low ? high - low : 0;
  }
  [[nodiscard]] std::int64_t as_int64(std::size_t i) const {
    return parts[i].mantissa == 0 ? 0 : parts[i].mantissa * (std::int64_t{1} << (parts[i].exponent - low));
  }
};

// Integers of any width a polynomial of degree 6 in doubles can have (6 · 2100 bits): sign and magnitude, schoolbook.
// Reached only where filters and narrow integers do not do; speed is of no concern here.
class BigInt {
 public:
  static constexpr std::size_t capacity = 204;

  BigInt() = default;
  BigInt(std::int64_t mantissa, int shift) {
    if (mantissa == 0) return;
    negative_ = mantissa < 0;
    const auto magnitude = static_cast<std::uint64_t>(negative_ ? -mantissa : mantissa);
    const auto word = static_cast<std::size_t>(shift / 64);
    const int bit = shift % 64;
    limb_[word] = magnitude << bit;
    if (bit != 0) limb_[word + 1] = magnitude >> (64 - bit);
    size_ = word + 2;
    trim();
  }
  friend BigInt operator*(const BigInt& a, const BigInt& b) {
    BigInt r;
    if (a.size_ == 0 || b.size_ == 0) return r;
    assert(a.size_ + b.size_ <= capacity);
    for (std::size_t i = 0; i < a.size_; ++i) {
      UInt128 carry = 0;
      for (std::size_t j = 0; j < b.size_; ++j) {
        carry += static_cast<UInt128>(a.limb_[i]) * b.limb_[j] + r.limb_[i + j];
        r.limb_[i + j] = static_cast<std::uint64_t>(carry);
        carry >>= 64;
      }
      r.limb_[i + b.size_] = static_cast<std::uint64_t>(carry);
    }
    r.size_ = a.size_ + b.size_;
    r.negative_ = a.negative_ != b.negative_;
    r.trim();
    return r;
  }
  friend BigInt operator+(const BigInt& a, const BigInt& b) {
    if (a.negative_ == b.negative_) {
      BigInt r = add_magnitudes(a, b);
      r.negative_ = a.negative_;
      return r;
    }
    const int order = compare_magnitudes(a, b);
    if (order == 0) return {};
    BigInt r = order > 0 ? subtract_magnitudes(a, b) : subtract_magnitudes(b, a);
    r.negative_ = order > 0 ? a.negative_ : b.negative_;
    return r;
  }
  friend BigInt operator-(const BigInt& a, BigInt b) {
    b.negative_ = !b.negative_;
    return a + b;
  }
  [[nodiscard]] int sign() const { return size_ == 0 ? 0 : (negative_ ? -1 : 1); }
  /// The value times 2^exponent; the three upper words carry more bits than a double.
  [[nodiscard]] double scaled(int exponent) const {
    double value = 0;
    for (std::size_t i = size_; i-- > 0 && i + 3 >= size_;)
      value += std::ldexp(static_cast<double>(limb_[i]), static_cast<int>(64 * i) + exponent);
    return negative_ ? -value : value;
  }

 private:
  void trim() {
    while (size_ > 0 && limb_[size_ - 1] == 0) --size_;
  }
  static BigInt add_magnitudes(const BigInt& a, const BigInt& b) {
    BigInt r;
    r.size_ = std::max(a.size_, b.size_) + 1;
    assert(r.size_ <= capacity);
    UInt128 carry = 0;
    for (std::size_t i = 0; i < r.size_; ++i) {
      carry += static_cast<UInt128>(a.limb_[i]) + b.limb_[i];
      r.limb_[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    r.trim();
    return r;
  }
  static BigInt subtract_magnitudes(const BigInt& a, const BigInt& b) {  // |a| > |b|
    BigInt r;
    r.size_ = a.size_;
    std::uint64_t borrow = 0;
    for (std::size_t i = 0; i < a.size_; ++i) {
      const UInt128 take = static_cast<UInt128>(b.limb_[i]) + borrow;
      borrow = a.limb_[i] < take ? 1 : 0;
      r.limb_[i] = static_cast<std::uint64_t>(static_cast<UInt128>(a.limb_[i]) - take);
    }
    r.trim();
    return r;
  }
  static int compare_magnitudes(const BigInt& a, const BigInt& b) {
    if (a.size_ != b.size_) return a.size_ > b.size_ ? 1 : -1;
    for (std::size_t i = a.size_; i-- > 0;)
      if (a.limb_[i] != b.limb_[i]) return a.limb_[i] > b.limb_[i] ? 1 : -1;
    return 0;
  }

  std::array<std::uint64_t, capacity> limb_{};
  std::size_t size_ = 0;
  bool negative_ = false;
};

template <std::size_t N>
BigInt big(const CommonScale<N>& scale, std::size_t i) {
  return {scale.parts[i].mantissa, scale.parts[i].mantissa == 0 ? 0 : scale.parts[i].exponent - scale.low};
}

}  // namespace isopach::whole
