// The two sources of cells that every measure is a sum over, each within its domain:
//   CellView      cells of the common triangulation T, and pieces of those that the domain holds a part of
//   OverlayCells  cells of the exact overlay of T1 and T2, cut by the domain as they are asked for
// A source has items, which are handed out in fixed blocks; the functions for_… call f for every cell of a block, in a
// fixed order. Whoever asks them cannot forget a piece or the domain.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/geom/coordinate_hash.hpp"
#include "isopach/measure/domain.hpp"
#include "isopach/measure/measures.hpp"
#include "isopach/overlay/overlay.hpp"

namespace isopach {

/// The cells of the exact overlay that lie in the domain.
struct OverlayCells {
  const Overlay& overlay;
  const Domain& domain;

  OverlayCells(const Overlay& of, const Domain& within) : overlay(of), domain(within) {}
  OverlayCells(const Overlay& of) : OverlayCells(of, Domain::everything()) {}  // NOLINT: an overlay is all its cells
};

/// Of the heights and the box of both meshes. Cost O(nodes).
[[nodiscard]] SumBounds bounds_of(const OverlayCells& cells);

[[nodiscard]] inline std::size_t items_of(const CellView& cells) { return cells.t.real + cells.pieces.size(); }
[[nodiscard]] inline std::size_t items_of(const OverlayCells& cells) { return cells.overlay.items(); }

[[nodiscard]] ConvexCell convex(const CellView& cells, std::size_t triangle);
[[nodiscard]] ConvexCell convex(const CellPiece& piece);
[[nodiscard]] ConvexCell convex(const OverlayCell& cell);

// --- cells of T ---
// Values given at its nodes can be asked for.

/// A cell of T in its domain: a triangle of T, or a piece of one. Corner 0 is the first on the curve.
struct CommonCell {
  const CellView& cells;
  Index triangle;
  const CellPiece* piece;  ///< null: the whole triangle

  [[nodiscard]] Cell cell() const { return piece != nullptr ? cell_of(*piece) : cell_at(cells, triangle); }
  [[nodiscard]] ConvexCell convex() const {
    return piece != nullptr ? isopach::convex(*piece) : isopach::convex(cells, triangle);
  }
  /// Corner k with both surfaces.
  [[nodiscard]] Corner corner(std::size_t k) const {
    if (piece != nullptr) return piece->at[k];
    const Index v = cells.corners(triangle)[k];
    return {cells.xy[v].x, cells.xy[v].y, cells.z1[v], cells.z2[v]};
  }
  /// Values given at the nodes of T, at the three corners.
  [[nodiscard]] std::array<double, 3> at_corners(std::span<const double> of_node) const;
  /// f(node, share) for the nodes that take part in the value at corner k.
  template <class F>
  void for_nodes(std::size_t k, F&& f) const {
    const std::array<Index, 3> v = cells.corners(triangle);
    if (piece == nullptr) return f(v[k], 1.0);
    const auto shares = shares_of_nodes(k);
    for (std::size_t j = 0; j < 3; ++j) f(v[j], shares[j]);
  }

  /// The same for the height of surface `scan` there, where it is that of a border of the scan.
  template <class F>
  void for_border_nodes(std::size_t scan, std::size_t k, F&& f) const {
    const SideEnds& ends = piece->border[scan][k];
    const double share = share_of_side(ends, piece->at[k]);
    f(ends[0], 1 - share), f(ends[1], share);
  }
  [[nodiscard]] bool on_border(std::size_t scan, std::size_t k) const {
    return piece != nullptr && piece->border[scan][k][0] != no_index;
  }

 private:
  [[nodiscard]] std::array<double, 3> shares_of_nodes(std::size_t k) const;  // barycentric
  [[nodiscard]] double share_of_side(const SideEnds& ends, const Corner& at) const;
};

/// By item: a triangle, or a piece of one.
[[nodiscard]] inline CommonCell of_item(const CellView& cells, std::size_t item) {
  const std::size_t whole = cells.t.real;
  if (item < whole) return {cells, static_cast<Index>(item), nullptr};
  return {cells, cells.pieces[item - whole].cell, &cells.pieces[item - whole]};
}

[[nodiscard]] inline CommonCell of_piece(const CellView& cells, const CellPiece& piece) {
  return {cells, piece.cell, &piece};
}

/// f(CommonCell, item) for the cells of a block of items: triangles first, then pieces.
template <class F>
void for_common(const CellView& cells, std::size_t begin, std::size_t end, F&& f) {
  const std::size_t whole = cells.t.real;
  for (std::size_t i = begin; i < std::min(end, whole); ++i)
    if (cells.in_domain[i] != 0) f(CommonCell{cells, static_cast<Index>(i), nullptr}, i);
  for (std::size_t i = std::max(begin, whole); i < end; ++i) {
    const CellPiece& piece = cells.pieces[i - whole];
    f(of_piece(cells, piece), i);
  }
}
/// … for all of them, one after the other.
template <class F>
void for_common(const CellView& cells, F&& f) {
  for_common(cells, 0, items_of(cells), [&](const CommonCell& c, std::size_t) { f(c); });
}

/// The items that have cells, ordered by the corners of their triangles, then pieces in the order of theirs: the same
/// sequence of cells however T was made. For sums that are not exact. Cost O(nodes + cells), and an index for each.
[[nodiscard]] std::vector<std::size_t> items_in_order(const CellView& cells);

/// Cuts the cells whose flag is set: those not left whole lose it, and their pieces are returned, in the order of the
/// cells, and behind them what is left of `cells.pieces`. Cost O(cells), little more than one look at each where
/// regions are large against cells. Oracle: tests/measure/source_test.cpp.
[[nodiscard]] std::vector<CellPiece> cut_cells(const CellView& cells, std::span<unsigned char> in_domain,
                                               const Domain& domain, const Context& context);

// --- cells of the overlay ---
// They know their two triangles.

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

/// f(triangle as an overlay cell) for a piece of a cell.
template <class F>
void for_parts_of(const OverlayCell& cell, const ConvexCell& piece, F&& f) {
  for_triangles(piece, [&](double, const Corner& a, const Corner& b, const Corner& c) {
    OverlayCell part = cell;
    part.corners = 3;
    part.sides = 0;
    const std::array<Corner, 3> corners{a, b, c};
    for (std::size_t k = 0; k < 3; ++k) {
      part.x[k] = corners[k].x - cell.origin.x, part.y[k] = corners[k].y - cell.origin.y;
      part.z1[k] = corners[k].z1, part.z2[k] = corners[k].z2;
    }
    f(part);
  });
}

/// f(OverlayCell, item): cells whole, triangles where they are cut.
template <class F>
void for_overlay(const OverlayCells& cells, std::size_t begin, std::size_t end, F&& f) {
  Overlay::Scratch overlay_scratch;
  if (cells.domain.is_everything()) {  // the usual case, short for the sake of speed
    for (std::size_t i = begin; i < end; ++i)
      for (const OverlayCell& c : cells.overlay.cells(i, overlay_scratch)) f(c, i);
    return;
  }
  Domain::Scratch scratch;
  for (std::size_t i = begin; i < end; ++i)
    for (const OverlayCell& c : cells.overlay.cells(i, overlay_scratch)) {
      const Regions::Answer answer = cells.domain.split(convex(c), scratch);
      if (answer == Regions::Answer::all) f(c, i);
      if (answer != Regions::Answer::some) continue;
      for (const ConvexCell& piece : scratch.pieces)
        for_parts_of(c, piece, [&](const OverlayCell& part) { f(part, i); });
    }
}

/// As one mesh, to be drawn or written. Where the domain is everything cells share their corners (Overlay::surface),
/// else each piece has corners of its own.
[[nodiscard]] OverlaySurface surface_of(const OverlayCells& cells, const Context& context);

// --- what both can ---
// f(convex cell), f(triangle with the difference at its corners).

template <class F>
void for_convex(const OverlayCells& cells, std::size_t begin, std::size_t end, F&& f) {
  Overlay::Scratch overlay_scratch;
  Domain::Scratch scratch;
  for (std::size_t i = begin; i < end; ++i)
    for (const OverlayCell& c : cells.overlay.cells(i, overlay_scratch)) cells.domain.for_pieces(convex(c), scratch, f);
}
template <class F>
void for_convex(const CellView& cells, std::size_t begin, std::size_t end, F&& f) {
  for_common(cells, begin, end, [&](const CommonCell& c, std::size_t) { f(c.convex()); });
}

template <class F>
void for_cells(const CellView& cells, std::size_t begin, std::size_t end, F&& f) {
  for_common(cells, begin, end, [&](const CommonCell& c, std::size_t) { f(c.cell()); });
}
template <class F>
void for_cells(const OverlayCells& cells, std::size_t begin, std::size_t end, F&& f) {
  if (!cells.domain.is_everything())
    return for_convex(cells, begin, end, [&](const ConvexCell& piece) {
      for_triangles(piece, [&](double area, const Corner& a, const Corner& b, const Corner& c) {
        f(Cell{area, {a.d(), b.d(), c.d()}});
      });
    });
  for_overlay(cells, begin, end, [&](const OverlayCell& c, std::size_t) {
    const double d0 = c.d(0);
    for_triangles(c, [&](unsigned a, unsigned b, double area) { f(Cell{area, {d0, c.d(a), c.d(b)}}); });
  });
}

/// A number that depends on where a cell of T, or the outer triangle of an item of the overlay, lies, and on nothing
/// else: what a sample is chosen by, so that it does not depend on how triangles are numbered.
[[nodiscard]] inline std::uint64_t name_of(const CellView& cells, std::size_t item) {
  const std::size_t whole = cells.t.real;
  if (item >= whole) {
    const auto& [a, b, c] = cells.pieces[item - whole].at;
    return hash_of(Point2{c.x, c.y}, hash_of(Point2{b.x, b.y}, hash_of(Point2{a.x, a.y})));
  }
  const std::array<Index, 3> v = cells.corners(item);
  return hash_of(cells.xy[v[1]], hash_of(cells.xy[v[0]]));  // no other triangle runs along this side this way
}
[[nodiscard]] inline std::uint64_t name_of(const OverlayCells& cells, std::size_t item) {
  const std::array<Point2, 2> side = cells.overlay.first_side(item);
  return hash_of(side[1], hash_of(side[0]));
}
/// Whether an item can have cells in the domain at all, as far as can be told at once.
[[nodiscard]] inline bool may_have_cells(const CellView& cells, std::size_t item) {
  return item >= cells.t.real || cells.in_domain[item] != 0;
}
[[nodiscard]] inline bool may_have_cells(const OverlayCells&, std::size_t) { return true; }

/// The same cell with ascending values.
[[nodiscard]] inline Cell sorted(Cell cell) {
  auto& d = cell.d;
  const double low = std::min(d[0], d[1]), high = std::max(d[0], d[1]);
  cell.d = {std::min(low, d[2]), std::max(low, std::min(high, d[2])), std::max(high, d[2])};
  return cell;
}

}  // namespace isopach
