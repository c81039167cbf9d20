#include "isopach/measure/clip.hpp"

#include <algorithm>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {

namespace {

template <class T>
void append(std::vector<T>& all, const std::vector<T>& part) {
  all.insert(all.end(), part.begin(), part.end());
}

}  // namespace

Regions::Answer Clip::split(const ConvexCell& cell, Scratch& s) const {
  bool whole = true;  // so far nothing was cut: s.pieces is not in use
  for (const Layer& layer : layers_) {
    if (whole) {
      s.inside.clear();
      s.outside.clear();
      const Regions::Answer answer = layer.regions.split(cell, s.regions, s.inside, s.outside);
      if (answer == (layer.keeps ? Regions::Answer::none : Regions::Answer::all)) return Regions::Answer::none;
      if (answer != Regions::Answer::some) continue;
      whole = false;
      std::swap(s.pieces, layer.keeps ? s.inside : s.outside);
      continue;
    }
    s.inside.clear();
    s.outside.clear();
    for (const ConvexCell& piece : s.pieces) {
      const Regions::Answer answer = layer.regions.split(piece, s.regions, s.inside, s.outside);
      if (answer == Regions::Answer::all) s.inside.push_back(piece);
      if (answer == Regions::Answer::none) s.outside.push_back(piece);
    }
    std::swap(s.pieces, layer.keeps ? s.inside : s.outside);
    if (s.pieces.empty()) return Regions::Answer::none;
  }
  if (whole) return Regions::Answer::all;
  return s.pieces.empty() ? Regions::Answer::none : Regions::Answer::some;
}

ConvexCell convex(const CellView& cells, std::size_t triangle) {
  auto corners = cells.t.triangles[triangle].v;
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());  // however T was made
  ConvexCell c;
  for (const Index v : corners) c.add({cells.xy[v].x, cells.xy[v].y, cells.z1[v], cells.z2[v]});
  return c;
}

ConvexCell convex(const CellPiece& piece) {
  ConvexCell c;
  for (const Corner& corner : piece.at) c.add(corner);
  return c;
}

ConvexCell convex(const OverlayCell& cell) {
  ConvexCell c;
  for (unsigned k = 0; k < cell.corners; ++k)
    c.add({cell.origin.x + cell.x[k], cell.origin.y + cell.y[k], cell.z1[k], cell.z2[k]});
  return c;
}

std::array<double, 3> shares_of_nodes(const CellView& cells, const CellPiece& piece, std::size_t k) {
  const auto& v = cells.t.triangles[piece.cell].v;
  const Point2 p{piece.at[k].x, piece.at[k].y};
  const Point2 &a = cells.xy[v[0]], &b = cells.xy[v[1]], &c = cells.xy[v[2]];
  std::array<double, 3> shares{triangle_area(p, b, c), triangle_area(a, p, c), triangle_area(a, b, p)};
  double sum = 0;
  for (double& share : shares) sum += share = std::max(share, 0.0);  // rounding, on a side
  for (double& share : shares) share = sum > 0 ? share / sum : 1.0 / 3;
  return shares;
}

std::array<double, 3> at_corners(const CellView& cells, const CellPiece& piece, std::span<const double> of_node) {
  const auto& v = cells.t.triangles[piece.cell].v;
  std::array<double, 3> values{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto shares = shares_of_nodes(cells, piece, k);
    for (std::size_t j = 0; j < 3; ++j) values[k] += shares[j] * of_node[v[j]];
  }
  return values;
}

std::vector<CellPiece> clip_cells(const CellView& cells, std::span<unsigned char> in_domain, const Clip& clip,
                                  const Context& context) {
  context.check();
  using Pieces = std::vector<CellPiece>;
  return reduce_blocks<Pieces>(
      cells.t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        Pieces pieces;
        Clip::Scratch scratch;
        for (std::size_t i = begin; i < end; ++i) {
          if (in_domain[i] == 0) continue;
          const Regions::Answer answer = clip.split(convex(cells, i), scratch);
          if (answer == Regions::Answer::all) continue;
          in_domain[i] = 0;
          if (answer == Regions::Answer::none) continue;
          for (const ConvexCell& piece : scratch.pieces)
            for_triangles(piece, [&](double, const Corner& a, const Corner& b, const Corner& c) {
              pieces.push_back({static_cast<Index>(i), {a, b, c}});
            });
        }
        return pieces;
      },
      [](Pieces& all, const Pieces& part) { append(all, part); });
}

OverlaySurface surface_of(const ClippedOverlay& cells, const Context& context) {
  context.check();
  using Cells = std::vector<ConvexCell>;
  const Cells all = reduce_blocks<Cells>(
      items_of(cells), default_block,
      [&](std::size_t begin, std::size_t end) {
        Cells part;
        for_convex(cells, begin, end, [&](const ConvexCell& c) { part.push_back(c); });
        return part;
      },
      [](Cells& total, const Cells& part) { append(total, part); });
  OverlaySurface s;
  for (const ConvexCell& c : all) {
    const Index first = static_cast<Index>(s.xy.size());
    for (unsigned k = 0; k < c.corners; ++k) {
      s.xy.push_back({c.at[k].x, c.at[k].y});
      s.z1.push_back(c.at[k].z1);
      s.z2.push_back(c.at[k].z2);
      if (k >= 2) s.triangles.push_back({first, first + k - 1, first + k});
    }
  }
  return s;
}

namespace {

struct AreaSums {
  Sum all, flagged, within;
};

double area_within(const ConvexCell& piece, const Regions& within, Clip::Scratch& s) {
  s.inside.clear();
  s.outside.clear();
  const Regions::Answer answer = within.split(piece, s.regions, s.inside, s.outside);
  if (answer == Regions::Answer::none) return 0;
  if (answer == Regions::Answer::all) return piece.area();
  double area = 0;
  for (const ConvexCell& c : s.inside) area += c.area();
  return area;
}

}  // namespace

ClippedAreas clipped_areas(const Triangulation& t, std::span<const Point2> xy, std::span<const unsigned char> flags,
                           const Clip& clip, const Regions* within, const Context& context) {
  context.check();
  const AreaSums sums = reduce_blocks<AreaSums>(
      t.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        AreaSums part;
        Clip::Scratch scratch, scratch_within;
        for (std::size_t i = begin; i < end; ++i) {
          ConvexCell cell;
          for (const Index v : t.triangles[i].v) cell.add({xy[v].x, xy[v].y, 0, 0});
          clip.for_pieces(cell, scratch, [&](const ConvexCell& piece) {
            const double area = piece.area();
            part.all.add(area);
            if (flags.empty() || flags[i] != 0) part.flagged.add(area);
            if (within != nullptr) part.within.add(area_within(piece, *within, scratch_within));
          });
        }
        return part;
      },
      [](AreaSums& total, const AreaSums& part) {
        total.all.add(part.all);
        total.flagged.add(part.flagged);
        total.within.add(part.within);
      });
  return {sums.all.value(), sums.flagged.value(), sums.within.value()};
}

}  // namespace isopach
