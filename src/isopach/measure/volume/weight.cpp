#include "isopach/measure/volume/weight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/volume/quadrature.hpp"
#include "isopach/measure/volume/weight_parts.hpp"

namespace isopach {

namespace weighing {
namespace {

constexpr std::size_t block = 1 << 10;
constexpr std::size_t most_pieces = 1 << 20, most_pieces_of_part = 1 << 9, least_pieces_of_part = 16;

// --- where the parts come from --------------------------------------------------------------------------------------

double slope(const Point2& a, const Point2& b, const Point2& c, double za, double zb, double zc) {
  const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y, det = bx * cy - by * cx;
  if (!(det > 0)) return 0;
  return std::hypot((zb - za) * cy - (zc - za) * by, (zc - za) * bx - (zb - za) * cx) / det;
}

double slope_of(const OverlayMesh& m, Index triangle) {
  const auto& v = m.t.triangles[triangle].v;
  return slope(m.xy[v[0]], m.xy[v[1]], m.xy[v[2]], m.z[v[0]], m.z[v[1]], m.z[v[2]]);
}

struct CommonParts {
  const CellView& cells;
  std::span<const double> mu;
  std::vector<std::size_t> order = items_in_order(cells);

  [[nodiscard]] std::size_t items() const { return order.size(); }
  template <class F>
  void for_parts(std::size_t begin, std::size_t end, F&& f) const {
    for (std::size_t i = begin; i < end; ++i) f(i, part_of(of_item(cells, order[i])));
  }

 private:
  [[nodiscard]] Part part_of(const CommonCell& cell) const {
    Part part{cell.cell().area, {}, 0, 0};
    const std::array<double, 3> weights = mu.empty() ? std::array<double, 3>{} : cell.at_corners(mu);
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner corner = cell.corner(k);
      part.v[k] = {corner.x, corner.y, corner.z1, corner.d(), weights[k]};
    }
    const std::array<Index, 3> v = cells.corners(cell.triangle);
    const auto of = [&](std::span<const double> z) {
      return slope(cells.xy[v[0]], cells.xy[v[1]], cells.xy[v[2]], z[v[0]], z[v[1]], z[v[2]]);
    };
    part.slope1 = of(cells.z1), part.slope2 = of(cells.z2);
    return part;
  }
};

struct OverlayParts {
  const OverlayCells& cells;
  const OverlayNodeWeight& weight;

  [[nodiscard]] std::size_t items() const { return items_of(cells); }
  template <class F>
  void for_parts(std::size_t begin, std::size_t end, F&& f) const {
    for_overlay(cells, begin, end, [&](const OverlayCell& c, std::size_t item) {
      for_parts_of(c, [&](const Part& part) { f(item, part); });
    });
  }

 private:
  template <class F>
  void for_parts_of(const OverlayCell& c, F&& f) const {
    Part part{0, {}, slope_of(weight.m1, c.t1), slope_of(weight.m2, c.t2)};
    for (unsigned k = 2; k < c.corners; ++k) {
      part.area = 0.5 * ((c.x[k - 1] - c.x[0]) * (c.y[k] - c.y[0]) - (c.y[k - 1] - c.y[0]) * (c.x[k] - c.x[0]));
      if (!(part.area > 0)) continue;  // without area but for rounding
      part.v = {vertex(c, 0), vertex(c, k - 1), vertex(c, k)};
      f(part);
    }
  }
  [[nodiscard]] Vertex vertex(const OverlayCell& c, unsigned k) const {
    const double x = c.origin.x + c.x[k], y = c.origin.y + c.y[k];
    return {x, y, c.z1[k], c.d(k), weight.of_node.empty() ? 0 : linear(c, {x, y})};
  }
  /// μ in a triangle, never outside the range of its corners.
  [[nodiscard]] double linear(const OverlayCell& cell, const Point2& p) const {
    const OverlayMesh& m = weight.of_2 ? weight.m2 : weight.m1;
    const auto& v = m.t.triangles[weight.of_2 ? cell.t2 : cell.t1].v;
    const std::span<const double> mu = weight.of_node;
    const Point2 &a = m.xy[v[0]], &b = m.xy[v[1]], &c = m.xy[v[2]];
    const double wa = triangle_area(p, b, c), wb = triangle_area(p, c, a), wc = triangle_area(p, a, b);
    const auto [low, high] = std::minmax({mu[v[0]], mu[v[1]], mu[v[2]]});
    const double value = mu[v[0]] + (wb * (mu[v[1]] - mu[v[0]]) + wc * (mu[v[2]] - mu[v[0]])) / (wa + wb + wc);
    return std::isfinite(value) ? std::clamp(value, low, high) : mu[v[0]];
  }
};

// --- what is integrated over a part on which d has one sign ---------------------------------------------------------

struct LinearParts {
  [[nodiscard]] Amounts operator()(const Part& p, std::optional<Refusal>&) const {
    const auto& v = p.v;
    const double d0 = std::fabs(v[0].d), d1 = std::fabs(v[1].d), d2 = std::fabs(v[2].d);
    const double mu = v[0].mu + v[1].mu + v[2].mu;
    // ∬ d μ = A/12 (Σ di μi + Σ di Σ μi): positive terms alone.
    const double d_mu = d0 * v[0].mu + d1 * v[1].mu + d2 * v[2].mu + (d0 + d1 + d2) * mu;
    return {p.area / 3 * mu, p.area / 12 * d_mu, 0, 0};
  }
};

class ExpressionParts {
 public:
  explicit ExpressionParts(const ExpressionWeight& weight) : formula_(weight.formula), origin_(weight.origin) {}

  [[nodiscard]] Amounts operator()(const Part& p, std::optional<Refusal>& refused) {
    std::array<double, triangle_rule.size()> value;
    double mu = 0, d_mu = 0, mu_low = 0, d_mu_low = 0;
    for (std::size_t k = 0; k < value.size(); ++k) {
      const QuadraturePoint& q = triangle_rule[k];
      value[k] = at(p, q.at, refused);
      const double d_value = value[k] * std::fabs(along(p, q.at, &Vertex::d));
      mu += q.high * value[k], d_mu += q.high * d_value;
      mu_low += q.low * value[k], d_mu_low += q.low * d_value;
    }
    double surprise = 0;
    for (const BorderPoint& b : border_) {
      double predicted = 0;
      for (std::size_t k = 0; k < value.size(); ++k) predicted += b.prediction[k] * value[k];
      surprise = std::max(surprise, std::fabs(predicted - at(p, b.at, refused)));
    }
    constexpr double rounding = 0x1p-50;
    surprise = std::max(0.0, surprise - 64 * rounding * mu) * border_share;
    const double most_d = std::max({std::fabs(p.v[0].d), std::fabs(p.v[1].d), std::fabs(p.v[2].d)});
    return {p.area * mu, p.area * d_mu, p.area * (std::fabs(mu - mu_low) + surprise + rounding * mu),
            p.area * (std::fabs(d_mu - d_mu_low) + surprise * most_d + rounding * d_mu)};
  }

 private:
  [[nodiscard]] static double along(const Part& p, const std::array<double, 3>& at, double Vertex::*what) {
    return at[0] * (p.v[0].*what) + at[1] * (p.v[1].*what) + at[2] * (p.v[2].*what);
  }
  /// μ at a point of the part; 0 where it is none, which is noted.
  [[nodiscard]] double at(const Part& p, const std::array<double, 3>& point, std::optional<Refusal>& refused) {
    const double z1 = along(p, point, &Vertex::z1) + origin_.z;
    const Place place{along(p, point, &Vertex::x) + origin_.x,
                      along(p, point, &Vertex::y) + origin_.y,
                      z1,
                      z1 + along(p, point, &Vertex::d),
                      p.slope1,
                      p.slope2};
    const double value = formula_(place);
    if (value >= 0 && !std::isinf(value)) return value;
    using Why = Refusal::Why;
    if (!refused) refused = Refusal{std::isfinite(value) ? Why::negative : Why::not_finite, place.x, place.y, value};
    return 0;
  }

  Formula formula_;
  Point3 origin_;
  const std::array<BorderPoint, 6>& border_ = triangle_border();
};

// --- sums -----------------------------------------------------------------------------------------------------------

struct Totals {
  Sum area, mu, above, below, mu_error, d_error;
  std::optional<Refusal> refused;

  void add(const Part& part, const Amounts& a) {
    const bool is_above = part.v[0].d > 0 || part.v[1].d > 0 || part.v[2].d > 0;
    mu.add(a.mu), mu_error.add(a.mu_error);
    (is_above ? above : below).add(a.d), d_error.add(a.d_error);
  }
  void add(const Totals& t) {
    area.add(t.area), mu.add(t.mu), above.add(t.above), below.add(t.below);
    mu_error.add(t.mu_error), d_error.add(t.d_error);
    if (!refused) refused = t.refused;
  }
  [[nodiscard]] double gross() const { return above.value() + below.value(); }
};

/// The largest errors per area among the parts of an item.
struct ErrorDensity {
  float mu = 0, d = 0;
};

/// What a part may err, per area and in units of the integrals: 1 is the whole integral, spread evenly.
struct Goal {
  double per_mu = 0, per_d = 0;  // 1 ÷ the integrals; 0 where there is none
  double per_area = 0;           // tolerance ÷ area
  std::size_t pieces = 1;        // most, of one part

  [[nodiscard]] double score(const Amounts& a) const { return std::max(a.mu_error * per_mu, a.d_error * per_d); }
  [[nodiscard]] bool missed(const ErrorDensity& e) const {
    return std::max(static_cast<double>(e.mu) * per_mu, static_cast<double>(e.d) * per_d) > per_area;
  }
};

struct Leaf {
  double score;
  Part part;
  Amounts amounts;
};

/// Quarters the piece with the largest error until the part is good enough or the pieces run out.
template <class Integrate>
Amounts refined(const Part& part, const Goal& goal, Integrate& integrate, std::optional<Refusal>& refused) {
  const auto worse = [](const Leaf& p, const Leaf& q) { return p.score < q.score; };
  const Amounts first = integrate(part, refused);
  std::vector<Leaf> heap{{goal.score(first), part, first}};
  double error = heap[0].score;
  while (error > goal.per_area * part.area && heap.size() < goal.pieces) {
    std::pop_heap(heap.begin(), heap.end(), worse);
    const Leaf leaf = heap.back();
    heap.pop_back();
    error -= leaf.score;
    const auto& [a, b, c] = leaf.part.v;
    const Vertex ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const std::array<Vertex, 3>& v : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) {
      const Part quarter{leaf.part.area / 4, v, part.slope1, part.slope2};
      const Amounts amounts = integrate(quarter, refused);
      heap.push_back({goal.score(amounts), quarter, amounts});
      error += heap.back().score;
      std::push_heap(heap.begin(), heap.end(), worse);
    }
  }
  Sum mu, d, mu_error, d_error;
  for (const Leaf& leaf : heap) {
    mu.add(leaf.amounts.mu), d.add(leaf.amounts.d);
    mu_error.add(leaf.amounts.mu_error), d_error.add(leaf.amounts.d_error);
  }
  return {mu.value(), d.value(), mu_error.value(), d_error.value()};
}

template <class Source, class Integrate>
Totals sum_block(const Source& source, Integrate& integrate, std::size_t begin, std::size_t end, ErrorDensity* density,
                 const Goal* goal) {
  Totals t;
  source.for_parts(begin, end, [&](std::size_t item, const Part& whole) {
    t.area.add(whole.area);
    for_each_sign(whole, [&](const Part& part) {
      const Amounts a = goal != nullptr && goal->missed(density[item]) ? refined(part, *goal, integrate, t.refused)
                                                                       : integrate(part, t.refused);
      t.add(part, a);
      if (goal != nullptr || density == nullptr) return;
      ErrorDensity& e = density[item];
      e.mu = std::max(e.mu, static_cast<float>(a.mu_error / part.area));
      e.d = std::max(e.d, static_cast<float>(a.d_error / part.area));
    });
  });
  return t;
}

[[noreturn]] void refuse(const Refusal& r, const std::string& name) {
  const std::string place = fmt::format("at x = {:.10g}, y = {:.10g}", r.x, r.y);
  switch (r.why) {
    case Refusal::Why::negative:
      throw UsageError(
          fmt::format("@weight: {} is {:.6g} {}: weights are 0 or more, e.g. max(0, ...)", name, r.value, place));
    case Refusal::Why::not_finite:
      throw UsageError(fmt::format("@weight: {} has no finite value {}: give one that has everywhere", name, place));
    case Refusal::Why::no_data:
      break;
  }
  throw InputError(
      fmt::format("@weight: {} has no value {}: it must cover the whole domain; fill its gaps, or @crop", name, place));
}

Totals combined(const std::vector<Totals>& blocks) {
  Totals t;
  for (const Totals& part : blocks) t.add(part);
  return t;
}

WeightedMeasures result_of(const Totals& t) {
  WeightedMeasures m;
  const double area = t.area.value();
  m.integral = t.mu.value();
  m.above = t.above.value();
  m.below = t.below.value();
  m.net = m.above - m.below;
  m.integral_error = t.mu_error.value();
  if (!(area > 0)) return m;
  m.rho = t.gross() / area;
  m.error_estimate = t.d_error.value() / area;
  return m;
}

template <class Source, class Make>
Totals first_pass(const Source& source, const Make& make, std::vector<Totals>& blocks, ErrorDensity* density) {
  blocks.resize((source.items() + block - 1) / block);
  for_blocks(source.items(), block, [&](std::size_t begin, std::size_t end) {
    auto integrate = make();
    blocks[begin / block] = sum_block(source, integrate, begin, end, density, nullptr);
  });
  return combined(blocks);
}

/// Those blocks again that hold items whose error is too large.
template <class Source, class Make>
Totals second_pass(const Source& source, const Make& make, std::vector<Totals>& blocks, Array<ErrorDensity>& density,
                   const Totals& first) {
  const auto inverse = [](double v) { return v > 0 ? 1 / v : 0; };
  Goal goal{inverse(first.mu.value()), inverse(first.gross()), weight_tolerance / first.area.value()};
  const auto missed = [&](const ErrorDensity& e) { return goal.missed(e); };
  const auto count = static_cast<std::size_t>(std::count_if(density.begin(), density.end(), missed));
  if (count == 0) return first;
  goal.pieces = std::clamp(most_pieces / count, least_pieces_of_part, most_pieces_of_part);
  for_blocks(source.items(), block, [&](std::size_t begin, std::size_t end) {
    if (std::none_of(density.begin() + static_cast<std::ptrdiff_t>(begin),
                     density.begin() + static_cast<std::ptrdiff_t>(end), missed))
      return;
    auto integrate = make();
    blocks[begin / block] = sum_block(source, integrate, begin, end, density.data(), &goal);
  });
  return combined(blocks);
}

template <class Source>
WeightedMeasures weigh(const Source& source, const Weight& weight, const Context& context) {
  context.check();
  std::vector<Totals> blocks;
  Totals t;
  if (const auto* expression = std::get_if<ExpressionWeight>(&weight)) {
    const auto make = [&] { return ExpressionParts(*expression); };
    Array<ErrorDensity> density(source.items());
    std::fill(density.begin(), density.end(), ErrorDensity{});
    t = first_pass(source, make, blocks, density.data());
    if (t.refused) refuse(*t.refused, "'" + expression->text + "'");
    context.check();
    if (t.mu_error.value() > weight_tolerance * t.mu.value() || t.d_error.value() > weight_tolerance * t.gross())
      t = second_pass(source, make, blocks, density, t);
    if (t.refused) refuse(*t.refused, "'" + expression->text + "'");
  } else if (const auto* raster = std::get_if<RasterWeight>(&weight)) {
    t = first_pass(
        source, [&] { return RasterParts(*raster); }, blocks, nullptr);
    if (t.refused) refuse(*t.refused, raster->path);
  } else {
    t = first_pass(
        source, [] { return LinearParts(); }, blocks, nullptr);
  }
  return result_of(t);
}

}  // namespace
}  // namespace weighing

const char* to_text(WeightSource::Kind kind) {
  switch (kind) {
    case WeightSource::Kind::none:
      return "none";
    case WeightSource::Kind::expression:
      return "expression";
    case WeightSource::Kind::attribute:
      return "attribute";
    case WeightSource::Kind::raster:
      return "raster";
  }
  return "";
}

std::string to_text(const WeightSource& source) {
  using Scan = WeightSource::Scan;
  const char* scan = source.scan == Scan::a ? "a:" : source.scan == Scan::b ? "b:" : "";
  return source.kind == WeightSource::Kind::attribute ? "@" + (scan + source.text) : source.text;
}

WeightedMeasures weigh(const CellView& cells, std::span<const double> at_nodes, const Weight& weight,
                       const Context& context) {
  return weighing::weigh(weighing::CommonParts{cells, at_nodes}, weight, context);
}

WeightedMeasures weigh(const OverlayCells& cells, const OverlayNodeWeight& at_nodes, const Weight& weight,
                       const Context& context) {
  return weighing::weigh(weighing::OverlayParts{cells, at_nodes}, weight, context);
}

}  // namespace isopach
