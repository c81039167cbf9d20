// weight: the measure with a weight μ ≥ 0, ρ_Vμ = Σ ∬ |d| μ / S (docs/use/weights.md; equation (6) of the paper). S is
// the area of the domain, not ∬ μ, which is reported beside it. Every cell is cut along d = 0, so the absolute value is
// never integrated across its kink. Then, by what the weight is:
//   linear      given at the nodes (an attribute of the points): ∬ d μ of a triangle in closed form
//   raster      bilinear between the centres of its cells: cut along the lines through those centres; on each piece d μ
//               is a polynomial of degree 3, for which quadrature is exact
//   expression  quadrature of degree 8, checked by one of degree 5 (quadrature.hpp): both are exact where μ is a
//               polynomial of degree 4. Where they differ, or μ at the border of a piece is not what they predict, the
//               worst piece is quartered, again and again
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <variant>

#include "isopach/base/context.hpp"
#include "isopach/cloud/raster_values.hpp"
#include "isopach/geom/place.hpp"
#include "isopach/measure/measures.hpp"

namespace isopach {

/// μ of a place. Each task has a copy of its own, so it may write to itself. Same results need a function of the place
/// alone. io/expression.hpp reads one from text.
using Formula = std::function<double(const Place&)>;

/// What the user named as the weight, with what was read of it.
struct WeightSource {
  enum class Kind { none, expression, attribute, raster } kind = Kind::none;
  enum class Scan { any, a, b } scan = Scan::any;  ///< attribute: any = of B if it has it, else of A
  std::string text;           ///< names it in messages and results: the formula, the name of the attribute, or the path
  Formula formula = nullptr;  ///< for an expression
  std::optional<RasterValues> raster = std::nullopt;  ///< for a raster, in x and y of the input
};
/// As it was given: "x > 5", "@b:intensity", "weights.tif"; empty for none.
[[nodiscard]] std::string to_text(const WeightSource& source);

[[nodiscard]] const char* to_text(WeightSource::Kind kind);

struct WeightedMeasures {
  double integral = 0;          ///< ∬ μ
  double above = 0, below = 0;  ///< ∬ max(d, 0) μ, ∬ max(−d, 0) μ
  double net = 0;               ///< above − below
  double rho = 0;               ///< (above + below) / area of the domain
  double error_estimate = 0;    ///< of rho: Σ |difference of the two rules| / area; 0 where exact but for rounding
  double integral_error = 0;    ///< of integral, likewise
};

/// μ as it is evaluated. `origin` is added to frame coordinates to give x, y and heights of the input.
struct LinearWeight {};  ///< the values stand with the cells
struct ExpressionWeight {
  std::string text;  ///< for messages
  Formula formula;
  Point3 origin{};
};
struct RasterWeight {
  const RasterValues& values;
  std::string path;  ///< for messages
  Point3 origin{};
};
using Weight = std::variant<LinearWeight, ExpressionWeight, RasterWeight>;

/// An expression is refined until the estimated error of ∬ |d| μ and of ∬ μ is this part of them, or the pieces run
/// out (about a million in all): what error is left is reported.
inline constexpr double weight_tolerance = 1e-7;

/// Weighted integrals over the cells of T. `at_nodes`: μ at the nodes of T, for a LinearWeight; empty otherwise. Slopes
/// are those of the cells. Errors, naming --weight and the place: a value below 0 or not finite, or a place that the
/// raster has no value for (UsageError, InputError). Same bits for any number of threads. Cost O(cells + cells of the
/// raster in the domain). Oracle: tests/measure/weight_test.cpp (closed forms, refined quadrature).
[[nodiscard]] WeightedMeasures weigh(const CellView& cells, std::span<const double> at_nodes, const Weight& weight,
                                     const Context& context);

/// Meshes of an overlay, with a LinearWeight at the nodes of one of them; empty for other weights.
struct OverlayNodeWeight {
  const OverlayMesh &m1, &m2;
  std::span<const double> of_node = {};
  bool of_2 = false;  ///< of m2, else of m1
};

/// The same over the exact overlay. Slopes are those of the triangles of both meshes.
[[nodiscard]] WeightedMeasures weigh(const OverlayCells& cells, const OverlayNodeWeight& at_nodes, const Weight& weight,
                                     const Context& context);

}  // namespace isopach
