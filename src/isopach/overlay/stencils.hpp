// stencils: which nodes of one scan, with which weights, make the interpolated height at a located point. What
// interpolate computes, kept for those who ask how an error of the input heights spreads.
#pragma once
#include <array>
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach {

/// Height = Σ weight[k] · z[node[k]]; weights are ≥ 0 and add up to 1. Fewer than three nodes: the rest has weight 0.
struct Stencil {
  std::array<Index, 3> node{0, 0, 0};
  std::array<double, 3> weight{1, 0, 0};

  [[nodiscard]] double apply(std::span<const double> z) const {
    return weight[0] * z[node[0]] + weight[1] * z[node[1]] + weight[2] * z[node[2]];
  }
};

/// Of each located point, in parallel: on a node, along an edge, in a triangle; outside along the nearest hull edge. A
/// triangulation without nodes has none (`none` is refused by Error, as nothing can be located there). 40 bytes a
/// point. Oracle: tests/overlay/stencils_test.cpp (against interpolate).
[[nodiscard]] Array<Stencil> stencils(const Locations& where, std::span<const Point2> points, const Triangulation& t,
                                      std::span<const Point2> xy, const Context& context);

}  // namespace isopach
