// fit_form: the form of a scan as a polynomial in x and y (the F-operation of ISO 25178-2).
#pragma once
#include <span>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

inline constexpr unsigned most_form_degree = 8;

/// A sum of products of Legendre polynomials in the box of the scan, total degree `degree`.
class Form {
 public:
  Form() = default;
  Form(unsigned degree, const Box2& box);

  [[nodiscard]] double at(const Point2& p) const;
  [[nodiscard]] unsigned degree() const { return degree_; }
  [[nodiscard]] static std::size_t terms(unsigned degree) { return (degree + 1) * (degree + 2) / 2; }

  /// The terms at p, by rising degree: 1, x, y, …
  void basis(const Point2& p, std::span<double> values) const;

  std::vector<double> coefficients;

 private:
  unsigned degree_ = 0;
  Point2 middle_{0, 0}, half_{1, 1};
};

/// The polynomial of this degree that is nearest to the heights by least squares, each node with the weight `area`
/// (those of weight 0 do not count). Removing it takes every polynomial of the degree out to rounding, and nothing that
/// is orthogonal to those. Normal equations in compensated sums, solved twice. Degenerate: where the nodes do not tell
/// all terms apart (few, or on a line), the least of the solutions; without nodes 0. Errors: UsageError for a degree
/// above most_form_degree. Cost O(nodes · terms²). Oracle: tests/measure/form_test.cpp.
[[nodiscard]] Form fit_form(std::span<const Point2> xy, std::span<const double> area, std::span<const double> z,
                            unsigned degree, const Context& context);

}  // namespace isopach
