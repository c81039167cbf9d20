#include "isopach/overlay/interpolate.hpp"

#include <algorithm>
#include <limits>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/first_corner.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

double along_edge(const Point2& q, const Point2& a, const Point2& b, double za, double zb) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  const double s = ((q.x - a.x) * dx + (q.y - a.y) * dy) / (dx * dx + dy * dy);
  return std::clamp(za + std::clamp(s, 0.0, 1.0) * (zb - za), std::min(za, zb), std::max(za, zb));
}

double cross(const Point2& o, const Point2& a, const Point2& b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

// Below this share of the longest side squared, rounded areas have lost half their digits.
constexpr double thin = 1e-7;

double in_triangle(const Point2& q, const std::array<Index, 3>& v, std::span<const Point2> xy,
                   std::span<const double> z) {
  const Point2 &a = xy[v[0]], &b = xy[v[1]], &c = xy[v[2]];
  const double za = z[v[0]], zb = z[v[1]], zc = z[v[2]];
  // Weights from corners seen from q: products of short lengths, so thin triangles lose little.
  double wa = cross(q, b, c), wb = cross(q, c, a), wc = cross(q, a, b);
  const double width = std::max({std::fabs(b.x - a.x), std::fabs(c.x - a.x), std::fabs(c.x - b.x)});
  const double height = std::max({std::fabs(b.y - a.y), std::fabs(c.y - a.y), std::fabs(c.y - b.y)});
  if (!(wa + wb + wc > thin * (width * width + height * height))) {
    wa = exact::twice_area(q, b, c);
    wb = exact::twice_area(q, c, a);
    wc = exact::twice_area(q, a, b);
  }
  const double value = za + (wb * (zb - za) + wc * (zc - za)) / (wa + wb + wc);
  if (!std::isfinite(value)) return za;  // areas smaller than the smallest double
  return std::clamp(value, std::min({za, zb, zc}), std::max({za, zb, zc}));
}

}  // namespace

Array<double> interpolate(const Locations& where, std::span<const Point2> points, const Triangulation& t,
                          std::span<const Point2> xy, std::span<const double> z, const Context& context) {
  context.check();
  Array<double> value(where.size());
  for_each_index(where.size(), [&](std::size_t i) {
    const Location at = where[i];
    switch (at.kind) {
      case Location::Kind::node:
        value[i] = z[at.id];
        break;
      case Location::Kind::triangle:
        value[i] = in_triangle(points[i], from_first_corner(t.triangles[at.id].v), xy, z);
        break;
      case Location::Kind::outside:
        if (t.nodes == 1) {
          value[i] = z[0];
          break;
        }
        [[fallthrough]];
      case Location::Kind::edge: {
        Index a = t.origin(at.id), b = t.target(at.id);
        if (a > b) std::swap(a, b);
        value[i] = along_edge(points[i], xy[a], xy[b], z[a], z[b]);
        break;
      }
      case Location::Kind::none:
        value[i] = std::numeric_limits<double>::quiet_NaN();
        break;
    }
  });
  return value;
}

}  // namespace isopach
