// Plane: the predicates on nodes, for whatever builds a triangulation. Internal to triangulate and insert.
#pragma once
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

#include "isopach/base/types.hpp"
#include "isopach/geom/predicates.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

// The predicates on nodes. Filters first, as in geom/predicates.hpp; what they cannot decide is decided at once where
// the arithmetic was exact to begin with: where all coordinates are multiples of a power of two g (rasters, quantised
// scans) and the points lie within s of each other, squared, every intermediate result of in_circle is an integer below
// 2⁵³ times a power of g for s <= 2²⁵g², and every one of orientation for s <= 2⁵¹g².
class Plane {
 public:
  explicit Plane(std::span<const Point2> xy) : xy_(xy.data()) {
    const double g = common_step(xy);
    if (g > 0) exact_in_circle_ = 0x1p25 * g * g, exact_orientation_ = 0x1p51 * g * g;
  }

  [[nodiscard]] const Point2& operator[](Index node) const { return xy_[node]; }

  [[nodiscard]] int turn(Index a, Index b, Index c) const {
    const Point2 &p = xy_[a], &q = xy_[b], &r = xy_[c];
    const double qx = q.x - p.x, qy = q.y - p.y, rx = r.x - p.x, ry = r.y - p.y;
    const double left = qx * ry, right = qy * rx;
    const double det = left - right;
    const double bound = orientation_filter * (std::fabs(left) + std::fabs(right)) + underflow_guard;
    if (det > bound) return 1;
    if (det < -bound) return -1;
    if (std::max(qx * qx + qy * qy, rx * rx + ry * ry) <= exact_orientation_) return det > 0 ? 1 : (det < 0 ? -1 : 0);
    return orientation(p, q, r);
  }

  // Is d inside the circle through the counter-clockwise a, b, c? For where a filter has failed.
  [[nodiscard]] bool inside(Index a, Index b, Index c, Index d) const {
    const Point2& o = xy_[a];
    const Point2 pa{0, 0}, pb{xy_[b].x - o.x, xy_[b].y - o.y}, pc{xy_[c].x - o.x, xy_[c].y - o.y},
        pd{xy_[d].x - o.x, xy_[d].y - o.y};
    const double lift_b = dot(pb, pb), lift_c = dot(pc, pc), lift_d = dot(pd, pd);
    if (std::max(lift_b, std::max(lift_c, lift_d)) > exact_in_circle_)
      return inside_circle(xy_[a], xy_[b], xy_[c], xy_[d]);
    const double bc = cross(pb, pc), bd = cross(pb, pd), cd = cross(pc, pd);
    const double det = lift_c * bd - lift_d * bc - lift_b * cd;
    if (det != 0) return det > 0;
    // tie_is_inside, its orientations read off the minors.
    const bool b_greater = lexicographic_less(pa, pb), d_greater = lexicographic_less(pc, pd);
    if (lexicographic_less(b_greater ? pb : pa, d_greater ? pd : pc)) return !d_greater && bd > 0;
    return (b_greater ? -cd : bc - bd + cd) > 0;
  }

  static double dot(const Point2& p, const Point2& q) { return p.x * q.x + p.y * q.y; }
  static double cross(const Point2& p, const Point2& q) { return p.x * q.y - p.y * q.x; }

 private:
  // The largest power of two that divides every coordinate, 0 if that is too small beside them to be of use.
  static double common_step(std::span<const Point2> xy) {
    int low = 1100, high = -1100;
    for (const Point2& p : xy) {
      for (const double value : {p.x, p.y}) {
        const auto bits = std::bit_cast<std::uint64_t>(value);
        const std::uint64_t fraction = bits & 0xfffffffffffffULL;
        const int exponent = static_cast<int>((bits >> 52) & 0x7ff) - 1023;
        if (value == 0) continue;
        high = std::max(high, exponent);
        low = std::min(low, exponent - 52 + (fraction == 0 ? 52 : std::countr_zero(fraction)));
      }
      if (high - low > 45) return 0;
    }
    return low > -400 && high < 400 ? std::ldexp(1.0, low) : 0;
  }

  const Point2* xy_;
  double exact_in_circle_ = -1, exact_orientation_ = -1;
};

}  // namespace isopach
