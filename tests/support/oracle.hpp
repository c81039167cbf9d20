// Oracles: slow, obviously right, and sharing nothing with the library but Point2. Exact tests are done in big integers
// (Boost.Multiprecision), integrals by cutting polygons in long double.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "isopach/geom/vec.hpp"
#include "tests/support/points.hpp"

namespace isopach::test {

/// Sign of the doubled area of abc: 1 if counter-clockwise.
[[nodiscard]] int exact_orientation(const Point2& a, const Point2& b, const Point2& c);

/// 1 if d lies inside the circle through a, b, c (counter-clockwise), −1 outside, 0 on it.
[[nodiscard]] int exact_in_circle(const Point2& a, const Point2& b, const Point2& c, const Point2& d);

/// The same with ties broken: of four cocircular points the lexicographically greatest is lifted off the paraboloid by
/// an infinitesimal height (Devillers, Teillaud 2003). a, b, c counter-clockwise, all distinct: never undecided.
[[nodiscard]] bool tied_in_circle(const Point2& a, const Point2& b, const Point2& c, const Point2& d);

/// Sign of |a − b|² − |c − d|², exact.
[[nodiscard]] int exact_compare_lengths(const Point2& a, const Point2& b, const Point2& c, const Point2& d);

/// Sign of (sum of the signed areas of `triangles`, three points each) − (area of the polygon), exact.
[[nodiscard]] int exact_compare_areas(const Points& triangles, const Points& polygon);

using Triple = std::array<std::size_t, 3>;

/// All counter-clockwise triples with an empty tie-broken circle, least id first, sorted. `points` are distinct.
[[nodiscard]] std::vector<Triple> brute_delaunay(const Points& points);

/// Corners of the convex hull, counter-clockwise, without points inside its edges. Monotone chain, exact.
[[nodiscard]] Points brute_hull(Points points);

/// Area of a simple polygon.
[[nodiscard]] long double polygon_area(const Points& polygon);

/// Area of the intersection of two convex counter-clockwise polygons.
[[nodiscard]] long double convex_intersection_area(const Points& p, const Points& q);

/// Weight (sum of lengths) of the Euclidean minimum spanning tree: Prim on the complete graph, O(n²).
[[nodiscard]] long double prim_weight(const Points& points);

/// Where q lies: `corners` holds 1 node, the 2 ends of an edge, the 3 corners of a triangle, or nothing (outside).
/// Ascending ids. Exact.
[[nodiscard]] std::vector<std::size_t> brute_locate(const Points& points, const std::vector<Triple>& triangles,
                                                    const Point2& q);

/// A surface: distinct nodes, heights, and their Delaunay triangles.
struct BruteSurface {
  Points xy;
  std::vector<double> z;
  std::vector<Triple> triangles;

  /// Height at q; nothing outside the hull.
  [[nodiscard]] std::optional<long double> at(const Point2& q) const;
  /// Height at q; outside the hull that of the nearest point of the hull's boundary.
  [[nodiscard]] long double clamped_at(const Point2& q) const;
};
[[nodiscard]] BruteSurface brute_surface(const Points& xy, const std::vector<double>& z);

/// Integrals of d over one triangle, by cutting it at d = 0 and adding up the pieces.
struct Parts {
  long double area = 0, above = 0, below = 0;
};
[[nodiscard]] Parts brute_triangle_parts(const std::array<Point2, 3>& p, const std::array<long double, 3>& d);

/// Area of the part of a triangle where low <= d <= high, by cutting.
[[nodiscard]] long double brute_area_between(const std::array<Point2, 3>& p, const std::array<long double, 3>& d,
                                             long double low, long double high);

/// A side of a convex hull, its inside on the left, with the heights at its ends.
struct HullSide {
  Point2 p, q;
  long double zp, zq;
};
/// A corner of a cell of T; a height that is not known, beyond the hull of that surface, is of no account.
struct CellCorner {
  long double x, y, z1, z2;
};
/// Integrals over what of a triangle of T lies in both hulls: cut along their sides one after the other, on a side with
/// the height of that side, and fanned from its least corner.
[[nodiscard]] Parts brute_parts_in_hulls(const std::array<CellCorner, 3>& cell, const std::vector<HullSide>& first,
                                         const std::vector<HullSide>& second);

/// The measure on the common triangulation (docs/method/method.md, section 1): over what of the triangles of T lies in
/// both hulls, or over all of them (hull_domain) with clamped heights.
[[nodiscard]] Parts brute_common_measure(const BruteSurface& a, const BruteSurface& b, bool hull_domain);

}  // namespace isopach::test
