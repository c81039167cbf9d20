// Polygons for tests: random simple ones with holes, and what GEOS (by OGR) says of them. Independent of geom/ and
// overlay/: no function of the library but its random numbers is called here.
#pragma once
#include <ogr_geometry.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "isopach/base/random.hpp"
#include "isopach/geom/trapezoids.hpp"

namespace isopach::test {

using Ring = std::vector<Point2>;
using Rings = std::vector<Ring>;

inline std::vector<Edge> edges_of(const Rings& rings) {
  std::vector<Edge> edges;
  for (const Ring& ring : rings)
    for (std::size_t i = 0; i < ring.size(); ++i) edges.push_back({ring[i], ring[(i + 1) % ring.size()]});
  return edges;
}

/// A star round a centre: simple, far from convex. `step` > 0 rounds to its multiples: collinear edges, shared
/// coordinates; the result may then cross itself (see is_valid).
inline Ring star(const RandomStream& random, std::uint64_t at, Point2 centre, double radius, std::size_t corners,
                 double step = 0) {
  Ring ring;
  for (std::size_t i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * (static_cast<double>(i) + 0.3 * random.uniform(at + 2 * i)) /
                         static_cast<double>(corners);
    const double r = radius * (0.35 + 0.65 * random.uniform(at + 2 * i + 1));
    Point2 p{centre.x + r * std::cos(angle), centre.y + r * std::sin(angle)};
    if (step > 0) p = {std::round(p.x / step) * step, std::round(p.y / step) * step};
    if (ring.empty() || !(ring.back() == p)) ring.push_back(p);
  }
  while (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
  return ring;
}

inline OGRPolygon to_ogr(const Rings& rings) {
  OGRPolygon polygon;
  for (const Ring& r : rings) {
    OGRLinearRing ring;
    for (const Point2& p : r) ring.addPoint(p.x, p.y);
    ring.closeRings();
    polygon.addRing(&ring);
  }
  return polygon;
}

inline bool is_valid(const Rings& rings) {
  CPLPushErrorHandler(CPLQuietErrorHandler);
  const OGRPolygon polygon = to_ogr(rings);
  const bool valid = polygon.IsValid() != 0;
  CPLPopErrorHandler();
  return valid;
}

inline double area_of(const OGRGeometry* g) {
  if (g == nullptr) return 0;
  if (const auto* surface = dynamic_cast<const OGRSurface*>(g)) return surface->get_Area();
  double area = 0;
  if (const auto* all = dynamic_cast<const OGRGeometryCollection*>(g))
    for (int i = 0; i < all->getNumGeometries(); ++i) area += area_of(all->getGeometryRef(i));
  return area;
}

using Geometry = std::unique_ptr<OGRGeometry>;
inline Geometry triangle(const Point2& a, const Point2& b, const Point2& c) {
  return std::make_unique<OGRPolygon>(to_ogr({{a, b, c}}));
}
inline double shared_area(const OGRGeometry& a, const OGRGeometry& b) {
  return area_of(Geometry(a.Intersection(&b)).get());
}

/// Even-odd: how often a ray to the left meets an edge.
inline bool inside(const Rings& rings, const Point2& p) {
  bool in = false;
  for (const Edge& e : edges_of(rings))
    if ((e.a.y > p.y) != (e.b.y > p.y) && p.x > e.a.x + (p.y - e.a.y) / (e.b.y - e.a.y) * (e.b.x - e.a.x)) in = !in;
  return in;
}

}  // namespace isopach::test
