#include "isopach/overlay/stencils.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/first_corner.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

Stencil along_edge(const Point2& q, Index a, Index b, std::span<const Point2> xy) {
  const double dx = xy[b].x - xy[a].x, dy = xy[b].y - xy[a].y;
  const double s = std::clamp(((q.x - xy[a].x) * dx + (q.y - xy[a].y) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  return {{a, b, a}, {1 - s, s, 0}};
}

double cross(const Point2& o, const Point2& a, const Point2& b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

// Below this share of the longest side squared, rounded areas have lost half their digits.
constexpr double thin = 1e-7;

Stencil in_triangle(const Point2& q, const std::array<Index, 3>& v, std::span<const Point2> xy) {
  const Point2 &a = xy[v[0]], &b = xy[v[1]], &c = xy[v[2]];
  const double width = std::max({a.x, b.x, c.x}) - std::min({a.x, b.x, c.x});
  const double height = std::max({a.y, b.y, c.y}) - std::min({a.y, b.y, c.y});
  double wa = std::max(0.0, cross(q, b, c)), wb = std::max(0.0, cross(q, c, a)), wc = std::max(0.0, cross(q, a, b));
  if (!(wa + wb + wc > thin * (width * width + height * height))) {
    wa = exact::twice_area(q, b, c);
    wb = exact::twice_area(q, c, a);
    wc = exact::twice_area(q, a, b);
  }
  const double sum = wa + wb + wc;
  if (!(sum > 0) || !std::isfinite(sum)) return {v, {1, 0, 0}};  // areas smaller than the smallest double
  return {v, {wa / sum, wb / sum, wc / sum}};
}

}  // namespace

Array<Stencil> stencils(const Locations& where, std::span<const Point2> points, const Triangulation& t,
                        std::span<const Point2> xy, const Context& context) {
  context.check();
  Array<Stencil> result(where.size());
  for_each_index(where.size(), [&](std::size_t i) {
    const Location at = where[i];
    switch (at.kind) {
      case Location::Kind::node:
        result[i] = {{at.id, at.id, at.id}, {1, 0, 0}};
        break;
      case Location::Kind::triangle:
        result[i] = in_triangle(points[i], from_first_corner(t.triangles[at.id].v), xy);
        break;
      case Location::Kind::outside:
        if (t.nodes == 1) {
          result[i] = Stencil{};
          break;
        }
        [[fallthrough]];
      case Location::Kind::edge: {
        const Index a = t.origin(at.id), b = t.target(at.id);
        result[i] = along_edge(points[i], std::min(a, b), std::max(a, b), xy);
        break;
      }
      case Location::Kind::none:
        throw Error(ExitCode::internal, "stencils: a point is located in a triangulation without nodes");
    }
  });
  return result;
}

}  // namespace isopach
