// The common (united) triangulation T = DT(g1 ∪ g2) and both heights at its nodes (METHOD sections 1 and 2).
#pragma once
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulate.hpp"

namespace isopach {

/// g = g1 ∪ g2 in curve order. `of_1[i]` is the node of g1 that node i is, or no_index; `of_2` likewise; a shared node
/// has both.
struct UnitedNodes {
  Array<Point2> xy;
  Array<Index> of_1, of_2;
};

/// Linear merging of two node sets that are in curve order of the same box. Cost O(n1 + n2).
[[nodiscard]] UnitedNodes unite(std::span<const Point2> g1, std::span<const Point2> g2, const CurveBox& box);

}  // namespace isopach
