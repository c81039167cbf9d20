#include "isopach/geom/predicates.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace isopach {

namespace {

__extension__ using Int128 = __int128;
__extension__ using UInt128 = unsigned __int128;

// A double as mantissa · 2^exponent with an odd (or zero) mantissa.
struct Dyadic {
  std::int64_t mantissa = 0;
  int exponent = 0;
};

Dyadic dyadic(double value) {
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

int sign_of(Int128 x) { return x > 0 ? 1 : (x < 0 ? -1 : 0); }

// 256-bit two's complement: enough for three products of two 125-bit numbers.
struct Int256 {
  std::array<std::uint64_t, 4> limb{};

  static Int256 product(Int128 a, Int128 b) {
    const bool negative = (a < 0) != (b < 0);
    const UInt128 x = a < 0 ? -static_cast<UInt128>(a) : static_cast<UInt128>(a);
    const UInt128 y = b < 0 ? -static_cast<UInt128>(b) : static_cast<UInt128>(b);
    const auto x0 = static_cast<std::uint64_t>(x), x1 = static_cast<std::uint64_t>(x >> 64);
    const auto y0 = static_cast<std::uint64_t>(y), y1 = static_cast<std::uint64_t>(y >> 64);
    const UInt128 low = static_cast<UInt128>(x0) * y0;
    const UInt128 cross1 = static_cast<UInt128>(x0) * y1;
    const UInt128 cross2 = static_cast<UInt128>(x1) * y0;
    const UInt128 high = static_cast<UInt128>(x1) * y1;
    const UInt128 middle = (low >> 64) + static_cast<std::uint64_t>(cross1) + static_cast<std::uint64_t>(cross2);
    const UInt128 top = high + (cross1 >> 64) + (cross2 >> 64) + (middle >> 64);
    Int256 r;
    r.limb = {static_cast<std::uint64_t>(low), static_cast<std::uint64_t>(middle), static_cast<std::uint64_t>(top),
              static_cast<std::uint64_t>(top >> 64)};
    if (negative) r.negate();
    return r;
  }
  void negate() {
    UInt128 carry = 1;
    for (auto& l : limb) {
      carry += static_cast<std::uint64_t>(~l);
      l = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
  }
  void add(const Int256& o) {
    UInt128 carry = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      carry += static_cast<UInt128>(limb[i]) + o.limb[i];
      limb[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
  }
  [[nodiscard]] int sign() const {
    if ((limb[3] >> 63) != 0) return -1;
    return (limb[0] | limb[1] | limb[2] | limb[3]) != 0 ? 1 : 0;
  }
};

// Integers of any width a polynomial of degree 4 in doubles can have (4 · 2100 bits): sign and magnitude, schoolbook.
// Reached only by points whose coordinates span more than 61 bits; speed is of no concern here.
class BigInt {
 public:
  static constexpr std::size_t capacity = 140;

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

BigInt twice_area_wide(const CommonScale<6>& s) {
  const BigInt left = (big(s, 0) - big(s, 4)) * (big(s, 3) - big(s, 5));
  const BigInt right = (big(s, 1) - big(s, 5)) * (big(s, 2) - big(s, 4));
  return left - right;
}

Int128 twice_area_narrow(const CommonScale<6>& s) {
  const std::int64_t cx = s.as_int64(4), cy = s.as_int64(5);
  const Int128 left = static_cast<Int128>(s.as_int64(0) - cx) * (s.as_int64(3) - cy);
  const Int128 right = static_cast<Int128>(s.as_int64(1) - cy) * (s.as_int64(2) - cx);
  return left - right;
}

int in_circle_wide(const CommonScale<8>& s) {
  std::array<BigInt, 3> x, y, lift;
  for (std::size_t i = 0; i < 3; ++i) {
    x[i] = big(s, 2 * i) - big(s, 6);
    y[i] = big(s, 2 * i + 1) - big(s, 7);
    lift[i] = x[i] * x[i] + y[i] * y[i];
  }
  BigInt det;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    det = det + lift[i] * (x[j] * y[k] - x[k] * y[j]);
  }
  return det.sign();
}

}  // namespace

namespace exact {

int orientation(const Point2& a, const Point2& b, const Point2& c) {
  const CommonScale<6> s({a.x, a.y, b.x, b.y, c.x, c.y});
  return s.width > 61 ? twice_area_wide(s).sign() : sign_of(twice_area_narrow(s));
}

double twice_area(const Point2& a, const Point2& b, const Point2& c) {
  const CommonScale<6> s({a.x, a.y, b.x, b.y, c.x, c.y});
  if (s.width > 61) return twice_area_wide(s).scaled(2 * s.low);
  return std::ldexp(static_cast<double>(twice_area_narrow(s)), 2 * s.low);
}

int in_circle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const CommonScale<8> s({a.x, a.y, b.x, b.y, c.x, c.y, d.x, d.y});
  if (s.width > 61) return in_circle_wide(s);
  const std::int64_t dx = s.as_int64(6), dy = s.as_int64(7);
  const Int128 ax = s.as_int64(0) - dx, ay = s.as_int64(1) - dy;
  const Int128 bx = s.as_int64(2) - dx, by = s.as_int64(3) - dy;
  const Int128 cx = s.as_int64(4) - dx, cy = s.as_int64(5) - dy;
  Int256 det = Int256::product(ax * ax + ay * ay, bx * cy - cx * by);
  det.add(Int256::product(bx * bx + by * by, cx * ay - ax * cy));
  det.add(Int256::product(cx * cx + cy * cy, ax * by - bx * ay));
  return det.sign();
}

}  // namespace exact

bool tie_is_inside(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  // Lifting d takes it out of the circle; lifting a corner raises the plane over d where d's weight of it is positive.
  const Point2& ab = lexicographic_less(a, b) ? b : a;
  const Point2& cd = lexicographic_less(c, d) ? d : c;
  const Point2& greatest = lexicographic_less(ab, cd) ? cd : ab;
  if (&greatest == &d) return false;
  if (&greatest == &a) return orientation(d, b, c) > 0;
  if (&greatest == &b) return orientation(a, d, c) > 0;
  return orientation(a, b, d) > 0;
}

}  // namespace isopach
