// Local polynomials at the nodes of one scan: what of its relief the sampling resolves, and what it leaves over.
#pragma once
#include <array>
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"

namespace isopach {

/// Of each node the least-squares cubic through its neighbourhood: the node, its neighbours in the triangulation and
/// theirs, at most the `most_neighbours` nearest, all with the same weight. Where they do not determine a cubic (few
/// of them, or on too few lines) it is a quadratic, a plane, or nothing (all zero).
struct LocalFits {
  static constexpr std::size_t terms = 9;  ///< dx, dy, dx², dx dy, dy², dx³, dx² dy, dx dy², dy³
  using Terms = std::array<double, terms>;
  static constexpr std::size_t most_neighbours = 24;

  Array<Terms> shape;  ///< coefficients of the heights about the node; the constant is left out
  Array<Terms> echo;   ///< what the same fit makes of independent noise of standard deviation 1 at the nodes
  /// Height minus fit at the node, divided by √(1 − leverage): of independent noise of standard deviation s its
  /// standard deviation is s, whatever the geometry. Equals the residual against the fit without the node, times √(1 −
  /// leverage).
  Array<double> residual;

  /// Polynomial of `coefficients` at (dx, dy) from its node; 0 there.
  [[nodiscard]] static double value(const Terms& c, double dx, double dy) {
    return dx * (c[0] + dx * (c[2] + dx * c[5] + dy * c[6]) + dy * c[3]) +
           dy * (c[1] + dy * (c[4] + dx * c[7] + dy * c[8]));
  }
};

/// `noise`: for each node one draw of standard deviation 1, for LocalFits::echo. Cost O(nodes), 152 bytes a node.
/// Oracle: tests/measure/local_fit_test.cpp (fits by QR; a node left out).
[[nodiscard]] LocalFits local_fits(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                                   std::span<const double> noise, const Context& context);

}  // namespace isopach
