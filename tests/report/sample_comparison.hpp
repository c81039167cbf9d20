// A Comparison made by hand: a regular grid of nodes, each square cut in two, with given surfaces and domain. Measures
// by the closed form on each triangle; percentiles and histogram by sorting the triangles' mean |d|, good enough to be
// drawn.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>

#include "isopach/compare/comparison.hpp"

namespace isopach::sample {

struct Grid {
  int columns = 20, rows = 20;  // nodes
  double width = 10, height = 10;
  Point3 origin{0, 0, 0};
};
using Surface2 = std::function<double(double, double)>;
using Inside = std::function<bool(double, double)>;

struct Signed {
  double above = 0, below = 0;
};
inline Signed signed_volume(double area, std::array<double, 3> d) {
  std::sort(d.begin(), d.end());
  const double net = area * (d[0] + d[1] + d[2]) / 3;
  double above = 0;
  if (d[0] >= 0)
    above = net;
  else if (d[2] <= 0)
    above = 0;
  else if (d[1] <= 0)
    above = area * d[2] * d[2] * d[2] / (3 * (d[2] - d[0]) * (d[2] - d[1]));
  else
    above = net + area * d[0] * d[0] * d[0] / (3 * (d[1] - d[0]) * (d[0] - d[2])) * -1;
  return {above, above - net};
}

inline void fill_measures(Comparison& c) {
  struct Piece {
    double d, area;
  };
  std::vector<Piece> pieces;
  Measures& m = c.measures;
  m = {};
  double sum_d = 0, sum_square = 0;
  c.area_union = 0;
  for (Index t = 0; t < c.cells.triangulation.real; ++t) {
    const auto& v = c.cells.triangulation.triangles[t].v;
    const Point2 p = c.cells.xy[v[0]], q = c.cells.xy[v[1]], r = c.cells.xy[v[2]];
    const double area = ((q.x - p.x) * (r.y - p.y) - (r.x - p.x) * (q.y - p.y)) / 2;
    c.area_union += area;
    if (c.cells.in_domain[t] == 0) continue;
    const std::array<double, 3> d{c.cells.d(v[0]), c.cells.d(v[1]), c.cells.d(v[2])};
    const Signed s = signed_volume(area, d);
    m.area += area;
    m.volume.above += s.above;
    m.volume.below += s.below;
    sum_d += area * (d[0] + d[1] + d[2]) / 3;
    sum_square += area * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[0] * d[1] + d[1] * d[2] + d[2] * d[0]) / 6;
    for (const double x : d) {
      m.difference.max_above = std::max(m.difference.max_above, x);
      m.difference.max_below = std::max(m.difference.max_below, -x);
    }
    pieces.push_back({(d[0] + d[1] + d[2]) / 3, area});
  }
  c.domain_area = m.area;
  c.coverage = c.area_union > 0 ? m.area / c.area_union : 0;
  m.volume.net = m.volume.above - m.volume.below;
  m.volume.absolute = m.volume.above + m.volume.below;
  if (m.area == 0) return;
  m.rho = m.volume.absolute / m.area;
  DifferenceStatistics& s = m.difference;
  s.mean = sum_d / m.area;
  s.rms = std::sqrt(sum_square / m.area);
  s.std = std::sqrt(std::max(0.0, s.rms * s.rms - s.mean * s.mean));
  const auto quantile = [&](double share, auto&& value) {
    std::sort(pieces.begin(), pieces.end(), [&](const Piece& a, const Piece& b) { return value(a.d) < value(b.d); });
    double seen = 0;
    for (const Piece& x : pieces)
      if ((seen += x.area) >= share * m.area) return value(x.d);
    return value(pieces.back().d);
  };
  const auto magnitude = [](double d) { return std::fabs(d); };
  for (std::size_t i = 0; i < 4; ++i) s.abs_percentiles[i] = quantile(percentile_levels[i] / 100.0, magnitude);
  s.median = quantile(0.5, [](double d) { return d; });
  s.nmad = 1.4826 * quantile(0.5, [&](double d) { return std::fabs(d - s.median); });
  const double reach = s.abs_percentiles[3] > 0 ? 1.2 * s.abs_percentiles[3] : 1;
  constexpr int bins = 64;
  for (int i = 0; i <= bins; ++i) s.histogram.edges.push_back(reach * (2.0 * i / bins - 1));
  s.histogram.areas.assign(bins, 0);
  for (const Piece& x : pieces) {
    const int bin = std::clamp(static_cast<int>(std::floor((x.d / reach + 1) / 2 * bins)), 0, bins - 1);
    s.histogram.areas[static_cast<std::size_t>(bin)] += x.area;
  }
}

inline Comparison make(const Grid& grid, const Surface2& f1, const Surface2& f2, const Inside& inside = nullptr,
                       const std::string& unit = "m") {
  Comparison c;
  c.unit = unit;
  c.frame.origin = grid.origin;
  Cells& cells = c.cells;
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const double x = grid.width * column / (grid.columns - 1), y = grid.height * row / (grid.rows - 1);
      cells.xy.push_back({x, y});
      cells.z1.push_back(f1(x, y));
      cells.z2.push_back(f2(x, y));
    }
  const auto add = [&](int i, int j, int k) {
    const std::array<Index, 3> v{static_cast<Index>(i), static_cast<Index>(j), static_cast<Index>(k)};
    const Point2 p = cells.xy[v[0]], q = cells.xy[v[1]], r = cells.xy[v[2]];
    cells.triangulation.triangles.push_back({v, {no_index, no_index, no_index}});
    cells.in_domain.push_back(!inside || inside((p.x + q.x + r.x) / 3, (p.y + q.y + r.y) / 3));
  };
  for (int row = 0; row + 1 < grid.rows; ++row)
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const int i = row * grid.columns + column, up = i + grid.columns;
      add(i, i + 1, up + 1);
      add(i, up + 1, up);
    }
  cells.triangulation.real = static_cast<Index>(cells.triangulation.triangles.size());
  cells.triangulation.nodes = static_cast<Index>(cells.xy.size());
  fill_measures(c);
  c.common = cells.triangulation.real;
  c.t1 = c.t2 = c.common / 2;
  c.interface = c.common / 3;
  c.visited_1_in_2 = 12345;
  c.visited_2_in_1 = 23456;
  for (InputSummary* in : {&c.a, &c.b}) {
    in->unit = in->vertical_unit = unit;
    in->format = "xyz";
    in->points = in->nodes = in->cleaning.points = cells.xy.size();
    in->bounds.add(grid.origin);
    in->bounds.add(Point3{grid.origin.x + grid.width, grid.origin.y + grid.height, grid.origin.z + 5});
  }
  c.a.role = "A", c.a.path = "survey/before.laz";
  c.b.role = "B", c.b.path = "survey/after.laz";
  c.timing.stages = {{"read", 0.25}, {"project", 0.125}, {"read", 0.5}, {"delaunay", 0.0625}};
  c.timing.total = 1.5;
  return c;
}

}  // namespace isopach::sample
