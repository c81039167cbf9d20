// The common (united) triangulation T = DT(g1 ∪ g2) and both heights at its nodes (docs/method/method.md, section 1).
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulate.hpp"

namespace isopach {

/// g = g1 ∪ g2 in curve order. `of_1[i]` is the node of g1 that node i is, or no_index; `of_2` likewise; a shared node
/// has both.
struct UnitedNodes {
  Array<Point2> xy;
  Array<Index> of_1, of_2;

  /// Whether a triangle of T is one of the interface: nodes of g1 alone *and* nodes of g2 alone.
  [[nodiscard]] bool joins(const std::array<Index, 3>& triangle) const {
    bool all_1 = true, all_2 = true;
    for (const Index node : triangle) all_1 &= of_1[node] != no_index, all_2 &= of_2[node] != no_index;
    return !all_1 && !all_2;
  }
};

/// Nodes in the order of a curve, with their keys on it (curve_key).
struct CurveNodes {
  std::span<const Point2> xy;
  std::span<const std::uint64_t> keys;
};

/// Linear merging of two node sets that are in order of the same curve. In parallel; the same for any number of
/// threads. Cost O(n1 + n2). Oracle: tests/overlay/common_test.cpp.
[[nodiscard]] UnitedNodes unite(const CurveNodes& g1, const CurveNodes& g2);
/// The same where the keys are not known.
[[nodiscard]] UnitedNodes unite(std::span<const Point2> g1, std::span<const Point2> g2, const CurveBox& box);

}  // namespace isopach
