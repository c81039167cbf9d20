#include <algorithm>

#include "isopach/measure/volume/quadrature.hpp"
#include "isopach/measure/volume/weight_parts.hpp"

namespace isopach::weighing {

namespace {

/// Four neighbouring centres. On the outermost half of the outermost cells two of them are one.
struct Patch {
  std::array<std::size_t, 2> column, row;
};

std::array<std::size_t, 2> neighbours(double at, std::size_t count) {
  const double low = std::floor(at), last = static_cast<double>(count - 1);
  return {static_cast<std::size_t>(std::clamp(low, 0.0, last)),
          static_cast<std::size_t>(std::clamp(low + 1, 0.0, last))};
}

}  // namespace

RasterParts::RasterParts(const RasterWeight& weight) : values_(weight.values), origin_(weight.origin) {
  const auto& g = values_.grid().geotransform;
  det_ = g[1] * g[5] - g[2] * g[4];
}

/// What of a convex polygon lies below or above a line of constant column or row.
RasterParts::Polygon RasterParts::side_of(const Polygon& p, double Corner::*axis, double line, bool below) {
  Polygon out;
  const auto inside = [&](const Corner& c) { return below ? c.*axis <= line : c.*axis >= line; };
  for (unsigned k = 0; k < p.corners; ++k) {
    const Corner &a = p.at[k], &b = p.at[(k + 1) % p.corners];
    if (inside(a)) out.at[out.corners++] = a;
    if (inside(a) == inside(b) || a.*axis == line || b.*axis == line) continue;
    const double t = (line - a.*axis) / (b.*axis - a.*axis);
    Corner cut{a.column + t * (b.column - a.column), a.row + t * (b.row - a.row), a.d + t * (b.d - a.d)};
    cut.*axis = line;
    out.at[out.corners++] = cut;
  }
  return out;
}

/// f(polygon, was it cut) for the strips between the lines through the centres: numbers 0 to count − 1, from `base`.
template <class F>
void RasterParts::for_strips(const Polygon& p, double Corner::*axis, double base, std::size_t count, F&& f) {
  double least = p.at[0].*axis, most = least;
  for (unsigned k = 1; k < p.corners; ++k) least = std::min(least, p.at[k].*axis), most = std::max(most, p.at[k].*axis);
  Polygon rest = p;
  bool is_cut = false;
  const double last = std::min(static_cast<double>(count - 1), std::floor(base + most));
  for (double line = std::max(0.0, std::ceil(base + least)); line <= last; ++line) {
    const double at = line - base;
    if (at <= least || at >= most) continue;
    is_cut = true;
    const Polygon strip = side_of(rest, axis, at, true);
    if (strip.corners > 2) f(strip, true);
    rest = side_of(rest, axis, at, false);
  }
  if (rest.corners > 2) f(rest, is_cut);
}

/// Exact on one patch: μ is bilinear, d μ of degree 3. `known_area` < 0: from the corners.
void RasterParts::add_patch(const Polygon& p, double known_area, const Part& part, Amounts& sum,
                            std::optional<Refusal>& refused) const {
  const auto& g = values_.grid().geotransform;
  const double x0 = part.v[0].x + origin_.x - g[0], y0 = part.v[0].y + origin_.y - g[3];
  const double column0 = (x0 * g[5] - y0 * g[2]) / det_ - 0.5, row0 = (y0 * g[1] - x0 * g[4]) / det_ - 0.5;
  double column = 0, row = 0;
  for (unsigned k = 0; k < p.corners; ++k) column += p.at[k].column, row += p.at[k].row;
  column = column0 + column / p.corners, row = row0 + row / p.corners;
  const Patch patch{neighbours(column, values_.grid().columns), neighbours(row, values_.grid().rows)};
  std::array<std::array<double, 2>, 2> mu{};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j) {
      double& value = mu[i][j] = values_.value(patch.column[i], patch.row[j]);
      if (value >= 0) continue;
      const double c = column + 0.5, r = row + 0.5;
      if (!refused)
        refused = Refusal{std::isnan(value) ? Refusal::Why::no_data : Refusal::Why::negative,
                          g[0] + c * g[1] + r * g[2], g[3] + c * g[4] + r * g[5], value};
      value = 0;
    }
  const double left = std::floor(column), top = std::floor(row);
  const auto mu_at = [&](double c, double r) {
    const double s = column0 + c - left, t = row0 + r - top;
    return (1 - t) * ((1 - s) * mu[0][0] + s * mu[1][0]) + t * ((1 - s) * mu[0][1] + s * mu[1][1]);
  };
  const Corner& a = p.at[0];
  for (unsigned k = 2; k < p.corners; ++k) {
    const Corner &b = p.at[k - 1], &c = p.at[k];
    const double twice = std::fabs((b.column - a.column) * (c.row - a.row) - (b.row - a.row) * (c.column - a.column));
    const double area = known_area >= 0 ? known_area : twice / 2 * std::fabs(det_);
    double of_mu = 0, of_d = 0;
    for (const QuadraturePoint& q : triangle_rule) {
      if (q.low == 0) continue;
      const auto at = [&](double Corner::*what) {
        return q.at[0] * (a.*what) + q.at[1] * (b.*what) + q.at[2] * (c.*what);
      };
      const double value = q.low * mu_at(at(&Corner::column), at(&Corner::row));
      of_mu += value, of_d += value * at(&Corner::d);
    }
    sum.mu += area * of_mu, sum.d += area * of_d;
  }
}

Amounts RasterParts::operator()(const Part& part, std::optional<Refusal>& refused) const {
  const RasterGrid& grid = values_.grid();
  const auto& g = grid.geotransform;
  const double x0 = part.v[0].x + origin_.x - g[0], y0 = part.v[0].y + origin_.y - g[3];
  const double column0 = (x0 * g[5] - y0 * g[2]) / det_ - 0.5, row0 = (y0 * g[1] - x0 * g[4]) / det_ - 0.5;
  Polygon whole;
  whole.corners = 3;
  constexpr double rim = 0.5 + 1e-6;  // cells: what coordinates of a border lose by rounding is no gap
  for (std::size_t k = 0; k < 3; ++k) {
    const Vertex& v = part.v[k];
    const double dx = v.x - part.v[0].x, dy = v.y - part.v[0].y;  // differences: small cells keep their digits
    whole.at[k] = {(dx * g[5] - dy * g[2]) / det_, (dy * g[1] - dx * g[4]) / det_, std::fabs(v.d)};
    const double column = column0 + whole.at[k].column, row = row0 + whole.at[k].row;
    if (column >= -rim && row >= -rim && column <= static_cast<double>(grid.columns) - 1 + rim &&
        row <= static_cast<double>(grid.rows) - 1 + rim)
      continue;
    if (!refused) refused = Refusal{Refusal::Why::no_data, v.x + origin_.x, v.y + origin_.y, std::nan("")};
    return {};
  }
  Amounts sum;
  for_strips(whole, &Corner::column, column0, grid.columns, [&](const Polygon& strip, bool cut) {
    for_strips(strip, &Corner::row, row0, grid.rows, [&](const Polygon& patch, bool cut_again) {
      add_patch(patch, cut || cut_again ? -1 : part.area, part, sum, refused);
    });
  });
  return sum;
}

}  // namespace isopach::weighing
