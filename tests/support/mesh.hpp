// Triangulations as sets of corner coordinates, so that they can be compared whatever their numbering; and one made by
// hand from triples.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "isopach/delaunay/triangulation.hpp"
#include "isopach/geom/curve.hpp"
#include "tests/support/oracle.hpp"

namespace isopach::test {

using Corners = std::array<Point2, 3>;

/// Real triangles by coordinates: each starts at its lexicographically least corner; sorted.
[[nodiscard]] std::vector<Corners> triangle_set(const Triangulation& t, std::span<const Point2> xy);
[[nodiscard]] std::vector<Corners> triangle_set(const std::vector<Triple>& triangles, std::span<const Point2> xy);

/// Undirected edges of real triangles by coordinates, lexicographically less end first; sorted, once each.
[[nodiscard]] std::vector<std::array<Point2, 2>> edge_set(const std::vector<Corners>& triangles);

/// The arrays of a triangulation of n nodes with these counter-clockwise triangles, ghosts and twins included. The
/// boundary of the triangles is one closed curve.
[[nodiscard]] Triangulation from_triples(const std::vector<Triple>& triangles, std::size_t n);

/// The points in curve order of `box`.
[[nodiscard]] Points in_order(const Points& points, const CurveBox& box);

/// The same arrays, bit by bit.
[[nodiscard]] bool same_bytes(const Triangulation& a, const Triangulation& b);

/// Ids of the points in a new order.
template <class T>
[[nodiscard]] std::vector<T> permuted(const std::vector<T>& items, const std::vector<std::size_t>& order) {
  std::vector<T> result;
  for (const std::size_t i : order) result.push_back(items[i]);
  return result;
}

}  // namespace isopach::test
