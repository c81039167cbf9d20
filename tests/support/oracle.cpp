#include "tests/support/oracle.hpp"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace isopach::test {
namespace {

using Integer = boost::multiprecision::cpp_int;

struct ExactPoint {
  Integer x, y;
};

/// Exponent e such that x is an integer multiple of 2^e.
int lowest_exponent(double x) {
  if (x == 0) return std::numeric_limits<int>::max();
  int e = 0;
  std::frexp(x, &e);
  return e - 53;
}

Integer scaled(double x, int exponent) {
  if (x == 0) return 0;
  int e = 0;
  const double mantissa = std::frexp(x, &e);
  Integer value = static_cast<long long>(std::ldexp(mantissa, 53));
  return value << static_cast<unsigned>(e - 53 - exponent);
}

/// All points in one common unit, in which they are integers. Signs of homogeneous polynomials do not notice.
template <class Container>
std::vector<ExactPoint> exact_points(const Container& points) {
  int exponent = std::numeric_limits<int>::max();
  for (const Point2& p : points) exponent = std::min({exponent, lowest_exponent(p.x), lowest_exponent(p.y)});
  std::vector<ExactPoint> exact;
  for (const Point2& p : points) exact.push_back({scaled(p.x, exponent), scaled(p.y, exponent)});
  return exact;
}

int orientation(const ExactPoint& a, const ExactPoint& b, const ExactPoint& c) {
  const Integer det = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  return det.sign();
}

int in_circle(const ExactPoint& a, const ExactPoint& b, const ExactPoint& c, const ExactPoint& d) {
  const Integer ax = a.x - d.x, ay = a.y - d.y, bx = b.x - d.x, by = b.y - d.y, cx = c.x - d.x, cy = c.y - d.y;
  const Integer det = (ax * ax + ay * ay) * (bx * cy - by * cx) - (bx * bx + by * by) * (ax * cy - ay * cx) +
                      (cx * cx + cy * cy) * (ax * by - ay * bx);
  return det.sign();
}

int compare(const ExactPoint& a, const ExactPoint& b) {
  if (a.x != b.x) return a.x < b.x ? -1 : 1;
  return a.y < b.y ? -1 : a.y > b.y ? 1 : 0;
}

bool tied(const ExactPoint& a, const ExactPoint& b, const ExactPoint& c, const ExactPoint& d) {
  const int sign = in_circle(a, b, c, d);
  if (sign != 0) return sign > 0;
  const bool d_beats_a = compare(d, a) > 0, d_beats_b = compare(d, b) > 0, d_beats_c = compare(d, c) > 0;
  if (d_beats_a && d_beats_b && d_beats_c) return false;  // d itself is lifted: off the lower hull of abc
  // Lifting a corner tilts the plane through the lifted triangle about the other two: up on the corner's own side.
  if (compare(a, b) > 0 && compare(a, c) > 0) return orientation(b, c, d) > 0;
  if (compare(b, a) > 0 && compare(b, c) > 0) return orientation(c, a, d) > 0;
  return orientation(a, b, d) > 0;
}

struct Vertex {
  long double x, y, d;
};

/// The part of a convex polygon where sign·(d − level) >= 0; d is linear on it.
std::vector<Vertex> cut(const std::vector<Vertex>& polygon, long double level, int sign) {
  std::vector<Vertex> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vertex &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const long double s = sign * (p.d - level), t = sign * (q.d - level);
    if (s >= 0) kept.push_back(p);
    if ((s > 0 && t < 0) || (s < 0 && t > 0)) {
      const long double u = s / (s - t);
      kept.push_back({p.x + u * (q.x - p.x), p.y + u * (q.y - p.y), level});
    }
  }
  return kept;
}

long double doubled_area(const Vertex& a, const Vertex& b, const Vertex& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

long double area_of(const std::vector<Vertex>& polygon) {
  long double area = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) area += doubled_area(polygon[0], polygon[i - 1], polygon[i]) / 2;
  return area;
}

long double integral_of(const std::vector<Vertex>& polygon) {
  long double sum = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const Vertex &a = polygon[0], &b = polygon[i - 1], &c = polygon[i];
    sum += doubled_area(a, b, c) / 2 * (a.d + b.d + c.d) / 3;
  }
  return sum;
}

std::vector<Vertex> vertices(const std::array<Point2, 3>& p, const std::array<long double, 3>& d) {
  return {{p[0].x, p[0].y, d[0]}, {p[1].x, p[1].y, d[1]}, {p[2].x, p[2].y, d[2]}};
}

long double square_distance(const Point2& a, const Point2& b) {
  const long double dx = static_cast<long double>(a.x) - b.x, dy = static_cast<long double>(a.y) - b.y;
  return dx * dx + dy * dy;
}

}  // namespace

int exact_orientation(const Point2& a, const Point2& b, const Point2& c) {
  const auto p = exact_points(std::array{a, b, c});
  return orientation(p[0], p[1], p[2]);
}

int exact_in_circle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const auto p = exact_points(std::array{a, b, c, d});
  return in_circle(p[0], p[1], p[2], p[3]);
}

bool tied_in_circle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const auto p = exact_points(std::array{a, b, c, d});
  return tied(p[0], p[1], p[2], p[3]);
}

int exact_compare_lengths(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const auto p = exact_points(std::array{a, b, c, d});
  const auto square = [](const ExactPoint& u, const ExactPoint& v) -> Integer {
    return (u.x - v.x) * (u.x - v.x) + (u.y - v.y) * (u.y - v.y);
  };
  const Integer difference = square(p[0], p[1]) - square(p[2], p[3]);
  return difference.sign();
}

int exact_compare_areas(const Points& triangles, const Points& polygon) {
  Points all = triangles;
  all.insert(all.end(), polygon.begin(), polygon.end());
  const std::vector<ExactPoint> p = exact_points(all);
  const auto cross = [](const ExactPoint& u, const ExactPoint& v) -> Integer { return u.x * v.y - u.y * v.x; };
  Integer difference = 0;
  for (std::size_t i = 0; i < triangles.size(); i += 3)
    difference += cross(p[i], p[i + 1]) + cross(p[i + 1], p[i + 2]) + cross(p[i + 2], p[i]);
  for (std::size_t i = triangles.size(); i < all.size(); ++i)
    difference -= cross(p[i], i + 1 < all.size() ? p[i + 1] : p[triangles.size()]);
  return difference.sign();
}

std::vector<Triple> brute_delaunay(const Points& points) {
  const std::size_t n = points.size();
  const std::vector<ExactPoint> p = exact_points(points);
  std::vector<Triple> triangles;
  const auto empty = [&](const Triple& t) {
    for (std::size_t l = 0; l < n; ++l)
      if (l != t[0] && l != t[1] && l != t[2] && tied(p[t[0]], p[t[1]], p[t[2]], p[l])) return false;
    return true;
  };
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k) {
        const int turn = orientation(p[i], p[j], p[k]);
        if (turn == 0) continue;
        const Triple t = turn > 0 ? Triple{i, j, k} : Triple{i, k, j};
        if (empty(t)) triangles.push_back(t);
      }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

Points brute_hull(Points points) {
  points = distinct(std::move(points));
  if (points.size() < 3) return points;
  Points hull;
  const auto half = [&](auto first, auto last) {
    const std::size_t start = hull.size();
    for (; first != last; ++first) {
      while (hull.size() >= start + 2 && exact_orientation(hull[hull.size() - 2], hull.back(), *first) <= 0)
        hull.pop_back();
      hull.push_back(*first);
    }
    hull.pop_back();
  };
  half(points.begin(), points.end());
  half(points.rbegin(), points.rend());
  return hull;
}

long double polygon_area(const Points& polygon) {
  std::vector<Vertex> v;
  for (const Point2& p : polygon) v.push_back({p.x, p.y, 0});
  return area_of(v);
}

long double convex_intersection_area(const Points& p, const Points& q) {
  std::vector<Vertex> part;
  for (const Point2& v : p) part.push_back({v.x, v.y, 0});
  for (std::size_t i = 0; i < q.size() && !part.empty(); ++i) {
    const Vertex a{q[i].x, q[i].y, 0}, b{q[(i + 1) % q.size()].x, q[(i + 1) % q.size()].y, 0};
    for (Vertex& v : part) v.d = doubled_area(a, b, v);
    part = cut(part, 0, 1);
  }
  return area_of(part);
}

long double prim_weight(const Points& points) {
  const std::size_t n = points.size();
  std::vector<long double> best(n, std::numeric_limits<long double>::infinity());
  std::vector<bool> in_tree(n, false);
  long double weight = 0;
  if (n > 0) best[0] = 0;
  for (std::size_t step = 0; step < n; ++step) {
    std::size_t next = n;
    for (std::size_t i = 0; i < n; ++i)
      if (!in_tree[i] && (next == n || best[i] < best[next])) next = i;
    in_tree[next] = true;
    weight += std::sqrt(best[next]);
    for (std::size_t i = 0; i < n; ++i)
      if (!in_tree[i]) best[i] = std::min(best[i], square_distance(points[next], points[i]));
  }
  return weight;
}

std::vector<std::size_t> brute_locate(const Points& points, const std::vector<Triple>& triangles, const Point2& q) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i] == q) return {i};
  for (const Triple& t : triangles) {
    std::vector<std::size_t> corners;
    bool inside = true;
    for (std::size_t k = 0; k < 3; ++k) {
      // The corner opposite to a side takes part unless q lies on that side.
      const int turn = exact_orientation(points[t[k]], points[t[(k + 1) % 3]], q);
      inside = inside && turn >= 0;
      if (turn > 0) corners.push_back(t[(k + 2) % 3]);
    }
    if (!inside) continue;
    std::sort(corners.begin(), corners.end());
    return corners;
  }
  return {};
}

BruteSurface brute_surface(const Points& xy, const std::vector<double>& z) { return {xy, z, brute_delaunay(xy)}; }

std::optional<long double> BruteSurface::at(const Point2& q) const {
  const std::vector<std::size_t> corners = brute_locate(xy, triangles, q);
  if (corners.empty()) return std::nullopt;
  if (corners.size() == 1) return z[corners[0]];
  if (corners.size() == 2) {
    const long double u =
        std::sqrt(square_distance(xy[corners[0]], q) / square_distance(xy[corners[0]], xy[corners[1]]));
    return z[corners[0]] + u * (static_cast<long double>(z[corners[1]]) - z[corners[0]]);
  }
  // Weights are quotients of areas, and those of slivers are lost in any rounding: exact until the division.
  const auto p = exact_points(std::array{xy[corners[0]], xy[corners[1]], xy[corners[2]], q});
  const auto weight = [](const ExactPoint& u, const ExactPoint& v, const ExactPoint& w) {
    const Integer area = (v.x - u.x) * (w.y - u.y) - (v.y - u.y) * (w.x - u.x);
    return area.convert_to<long double>();
  };
  const long double wa = weight(p[3], p[1], p[2]), wb = weight(p[0], p[3], p[2]), wc = weight(p[0], p[1], p[3]);
  return (wa * z[corners[0]] + wb * z[corners[1]] + wc * z[corners[2]]) / (wa + wb + wc);
}

long double BruteSurface::clamped_at(const Point2& q) const {
  if (const auto inside = at(q)) return *inside;
  long double nearest = std::numeric_limits<long double>::infinity(), value = 0;
  // Boundary edges only: an edge inside may come as near, up to rounding, if it ends one ulp from the boundary.
  std::set<std::pair<std::size_t, std::size_t>> sides;
  for (const Triple& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) sides.insert({t[k], t[(k + 1) % 3]});
  for (const auto& [i, j] : sides) {
    if (sides.count({j, i}) != 0) continue;
    const long double ux = static_cast<long double>(xy[j].x) - xy[i].x,
                      uy = static_cast<long double>(xy[j].y) - xy[i].y;
    const long double vx = static_cast<long double>(q.x) - xy[i].x, vy = static_cast<long double>(q.y) - xy[i].y;
    const long double s = std::clamp((ux * vx + uy * vy) / (ux * ux + uy * uy), 0.0L, 1.0L);
    const long double dx = vx - s * ux, dy = vy - s * uy, distance = dx * dx + dy * dy;
    if (distance < nearest) nearest = distance, value = z[i] + s * (static_cast<long double>(z[j]) - z[i]);
  }
  return value;
}

Parts brute_triangle_parts(const std::array<Point2, 3>& p, const std::array<long double, 3>& d) {
  const std::vector<Vertex> v = vertices(p, d);
  return {area_of(v), integral_of(cut(v, 0, 1)), -integral_of(cut(v, 0, -1))};
}

long double brute_area_between(const std::array<Point2, 3>& p, const std::array<long double, 3>& d, long double low,
                               long double high) {
  return area_of(cut(cut(vertices(p, d), low, 1), high, -1));
}

namespace {

long double left_of(const HullSide& s, const CellCorner& c) {
  return (static_cast<long double>(s.q.x) - s.p.x) * (c.y - s.p.y) -
         (static_cast<long double>(s.q.y) - s.p.y) * (c.x - s.p.x);
}

/// The height of a hull's boundary where it is nearest.
long double height_of(const std::vector<HullSide>& hull, const CellCorner& c) {
  long double least = std::numeric_limits<long double>::infinity(), height = 0;
  for (const HullSide& s : hull) {
    const long double dx = static_cast<long double>(s.q.x) - s.p.x, dy = static_cast<long double>(s.q.y) - s.p.y;
    const long double t = std::clamp(((c.x - s.p.x) * dx + (c.y - s.p.y) * dy) / (dx * dx + dy * dy), 0.0L, 1.0L);
    const long double ex = s.p.x + t * dx - c.x, ey = s.p.y + t * dy - c.y, d = ex * ex + ey * ey;
    if (d < least) least = d, height = s.zp + t * (s.zq - s.zp);
  }
  return height;
}

std::vector<CellCorner> cut_to(const std::vector<CellCorner>& polygon, const std::vector<HullSide>& hull,
                               long double CellCorner::*height) {
  std::vector<CellCorner> left = polygon;
  for (const HullSide& s : hull) {
    const std::vector<CellCorner> all = std::exchange(left, {});
    for (std::size_t k = 0; k < all.size(); ++k) {
      const CellCorner &a = all[k], &b = all[(k + 1) % all.size()];
      const long double ha = left_of(s, a), hb = left_of(s, b);
      if (ha >= 0) left.push_back(a);
      if ((ha < 0) == (hb < 0) || ha == 0 || hb == 0) continue;
      const long double t = ha / (ha - hb);
      CellCorner c{a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z1 + t * (b.z1 - a.z1), a.z2 + t * (b.z2 - a.z2)};
      c.*height = height_of(hull, c);
      left.push_back(c);
    }
  }
  return left;
}

std::vector<HullSide> hull_sides(const BruteSurface& s) {
  std::vector<HullSide> sides;
  for (const Triple& t : s.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t p = t[k], q = t[(k + 1) % 3];
      const bool inner = std::any_of(s.triangles.begin(), s.triangles.end(), [&](const Triple& o) {
        return (o[0] == q && o[1] == p) || (o[1] == q && o[2] == p) || (o[2] == q && o[0] == p);
      });
      if (!inner) sides.push_back({s.xy[p], s.xy[q], s.z[p], s.z[q]});
    }
  return sides;
}

}  // namespace

namespace {

/// A height on a side of the cell: between the nearest places where it is known, ends of the side that lie in the hull
/// and where the side meets the border of the hull.
std::optional<long double> on_side(const CellCorner& c, const CellCorner& a, const CellCorner& b,
                                   const std::vector<HullSide>& hull, long double CellCorner::*height) {
  const long double dx = b.x - a.x, dy = b.y - a.y, length2 = dx * dx + dy * dy;
  const long double off = (c.x - a.x) * dy - (c.y - a.y) * dx, t = ((c.x - a.x) * dx + (c.y - a.y) * dy) / length2;
  if (std::fabs(off) > 1e-13L * length2 || t < 1e-15L || t > 1 - 1e-15L) return {};
  const auto is_in = [&](const CellCorner& p) {
    return std::all_of(hull.begin(), hull.end(), [&](const HullSide& s) { return left_of(s, p) >= 0; });
  };
  std::vector<std::pair<long double, long double>> known;
  if (is_in(a)) known.emplace_back(0, a.*height);
  if (is_in(b)) known.emplace_back(1, b.*height);
  for (const HullSide& s : hull) {
    const long double ha = left_of(s, a), hb = left_of(s, b);
    if ((ha < 0) == (hb < 0) && ha != 0 && hb != 0) continue;
    if (ha == hb) continue;
    const long double u = ha / (ha - hb);
    const CellCorner p{a.x + u * dx, a.y + u * dy, 0, 0};
    const long double ex = s.q.x - static_cast<long double>(s.p.x), ey = s.q.y - static_cast<long double>(s.p.y);
    const long double v = ((p.x - s.p.x) * ex + (p.y - s.p.y) * ey) / (ex * ex + ey * ey);
    if (v > -1e-13L && v < 1 + 1e-13L) known.emplace_back(u, s.zp + std::clamp(v, 0.0L, 1.0L) * (s.zq - s.zp));
  }
  std::sort(known.begin(), known.end());
  for (std::size_t k = 1; k < known.size(); ++k)
    if (known[k - 1].first <= t + 1e-15L && t <= known[k].first + 1e-15L && known[k].first > known[k - 1].first)
      return known[k - 1].second +
             (t - known[k - 1].first) / (known[k].first - known[k - 1].first) * (known[k].second - known[k - 1].second);
  return {};
}

}  // namespace

Parts brute_parts_in_hulls(const std::array<CellCorner, 3>& cell, const std::vector<HullSide>& first,
                           const std::vector<HullSide>& second) {
  std::vector<CellCorner> polygon(cell.begin(), cell.end());
  polygon = cut_to(cut_to(polygon, first, &CellCorner::z1), second, &CellCorner::z2);
  if (polygon.size() < 3) return {};
  for (CellCorner& c : polygon)
    for (std::size_t k = 0; k < 3; ++k) {
      const CellCorner &p = cell[k], &q = cell[(k + 1) % 3];
      if (const auto z = on_side(c, p, q, first, &CellCorner::z1); z && !first.empty()) c.z1 = *z;
      if (const auto z = on_side(c, p, q, second, &CellCorner::z2); z && !second.empty()) c.z2 = *z;
    }
  std::rotate(
      polygon.begin(),
      std::min_element(polygon.begin(), polygon.end(),
                       [](const CellCorner& a, const CellCorner& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }),
      polygon.end());
  Parts total;
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const CellCorner &o = polygon[0], &p = polygon[k - 1], &q = polygon[k];
    const auto from_first = [&](const CellCorner& c) {
      return Point2{static_cast<double>(c.x - o.x), static_cast<double>(c.y - o.y)};
    };
    const Parts part =
        brute_triangle_parts({from_first(o), from_first(p), from_first(q)}, {o.z2 - o.z1, p.z2 - p.z1, q.z2 - q.z1});
    if (part.area > 0) total = {total.area + part.area, total.above + part.above, total.below + part.below};
  }
  return total;
}

Parts brute_common_measure(const BruteSurface& a, const BruteSurface& b, bool hull_domain) {
  Points both = a.xy;
  both.insert(both.end(), b.xy.begin(), b.xy.end());
  both = distinct(std::move(both));
  std::vector<CellCorner> corners;
  for (const Point2& p : both) corners.push_back({p.x, p.y, a.clamped_at(p), b.clamped_at(p)});
  const std::vector<HullSide> first = hull_domain ? std::vector<HullSide>() : hull_sides(a),
                              second = hull_domain ? std::vector<HullSide>() : hull_sides(b);
  Parts total;
  for (const Triple& t : brute_delaunay(both)) {
    const Parts part = brute_parts_in_hulls({corners[t[0]], corners[t[1]], corners[t[2]]}, first, second);
    total = {total.area + part.area, total.above + part.above, total.below + part.below};
  }
  return total;
}

}  // namespace isopach::test
