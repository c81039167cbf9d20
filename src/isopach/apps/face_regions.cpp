#include "isopach/apps/face_regions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {
namespace {

struct Strip {
  std::string name;
  double low, high;  // of y
};

Box2 box_of(const CellView& cells) {
  return reduce_blocks<Box2>(
      cells.t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        Box2 box;
        for (std::size_t i = begin; i < end; ++i)
          if (cells.in_domain[i] != 0)
            for (const Index v : cells.t.triangles[i].v) box.add(cells.xy[v]);
        return box;
      },
      [](Box2& left, const Box2& right) { left.add(right); });
}

std::vector<Strip> strips_of(const CellView& cells, FaceParts parts) {
  constexpr double far = std::numeric_limits<double>::infinity();
  const Box2 box = box_of(cells);
  const auto level = [&](double share) { return box.min.y + share * (box.max.y - box.min.y); };
  std::vector<Strip> strips{{"whole", -far, far}};
  if (parts == FaceParts::halves) {
    strips.push_back({"upper half", level(0.5), far});
    strips.push_back({"lower half", -far, level(0.5)});
  } else {
    strips.push_back({"upper third", level(2.0 / 3), far});
    strips.push_back({"middle third", level(1.0 / 3), level(2.0 / 3)});
    strips.push_back({"lower third", -far, level(1.0 / 3)});
  }
  return strips;
}

struct Vertex {
  double x, y, d;
};

/// A convex polygon: a triangle cut three times at most.
struct Piece {
  unsigned corners = 0;
  std::array<Vertex, 6> at;
};

/// The part where `height` of a corner is not negative; it is linear in x and y.
template <class Height>
Piece cut(const Piece& piece, Height&& height) {
  Piece kept;
  for (unsigned k = 0; k < piece.corners; ++k) {
    const Vertex &p = piece.at[k], &q = piece.at[(k + 1) % piece.corners];
    const double hp = height(p), hq = height(q);
    if (hp >= 0) kept.at[kept.corners++] = p;
    if ((hp >= 0) == (hq >= 0)) continue;
    const double t = hp / (hp - hq);
    kept.at[kept.corners++] = {p.x + t * (q.x - p.x), p.y + t * (q.y - p.y), p.d + t * (q.d - p.d)};
  }
  return kept;
}

struct Sums {
  Sum area, above, below, squares;
  double largest = 0;

  void add(const Piece& piece) {
    for (unsigned k = 2; k < piece.corners; ++k) {
      const Vertex &a = piece.at[0], &b = piece.at[k - 1], &c = piece.at[k];
      const double size = triangle_area({a.x, a.y}, {b.x, b.y}, {c.x, c.y});
      if (!(size > 0)) continue;
      const Cell cell{size, {a.d, b.d, c.d}};
      const Parts parts = split_volume(cell);
      area.add(size), above.add(parts.above), below.add(parts.below);
      const double sum = a.d + b.d + c.d;
      squares.add(size / 12 * (sum * sum + a.d * a.d + b.d * b.d + c.d * c.d));
      largest = std::max({largest, std::fabs(a.d), std::fabs(b.d), std::fabs(c.d)});
    }
  }
  void add(const Sums& other) {
    area.add(other.area), above.add(other.above), below.add(other.below), squares.add(other.squares);
    largest = std::max(largest, other.largest);
  }
};

Piece piece_of(const CellView& cells, std::size_t triangle) {
  Piece piece;
  for (const Index v : cells.t.triangles[triangle].v)
    piece.at[piece.corners++] = {cells.xy[v].x, cells.xy[v].y, cells.d(v)};
  return piece;
}

SideDifference described(const std::string& name, const Sums& sums) {
  SideDifference r;
  r.name = name;
  r.area = sums.area.value();
  r.volume.above = sums.above.value(), r.volume.below = sums.below.value();
  r.volume.net = r.volume.above - r.volume.below;
  r.volume.absolute = r.volume.above + r.volume.below;
  r.largest = sums.largest;
  if (!(r.area > 0)) return r;
  r.directional = r.volume.net / r.area;
  r.absolute = r.volume.absolute / r.area;
  r.rms = std::sqrt(sums.squares.value() / r.area);
  return r;
}

}  // namespace

std::vector<SideDifference> face_regions(const CellView& cells, FaceParts parts, const Context& context) {
  context.check();
  const std::vector<Strip> strips = strips_of(cells, parts);
  using All = std::vector<Sums>;
  const All sums = reduce_blocks<All>(
      cells.t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        All part(strips.size());
        for (std::size_t i = begin; i < end; ++i) {
          if (cells.in_domain[i] == 0) continue;
          const Piece side = cut(piece_of(cells, i), [](const Vertex& p) { return p.x; });
          if (side.corners == 0) continue;
          part[0].add(side);
          for (std::size_t k = 1; k < strips.size(); ++k) {
            const Strip& s = strips[k];
            part[k].add(cut(cut(side, [&](const Vertex& p) { return p.y - s.low; }),
                            [&](const Vertex& p) { return s.high - p.y; }));
          }
        }
        return part;
      },
      [&](All& total, const All& part) {
        total.resize(strips.size());
        for (std::size_t k = 0; k < part.size(); ++k) total[k].add(part[k]);
      });
  std::vector<SideDifference> regions;
  for (std::size_t k = 0; k < strips.size(); ++k)
    regions.push_back(described(strips[k].name, k < sums.size() ? sums[k] : Sums{}));
  return regions;
}

}  // namespace isopach
