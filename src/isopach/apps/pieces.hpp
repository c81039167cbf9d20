// Pieces of cells, cut where a linear function changes its sign.
#pragma once
#include <array>

#include "isopach/measure/measures.hpp"

namespace isopach {

struct PieceCorner {
  double x, y, d;
};

/// A convex polygon with d linear on it: a triangle cut three times at most.
struct Piece {
  unsigned corners = 0;
  std::array<PieceCorner, 6> at;
};

[[nodiscard]] inline Piece piece_of(const CellView& cells, std::size_t triangle) {
  Piece piece;
  for (const Index v : cells.t.triangles[triangle].v)
    piece.at[piece.corners++] = {cells.xy[v].x, cells.xy[v].y, cells.d(v)};
  return piece;
}

/// The part where `height` of a corner, linear in x, y and d, is not negative.
template <class Height>
[[nodiscard]] Piece cut(const Piece& piece, Height&& height) {
  Piece kept;
  for (unsigned k = 0; k < piece.corners; ++k) {
    const PieceCorner &p = piece.at[k], &q = piece.at[(k + 1) % piece.corners];
    const double hp = height(p), hq = height(q);
    if (hp >= 0) kept.at[kept.corners++] = p;
    if ((hp >= 0) == (hq >= 0)) continue;
    const double t = hp / (hp - hq);
    kept.at[kept.corners++] = {p.x + t * (q.x - p.x), p.y + t * (q.y - p.y), p.d + t * (q.d - p.d)};
  }
  return kept;
}

/// f(Cell) for the triangles of a fan; those without area are left out.
template <class F>
void for_triangles(const Piece& piece, F&& f) {
  for (unsigned k = 2; k < piece.corners; ++k) {
    const PieceCorner &a = piece.at[0], &b = piece.at[k - 1], &c = piece.at[k];
    const double area = triangle_area({a.x, a.y}, {b.x, b.y}, {c.x, c.y});
    if (area > 0) f(Cell{area, {a.d, b.d, c.d}});
  }
}

}  // namespace isopach
