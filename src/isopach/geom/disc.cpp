#include "isopach/geom/disc.hpp"

#include <array>
#include <cmath>

#include "isopach/geom/whole_numbers.hpp"

namespace isopach {
namespace {

using whole::BigInt;
using whole::CommonScale;

/// Three points, x counted from a line that they all lie right of (all x are positive), y from the first of them.
///
/// The circle through them is X² + Y² + pX + qY + s = 0, where by Cramer's rule p, q and s are quotients by
/// D = |X Y 1|. It meets the line X = 0 where Y² + qY + s = 0, that is nowhere if q² < 4s; with q = Nq / D and
/// s = Ns / D: if Nq² < 4 Ns D. As the points lie right of the line, so does the disc then.
bool misses_line(const std::array<BigInt, 3>& x, const std::array<BigInt, 3>& y) {
  std::array<BigInt, 3> lift;
  for (std::size_t i = 0; i < 3; ++i) lift[i] = x[i] * x[i] + y[i] * y[i];
  // Determinants with rows (u, v, 1) and (x, y, −lift).
  const auto with_ones = [](const std::array<BigInt, 3>& u, const std::array<BigInt, 3>& v) {
    return (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
  };
  const BigInt d = with_ones(x, y), nq = with_ones(lift, x);
  BigInt ns;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    ns = ns - lift[i] * (x[j] * y[k] - x[k] * y[j]);
  }
  const BigInt four(4, 0);
  return (nq * nq - four * ns * d).sign() < 0;
}

/// A side of a box as misses_line wants it.
struct Side {
  double at;
  bool is_high, is_y;
};

bool clears(const Point2& a, const Point2& b, const Point2& c, const Side& side) {
  if (std::isinf(side.at)) return true;
  const std::array<const Point2*, 3> points{&a, &b, &c};
  const CommonScale<7> scale({a.x, a.y, b.x, b.y, c.x, c.y, side.at});
  std::array<BigInt, 3> along, across;
  const BigInt line = big(scale, 6);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t first = side.is_y ? 1 : 0;
    const BigInt from = big(scale, 2 * i + first);
    along[i] = side.is_high ? line - from : from - line;
    if (along[i].sign() <= 0) return false;
    across[i] = big(scale, 2 * i + 1 - first) - big(scale, 1 - first);
  }
  return misses_line(along, across);
}

/// The filter: by how much a disc clears a line at most and at least. Everything is told from corner a.
///
/// With e = 2⁻⁵³ and permanents in the place of differences, the centre u / d is off by less than 32 e (|u|_p + |u| P /
/// |d|) / |d|, where |u|_p and P are the permanents of u and d: each product and sum adds at most e of its size, and no
/// expression here is deeper than eight. Nothing is decided of slivers, where d is small beside P, nor where products
/// might underflow.
class Filtered {
 public:
  Filtered(const Point2& a, const Point2& b, const Point2& c) : a_(a) {
    const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
    const double b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    const double d = 2 * (bx * cy - by * cx), permanent = 2 * (std::fabs(bx * cy) + std::fabs(by * cx));
    constexpr double least = 1e-140, sliver = 1e-9, unit = 0x1p-53;
    if (!(std::fabs(d) > sliver * permanent) || !(permanent > least)) return;
    const double ux = cy * b2 - by * c2, uy = bx * c2 - cx * b2;
    const double u_permanent = (std::fabs(cy) + std::fabs(cx)) * b2 + (std::fabs(by) + std::fabs(bx)) * c2;
    const double u = std::sqrt(ux * ux + uy * uy);
    if (!std::isfinite(u) || !(u_permanent * u_permanent < 1e300)) return;
    centre_ = {ux / d, uy / d};
    radius_ = u / std::fabs(d);
    slack_ = 64 * unit * (u_permanent + u * permanent / std::fabs(d)) / std::fabs(d);
    knows_ = true;
  }

  /// 1: the disc clears the side; −1: it does not; 0: not known.
  [[nodiscard]] int clears(const Side& side) const {
    if (std::isinf(side.at)) return 1;
    if (!knows_) return 0;
    const double from = side.is_y ? a_.y : a_.x, centre = side.is_y ? centre_.y : centre_.x;
    const double to_line = side.is_high ? side.at - from : from - side.at;
    const double margin = to_line + (side.is_high ? -centre : centre) - radius_;
    const double slack = slack_ + 0x1p-50 * std::fabs(to_line);
    return margin > slack ? 1 : margin < -slack ? -1 : 0;
  }

 private:
  Point2 a_, centre_{0, 0};
  double radius_ = 0, slack_ = 0;
  bool knows_ = false;
};

std::array<Side, 4> sides_of(const OpenBox& box) {
  return {Side{box.low.x, false, false}, Side{box.high.x, true, false}, Side{box.low.y, false, true},
          Side{box.high.y, true, true}};
}

}  // namespace

namespace exact {

bool disc_inside(const Point2& a, const Point2& b, const Point2& c, const OpenBox& box) {
  for (const Side& side : sides_of(box))
    if (!clears(a, b, c, side)) return false;
  return true;
}

}  // namespace exact

bool disc_inside(const Point2& a, const Point2& b, const Point2& c, const OpenBox& box) {
  if (!box.holds(a) || !box.holds(b) || !box.holds(c)) return false;
  const Filtered filtered(a, b, c);
  bool is_sure = true;
  for (const Side& side : sides_of(box)) {
    const int known = filtered.clears(side);
    if (known < 0) return false;
    is_sure = is_sure && known > 0;
  }
  return is_sure || exact::disc_inside(a, b, c, box);
}

}  // namespace isopach
