// Trapezoids: a region of the plane, bounded by straight edges, as pieces with two vertical walls each. The region is
// what an even-odd count of edges calls inside: rings, holes and several parts need no order and no sense of rotation.
//
// A sweep from left to right ([Shamos1976]; the decomposition after [Chazelle1984]). No point is
// constructed: a wall stands at the x of an input vertex, floor and roof are input edges, so that the side of any
// further point is one exact orientation of input points.
#pragma once
#include <optional>
#include <vector>

#include "isopach/geom/vec.hpp"

namespace isopach {

struct Edge {
  Point2 a, b;
};

/// All points with x0 ≤ x ≤ x1 above `lower` and below `upper`; both edges run from left to right and span [x0, x1].
struct Trapezoid {
  double x0, x1;
  Edge lower, upper;
};

/// Height of an edge that is not vertical at x; between the heights of its ends.
[[nodiscard]] double height_at(const Edge& edge, double x);

[[nodiscard]] double area_of(const Trapezoid& t);

/// The region of a set of edges, which together are closed rings (in any order), as trapezoids without common interior:
/// at most two per edge. Edges may share ends and touch at ends; an edge given twice cancels itself, and edges
/// without length are ignored. Edges that cross, that lie on one another in part, or that close no ring bound nothing:
/// then the result is empty and `at`, if given, a point near the place. Order of the edges does not matter. Exact.
/// Cost O(n log n). Oracle: tests/geom/trapezoids_test.cpp (even-odd count at random points; areas).
[[nodiscard]] std::optional<std::vector<Trapezoid>> trapezoids(std::vector<Edge> edges, Point2* at = nullptr);

}  // namespace isopach
