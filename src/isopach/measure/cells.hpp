// The cells of either surface as a stream of triangles with d at their corners: what all measures are sums over. A
// source has items, which are handed out in fixed blocks; for_cells calls f(const Cell&) for every cell of a block, in
// a fixed order.
#pragma once
#include <algorithm>

#include "isopach/measure/measures.hpp"
#include "isopach/overlay/overlay.hpp"

namespace isopach {

[[nodiscard]] inline std::size_t items_of(const CellView& cells) { return cells.t.real + cells.pieces.size(); }
[[nodiscard]] inline std::size_t items_of(const Overlay& overlay) { return overlay.items(); }

template <class F>
void for_cells(const CellView& cells, std::size_t begin, std::size_t end, F&& f) {
  const std::size_t whole = cells.t.real;
  for (std::size_t i = begin; i < std::min(end, whole); ++i)
    if (cells.in_domain[i] != 0) f(cell_at(cells, i));
  for (std::size_t i = std::max(begin, whole); i < end; ++i) f(cell_of(cells.pieces[i - whole]));
}

/// A polygon is cut into triangles from its first corner, 0: f(a, b, area) for each triangle of the corners 0, a, b.
template <class F>
void for_triangles(const OverlayCell& c, F&& f) {
  const double x0 = c.x[0], y0 = c.y[0];
  double x1 = c.x[1] - x0, y1 = c.y[1] - y0;
  for (unsigned k = 2; k < c.corners; ++k) {
    const double x2 = c.x[k] - x0, y2 = c.y[k] - y0;
    const double area = 0.5 * (x1 * y2 - y1 * x2);
    if (area > 0) f(k - 1, k, area);  // without area but for rounding: corners that coincide or are in line
    x1 = x2, y1 = y2;
  }
}

template <class F>
void for_cells(const OverlayCell& c, F&& f) {
  const double d0 = c.d(0);
  for_triangles(c, [&](unsigned a, unsigned b, double area) { f(Cell{area, {d0, c.d(a), c.d(b)}}); });
}

template <class F>
void for_cells(const Overlay& overlay, std::size_t begin, std::size_t end, F&& f) {
  Overlay::Scratch scratch;
  for (std::size_t i = begin; i < end; ++i)
    for (const OverlayCell& c : overlay.cells(i, scratch)) for_cells(c, f);
}

/// The same cell with ascending values.
[[nodiscard]] inline Cell sorted(Cell cell) {
  auto& d = cell.d;
  const double low = std::min(d[0], d[1]), high = std::max(d[0], d[1]);
  cell.d = {std::min(low, d[2]), std::max(low, std::min(high, d[2])), std::max(high, d[2])};
  return cell;
}

}  // namespace isopach
