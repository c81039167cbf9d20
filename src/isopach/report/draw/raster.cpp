#include "isopach/report/draw/raster.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "isopach/base/parallel.hpp"
#include "isopach/measure/source.hpp"

namespace isopach {
namespace {

constexpr int band_rows = 32;
constexpr std::size_t triangles_per_block = 1 << 16;

struct Vertex {
  double x, y, d, z, lod;  // x, y in pixels
};
using Vertices = std::array<Vertex, 3>;

/// Pixels whose centres lie in [low, high), cut to [0, limit).
struct Span {
  std::int32_t begin, end;
};
Span centres_between(double low, double high, int limit) {
  const auto cut = [&](double v) {
    return static_cast<std::int32_t>(std::ceil(std::clamp(v - 0.5, 0.0, static_cast<double>(limit))));
  };
  return {cut(low), cut(high)};
}

/// A side of a triangle, always from its lower end to its upper one, so that both its triangles compute the same bits.
struct Side {
  double y_begin, y_end, x_begin, slope;
  Side(const Vertex& p, const Vertex& q) {
    const bool up = p.y < q.y || (p.y == q.y && p.x < q.x);
    const Vertex &a = up ? p : q, &b = up ? q : p;
    y_begin = a.y, y_end = b.y, x_begin = a.x;
    slope = b.y > a.y ? (b.x - a.x) / (b.y - a.y) : 0;
  }
  [[nodiscard]] bool crosses(double y) const { return y_begin <= y && y < y_end; }
  [[nodiscard]] double x_at(double y) const { return x_begin + (y - y_begin) * slope; }
};

/// A linear function on the triangle, clamped to its corner values: a sliver cannot throw it out of range.
struct Plane {
  double at0, along_x, along_y, low, high;
  Plane(const Vertices& c, double determinant, double Vertex::*value) {
    const double u = c[1].*value - c[0].*value, v = c[2].*value - c[0].*value;
    const double ax = c[1].x - c[0].x, ay = c[1].y - c[0].y, bx = c[2].x - c[0].x, by = c[2].y - c[0].y;
    at0 = c[0].*value;
    along_x = determinant == 0 ? 0 : (u * by - v * ay) / determinant;
    along_y = determinant == 0 ? 0 : (ax * v - bx * u) / determinant;
    low = std::min({c[0].*value, c[1].*value, c[2].*value});
    high = std::max({c[0].*value, c[1].*value, c[2].*value});
  }
  [[nodiscard]] float at(double dx, double dy) const {
    return static_cast<float>(std::clamp(at0 + along_x * dx + along_y * dy, low, high));
  }
};

class Painter {
 public:
  Painter(const Cells& cells, CellRaster& raster) : cells_(cells), raster_(raster) {}

  [[nodiscard]] Span rows_of(Index t) const {
    if (cells_.scanned.size() > t && cells_.in_domain[t] == 0 && (cells_.scanned[t] == 0 || cells_.scanned[t] > 3))
      return {0, 0};  // in no scan, but in the hull of both; or by its parts
    const Vertices c = corners(t);
    const auto [x0, x1] = std::minmax({c[0].x, c[1].x, c[2].x});
    const auto [y0, y1] = std::minmax({c[0].y, c[1].y, c[2].y});
    const Span columns = centres_between(x0, x1, raster_.view.columns);
    if (columns.begin >= columns.end) return {0, 0};
    return centres_between(y0, y1, raster_.view.rows);
  }

  void fill(Index t, Span rows) {
    const Vertices c = corners(t);
    const std::array<Side, 3> sides{Side(c[0], c[1]), Side(c[1], c[2]), Side(c[2], c[0])};
    const double determinant = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
    const Plane d(c, determinant, &Vertex::d), z(c, determinant, &Vertex::z), lod(c, determinant, &Vertex::lod);
    const bool in_domain = t >= first_piece() || (t < cells_.triangulation.real && cells_.in_domain[t] != 0);
    for (std::int32_t row = rows.begin; row < rows.end; ++row) {
      const double y = row + 0.5;
      double x_begin = std::numeric_limits<double>::infinity(), x_end = -x_begin;
      for (const Side& side : sides)
        if (side.crosses(y)) x_begin = std::min(x_begin, side.x_at(y)), x_end = std::max(x_end, side.x_at(y));
      const Span span = centres_between(x_begin, x_end, raster_.view.columns);
      const std::size_t line = static_cast<std::size_t>(row) * static_cast<std::size_t>(raster_.view.columns);
      for (std::int32_t column = span.begin; column < span.end; ++column) {
        const std::size_t pixel = line + static_cast<std::size_t>(column);
        raster_.cover[pixel] = in_domain ? CellRaster::Cover::domain : CellRaster::Cover::footprint;
        if (!in_domain) continue;
        raster_.d[pixel] = d.at(column + 0.5 - c[0].x, y - c[0].y);
        raster_.z[pixel] = z.at(column + 0.5 - c[0].x, y - c[0].y);
        if (!raster_.lod.empty()) raster_.lod[pixel] = lod.at(column + 0.5 - c[0].x, y - c[0].y);
      }
    }
  }

 private:
  /// Behind all triangles come the parts of them that were scanned, then the pieces of the domain: each is painted over
  /// what it is of.
  [[nodiscard]] std::size_t first_piece() const { return cells_.triangulation.real + cells_.scanned_parts.size(); }

  [[nodiscard]] Vertices corners(Index t) const {
    const MapView& v = raster_.view;
    Vertices out{};
    if (t >= cells_.triangulation.real && t < first_piece()) {
      const auto& part = cells_.scanned_parts[t - cells_.triangulation.real];
      for (std::size_t k = 0; k < 3; ++k)
        out[k] = {(part[k].x - v.left) * v.scale, (v.top - part[k].y) * v.scale, 0, 0, 0};
      return out;
    }
    if (t >= first_piece()) {
      const CellPiece& piece = cells_.pieces[t - first_piece()];
      std::array<double, 3> lod{};
      const CellView view = cells_.view();
      if (!cells_.lod.empty()) lod = of_piece(view, piece).at_corners(cells_.lod);
      for (std::size_t k = 0; k < 3; ++k) {
        const Corner& p = piece.at[k];
        out[k] = {(p.x - v.left) * v.scale, (v.top - p.y) * v.scale, p.d(), p.z1 - raster_.z_origin, lod[k]};
      }
      return out;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const Index n = cells_.triangulation.triangles[t].v[k];
      out[k] = {(cells_.xy[n].x - v.left) * v.scale, (v.top - cells_.xy[n].y) * v.scale, cells_.d(n),
                cells_.z1[n] - raster_.z_origin, cells_.lod.empty() ? 0 : cells_.lod[n]};
    }
    return out;
  }

  const Cells& cells_;
  CellRaster& raster_;
};

/// Triangles of each band of rows, ascending: a counting sort over fixed blocks.
struct Bands {
  Array<std::size_t> begin;  // band -> first entry; one more at the end
  Array<Index> triangles;
};

Bands sort_into_bands(const Array<Span>& rows, std::size_t bands) {
  const std::size_t n = rows.size(), blocks = (n + triangles_per_block - 1) / triangles_per_block;
  std::vector<std::size_t> next(blocks * bands, 0);  // [band][block]
  const auto each_band = [&](std::size_t t, auto&& visit) {
    if (rows[t].begin >= rows[t].end) return;
    const int last = (rows[t].end - 1) / band_rows;
    for (int band = rows[t].begin / band_rows; band <= last; ++band) visit(static_cast<std::size_t>(band));
  };
  for_blocks(n, triangles_per_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      each_band(t, [&](std::size_t band) { ++next[band * blocks + begin / triangles_per_block]; });
  });
  Bands out;
  out.begin.resize(bands + 1);
  std::size_t total = 0;
  for (std::size_t band = 0; band < bands; ++band) {
    out.begin[band] = total;
    for (std::size_t block = 0; block < blocks; ++block) {
      const std::size_t size = next[band * blocks + block];
      next[band * blocks + block] = total;
      total += size;
    }
  }
  out.begin[bands] = total;
  out.triangles.resize(total);
  for_blocks(n, triangles_per_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      each_band(t, [&](std::size_t band) {
        out.triangles[next[band * blocks + begin / triangles_per_block]++] = static_cast<Index>(t);
      });
  });
  return out;
}

}  // namespace

CellRaster rasterise(const Cells& cells, const MapView& view) {
  CellRaster raster;
  raster.view = view;
  const std::size_t pixels = static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows);
  raster.cover.resize(pixels);
  std::fill(raster.cover.begin(), raster.cover.end(), CellRaster::Cover::none);
  raster.d.resize(pixels);
  raster.z.resize(pixels);
  if (!cells.lod.empty()) raster.lod.resize(pixels);
  const Index real = cells.triangulation.real;
  if (real == 0 || pixels == 0) return raster;
  raster.z_origin = cells.z1[cells.triangulation.triangles[0].v[0]];

  Painter painter(cells, raster);
  Array<Span> rows(real + cells.scanned_parts.size() + cells.pieces.size());  // in the order of Painter::first_piece
  for_each_index(rows.size(), [&](std::size_t t) { rows[t] = painter.rows_of(static_cast<Index>(t)); });
  const std::size_t band_count = static_cast<std::size_t>((view.rows + band_rows - 1) / band_rows);
  const Bands bands = sort_into_bands(rows, band_count);
  for_blocks(band_count, 1, [&](std::size_t band, std::size_t) {
    const Span window{static_cast<std::int32_t>(band) * band_rows,
                      std::min(view.rows, (static_cast<std::int32_t>(band) + 1) * band_rows)};
    for (std::size_t i = bands.begin[band]; i < bands.begin[band + 1]; ++i) {
      const Index t = bands.triangles[i];
      painter.fill(t, {std::max(rows[t].begin, window.begin), std::min(rows[t].end, window.end)});
    }
  });
  return raster;
}

}  // namespace isopach
