// Symmetric quadrature on a triangle: two rules that share a point, so that each checks the other.
//   degree 8, 16 points  [Dunavant1985]; digits refined by Newton's method on its equations
//   degree 5, 7 points   [Radon1948], in closed form
// All weights are positive and all points lie inside: a jump or bend that cuts off a corner or a side may escape both
// rules. So a third check: the polynomial of degree 4 through the points predicts the values at the corners and the
// middles of the sides. Test: tests/measure/weight_test.cpp (monomials).
#pragma once
#include <array>
#include <cstddef>

namespace isopach {

struct QuadraturePoint {
  std::array<double, 3> at;  ///< barycentric
  double high, low;          ///< weights of the rules of degree 8 and 5; each sums to 1
};

namespace quadrature_detail {

inline constexpr std::size_t points = 22;

struct Orbit {
  double a, high, low;
};

constexpr std::array<QuadraturePoint, points> make_rule() {
  std::array<QuadraturePoint, points> rule{};
  std::size_t n = 0;
  constexpr double third = 1.0 / 3;
  rule[n++] = {{third, third, third}, 0.14431560767778716825, 0.225};
  constexpr std::array<Orbit, 5> orbits{{{0.45929258829272315603, 0.095091634267284624794, 0},
                                         {0.17056930775176020662, 0.10321737053471825028, 0},
                                         {0.050547228317030975458, 0.032458497623198080311, 0},
                                         {0.10128650732345633880, 0, 0.12593918054482715260},
                                         {0.47014206410511508977, 0, 0.13239415278850618074}}};
  for (const Orbit& o : orbits) {
    const double c = 1 - 2 * o.a;
    rule[n++] = {{c, o.a, o.a}, o.high, o.low};
    rule[n++] = {{o.a, c, o.a}, o.high, o.low};
    rule[n++] = {{o.a, o.a, c}, o.high, o.low};
  }
  constexpr double a = 0.0083947774099576053372, b = 0.26311282963463811342, c = 1 - a - b, w = 0.027230314174434994265;
  for (const std::array<double, 3>& at : {std::array{a, b, c}, std::array{a, c, b}, std::array{b, a, c},
                                          std::array{b, c, a}, std::array{c, a, b}, std::array{c, b, a}})
    rule[n++] = {at, w, 0};
  return rule;
}

}  // namespace quadrature_detail

inline constexpr std::array<QuadraturePoint, quadrature_detail::points> triangle_rule = quadrature_detail::make_rule();

/// A corner or the middle of a side, and what each point of triangle_rule counts in the prediction there: exact for
/// polynomials of degree 4, of least norm.
struct BorderPoint {
  std::array<double, 3> at;  ///< barycentric
  std::array<double, triangle_rule.size()> prediction;
};
[[nodiscard]] const std::array<BorderPoint, 6>& triangle_border();

/// A half-plane that holds no point of either rule takes at most 0.018 of the triangle's area; the share of a
/// triangle that a wrong prediction is taken to err on.
inline constexpr double border_share = 0.05;

}  // namespace isopach
