// Exact predicates: every topological decision of the library is one of these. A floating-point filter decides almost
// always; what it cannot decide is decided by integers, never by a tolerance.
//
// Filter bounds: [Shewchuk1997], (3+16ε)ε and (10+96ε)ε with ε = 2⁻⁵³, plus a term that sends results that may
// have underflowed to the exact stage; an underflow of 2⁻¹⁰⁷⁵ is scaled up by what it is multiplied with, at most the
// sum of the lifts. Exact stage (predicates.cpp): coordinates as integers over their common power of two; 128- and
// 256-bit arithmetic where they span at most 61 bits, arbitrary width otherwise. No floating-point operation takes part
// in it, so no compiler contraction to fused multiply-adds can spoil it; the filters' bounds hold with contraction and
// without (both are tested: contraction_test.cpp), whatever flags a user has.
//
// Legal input: finite doubles. Oracle: tests/geom/predicates_test.cpp (exact rational arithmetic).
#pragma once
#include <cmath>

#include "isopach/geom/vec.hpp"

namespace isopach {

namespace exact {
/// The exact stages, callable alone so that tests can compare them with the filtered ones.
[[nodiscard]] int orientation(const Point2& a, const Point2& b, const Point2& c);
[[nodiscard]] int in_circle(const Point2& a, const Point2& b, const Point2& c, const Point2& d);
/// Twice the signed area of a, b, c, computed exactly and rounded: for triangles so thin that rounding would eat them.
[[nodiscard]] double twice_area(const Point2& a, const Point2& b, const Point2& c);
}  // namespace exact

inline constexpr double orientation_filter = 3.3306690738754716e-16;
inline constexpr double in_circle_filter = 1.1102230246251577e-15;
inline constexpr double underflow_guard = 1e-280;

/// The filter alone: the sign of the turn a→b→c, or 2 if it cannot tell.
[[nodiscard]] inline int orientation_filtered(const Point2& a, const Point2& b, const Point2& c) {
  const double left = (a.x - c.x) * (b.y - c.y);
  const double right = (a.y - c.y) * (b.x - c.x);
  const double det = left - right;
  const double bound = orientation_filter * (std::fabs(left) + std::fabs(right)) + underflow_guard;
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return 2;
}

/// +1 if a, b, c turn left (counter-clockwise), −1 if they turn right, 0 if they are collinear. Exact.
[[nodiscard]] inline int orientation(const Point2& a, const Point2& b, const Point2& c) {
  const int sign = orientation_filtered(a, b, c);
  return sign != 2 ? sign : exact::orientation(a, b, c);
}

/// The filter alone for in_circle, or 2.
[[nodiscard]] inline int in_circle_filtered(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const double adx = a.x - d.x, ady = a.y - d.y;
  const double bdx = b.x - d.x, bdy = b.y - d.y;
  const double cdx = c.x - d.x, cdy = c.y - d.y;
  const double bc = bdx * cdy, cb = cdx * bdy;
  const double ca = cdx * ady, ac = adx * cdy;
  const double ab = adx * bdy, ba = bdx * ady;
  const double al = adx * adx + ady * ady;
  const double bl = bdx * bdx + bdy * bdy;
  const double cl = cdx * cdx + cdy * cdy;
  const double det = al * (bc - cb) + bl * (ca - ac) + cl * (ab - ba);
  const double permanent = (std::fabs(bc) + std::fabs(cb)) * al + (std::fabs(ca) + std::fabs(ac)) * bl +
                           (std::fabs(ab) + std::fabs(ba)) * cl;
  const double bound = in_circle_filter * permanent + underflow_guard * (1 + al + bl + cl);
  if (det > bound) return 1;
  if (det < -bound) return -1;
  return 2;
}

/// For counter-clockwise a, b, c: +1 if d lies inside their circle, −1 outside, 0 on it. Exact.
[[nodiscard]] inline int in_circle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const int sign = in_circle_filtered(a, b, c, d);
  return sign != 2 ? sign : exact::in_circle(a, b, c, d);
}

/// Which side of a tie d falls on: the four points are cocircular and distinct. The lexicographically greatest of them
/// is lifted by an infinitesimal height (the others by infinitely less): true if d is then inside.
[[nodiscard]] bool tie_is_inside(const Point2& a, const Point2& b, const Point2& c, const Point2& d);

/// in_circle with the tie rule: true if d is inside the circle of the counter-clockwise triangle a, b, c, cocircular
/// points decided by tie_is_inside. Never undecided for four distinct points [Devillers2003].
[[nodiscard]] inline bool inside_circle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  int sign = in_circle_filtered(a, b, c, d);
  if (sign == 2) {
    sign = exact::in_circle(a, b, c, d);
    if (sign == 0) return tie_is_inside(a, b, c, d);
  }
  return sign > 0;
}

}  // namespace isopach
