#include "isopach/geom/predicates.hpp"

#include <array>
#include <cmath>
#include <cstdint>

#include "isopach/geom/whole_numbers.hpp"

namespace isopach {

namespace {

using whole::BigInt;
using whole::CommonScale;
using whole::Int128;
using whole::UInt128;

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
