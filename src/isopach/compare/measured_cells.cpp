#include "isopach/compare/measured_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <tuple>
#include <utility>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/geom/predicates.hpp"
#include "isopach/measure/source.hpp"

namespace isopach {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t check_every = 4096;  // cells

void set_frame(MeasuredCells& m, const Frame& frame) {
  const auto& r = frame.rotation;
  const Point3& o = frame.origin;
  m.axes = r;
  for (std::size_t k = 0; k < 3; ++k) m.offset[k] = r[3 * k] * o.x + r[3 * k + 1] * o.y + r[3 * k + 2] * o.z;
}

/// At the nodes of T, then at the corners of the pieces.
Array<double> level_of(const Cells& cells) {
  Array<double> lod = cells.lod;
  if (lod.empty()) return lod;
  const CellView view = cells.view();
  for (const CellPiece& piece : cells.pieces)
    for (const double level : of_piece(view, piece).at_corners(cells.lod)) lod.push_back(level);
  return lod;
}

/// A convex polygon that a triangle was cut to by the four sides of a pixel: at most 7 corners.
class Part {
 public:
  Part() = default;
  Part(std::initializer_list<Corner> corners) {
    for (const Corner& c : corners) push_back(c);
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const Corner& operator[](std::size_t i) const { return corners_[i]; }
  [[nodiscard]] Corner& operator[](std::size_t i) { return corners_[i]; }
  [[nodiscard]] const Corner* begin() const { return corners_.data(); }
  [[nodiscard]] const Corner* end() const { return corners_.data() + size_; }
  void clear() { size_ = 0; }
  void push_back(const Corner& c) {
    if (size_ == corners_.size()) throw Error(ExitCode::internal, "a triangle cut by a pixel has too many corners");
    corners_[size_++] = c;
  }

 private:
  std::array<Corner, 8> corners_;
  std::size_t size_ = 0;
};

Corner between(const Corner& a, const Corner& b, double share) {
  return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), a.z1 + share * (b.z1 - a.z1),
          a.z2 + share * (b.z2 - a.z2)};
}

/// Cuts a convex polygon at coordinate = at: `low` gets what lies below, `high` what lies above. The corner of a cut is
/// one and the same for both, and lies on the line.
void cut(const Part& polygon, double Corner::*coordinate, double at, Part& low, Part& high) {
  low.clear(), high.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = a.*coordinate - at, db = b.*coordinate - at;
    if (da <= 0) low.push_back(a);
    if (da >= 0) high.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      Corner v = between(a, b, da / (da - db));
      v.*coordinate = at;
      low.push_back(v), high.push_back(v);
    }
  }
}

std::pair<double, double> range_of(const Part& polygon, double Corner::*coordinate) {
  double least = polygon[0].*coordinate, most = least;
  for (const Corner& v : polygon) least = std::min(least, v.*coordinate), most = std::max(most, v.*coordinate);
  return {least, most};
}

/// f(strip, part) for the parts of a polygon in strips [first + k · step, first + (k + 1) · step], k below `count`.
template <class F>
void for_strips(const Part& polygon, double Corner::*coordinate, double first, double step, std::size_t count, F&& f) {
  Part rest = polygon, low, high;
  const auto [least, most] = range_of(rest, coordinate);
  const auto strip = [&](double value) { return std::floor((value - first) / step); };
  const double last = static_cast<double>(count) - 1;
  if (strip(least) > last || strip(most) < 0) return;
  const auto begin = static_cast<std::ptrdiff_t>(std::max(strip(least), -1.0));
  const auto end = static_cast<std::ptrdiff_t>(std::min(strip(most), last));
  for (std::ptrdiff_t k = begin; k <= end && rest.size() >= 3; ++k) {
    cut(rest, coordinate, first + static_cast<double>(k + 1) * step, low, high);
    if (k >= 0 && low.size() >= 3) f(static_cast<std::size_t>(k), low);
    std::swap(rest, high);
  }
}

Part triangle_of(const MeshView& mesh, std::size_t t) {
  Part p;
  for (const std::int32_t corner : mesh.triangles[t]) {
    const auto v = static_cast<std::size_t>(corner);
    p.push_back({mesh.xy[v].x, mesh.xy[v].y, mesh.z1[v], mesh.z2[v]});
  }
  return p;
}

/// Triangles by the square of a flat grid that their boxes touch.
class TriangleGrid {
 public:
  explicit TriangleGrid(const MeshView& mesh) : mesh_(mesh) {
    for (const auto& t : mesh.triangles)
      for (const std::int32_t v : t) box_.add(mesh.xy[static_cast<std::size_t>(v)]);
    if (box_.empty()) return;
    const double width = box_.max.x - box_.min.x, height = box_.max.y - box_.min.y;
    const double squares = std::max<double>(1, static_cast<double>(mesh.triangles.size()) / 2);
    step_ = std::max(
        {std::sqrt(width * height / squares), std::max(width, height) / 4e4, std::numeric_limits<double>::min()});
    columns_ = static_cast<std::size_t>(width / step_) + 1, rows_ = static_cast<std::size_t>(height / step_) + 1;
    begin_.assign(columns_ * rows_ + 1, 0);
    each([&](std::size_t square, std::int32_t) { ++begin_[square + 1]; });
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    ids_.resize(begin_.back());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    each([&](std::size_t square, std::int32_t t) { ids_[next[square]++] = t; });
  }

  /// The first triangle that holds the place, sides included; -1 if none does.
  [[nodiscard]] std::int32_t find(const Point2& p) const {
    if (box_.empty() || !(box_.min.x <= p.x && p.x <= box_.max.x && box_.min.y <= p.y && p.y <= box_.max.y)) return -1;
    const std::size_t square = column(p.x) + columns_ * row(p.y);
    for (std::size_t i = begin_[square]; i < begin_[square + 1]; ++i) {
      const auto& t = mesh_.triangles[static_cast<std::size_t>(ids_[i])];
      const Point2 &a = mesh_.xy[static_cast<std::size_t>(t[0])], &b = mesh_.xy[static_cast<std::size_t>(t[1])],
                   &c = mesh_.xy[static_cast<std::size_t>(t[2])];
      if (orientation(a, b, p) >= 0 && orientation(b, c, p) >= 0 && orientation(c, a, p) >= 0) return ids_[i];
    }
    return -1;
  }

 private:
  [[nodiscard]] std::size_t column(double x) const {
    return std::min(columns_ - 1, static_cast<std::size_t>((x - box_.min.x) / step_));
  }
  [[nodiscard]] std::size_t row(double y) const {
    return std::min(rows_ - 1, static_cast<std::size_t>((y - box_.min.y) / step_));
  }
  template <class F>
  void each(F&& f) const {
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      Box2 box;
      for (const std::int32_t v : mesh_.triangles[i]) box.add(mesh_.xy[static_cast<std::size_t>(v)]);
      for (std::size_t r = row(box.min.y); r <= row(box.max.y); ++r)
        for (std::size_t c = column(box.min.x); c <= column(box.max.x); ++c)
          f(c + columns_ * r, static_cast<std::int32_t>(i));
    }
  }

  const MeshView& mesh_;
  Box2 box_;
  double step_ = 1;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<std::size_t> begin_;
  std::vector<std::int32_t> ids_;
};

/// The part of the way from p to q, from 0 to 1, that lies in a triangle.
struct Stretch {
  double from, to;
  std::size_t triangle;
};

bool clip(const Part& t, const Point2& p, const Point2& q, double& from, double& to) {
  from = 0, to = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    const Corner &a = t[k], &b = t[(k + 1) % 3];
    const auto side = [&](const Point2& r) { return (b.x - a.x) * (r.y - a.y) - (b.y - a.y) * (r.x - a.x); };
    const double at_p = side(p), at_q = side(q);
    if (at_p < 0 && at_q < 0) return false;
    if (at_p < 0) from = std::max(from, at_p / (at_p - at_q));
    if (at_q < 0) to = std::min(to, at_p / (at_p - at_q));
  }
  return from < to;
}

/// Heights of a triangle's planes at a place.
std::pair<double, double> heights(const Part& t, double x, double y) {
  const Corner &a = t[0], &b = t[1], &c = t[2];
  const double whole = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  const double of_b = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / whole;
  const double of_c = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / whole;
  return {a.z1 + of_b * (b.z1 - a.z1) + of_c * (c.z1 - a.z1), a.z2 + of_b * (b.z2 - a.z2) + of_c * (c.z2 - a.z2)};
}

std::vector<Stretch> stretches(const MeshView& mesh, const Point2& p, const Point2& q, const Context& context) {
  Box2 way;
  way.add(p), way.add(q);
  std::vector<Stretch> found;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t % check_every == 0) context.check();
    Box2 box;
    for (const std::int32_t v : mesh.triangles[t]) box.add(mesh.xy[static_cast<std::size_t>(v)]);
    if (box.min.x > way.max.x || box.max.x < way.min.x || box.min.y > way.max.y || box.max.y < way.min.y) continue;
    Stretch s{0, 0, t};
    if (clip(triangle_of(mesh, t), p, q, s.from, s.to)) found.push_back(s);
  }
  std::sort(found.begin(), found.end(), [](const Stretch& a, const Stretch& b) {
    return std::pair(a.from, a.triangle) < std::pair(b.from, b.triangle);
  });
  return found;
}

}  // namespace

MeasuredCells measured_cells(const Cells& cells, const Frame& frame) {
  MeasuredCells m;
  set_frame(m, frame);
  const std::size_t nodes = cells.xy.size(), corners = 3 * cells.pieces.size();
  const auto extended = [&](const Array<double>& values, double Corner::*member) {
    Array<double> all = values;
    all.reserve(nodes + corners);
    for (const CellPiece& piece : cells.pieces)
      for (const Corner& corner : piece.at) all.push_back(corner.*member);
    return all;
  };
  m.xy = cells.xy;
  for (const CellPiece& piece : cells.pieces)
    for (const Corner& corner : piece.at) m.xy.push_back({corner.x, corner.y});
  m.z1 = extended(cells.z1, &Corner::z1), m.z2 = extended(cells.z2, &Corner::z2);
  m.lod = level_of(cells);
  const auto& all = cells.triangulation.triangles;
  for (std::size_t t = 0; t < cells.triangulation.real; ++t) {
    if (cells.in_domain[t] == 0) continue;
    const auto& v = all[t].v;
    m.triangles.push_back(
        {static_cast<std::int32_t>(v[0]), static_cast<std::int32_t>(v[1]), static_cast<std::int32_t>(v[2])});
  }
  for (std::size_t k = 0; k < cells.pieces.size(); ++k) {
    const auto v = static_cast<std::int32_t>(nodes + 3 * k);
    m.triangles.push_back({v, v + 1, v + 2});
  }
  return m;
}

MeasuredCells measured_cells(const Comparison& c) {
  if (c.options.surface != Surface::overlay) return measured_cells(c.cells, c.frame);
  MeasuredCells m;
  set_frame(m, c.frame);
  const OverlaySurface& surface = c.overlay_surface;
  m.xy = surface.xy, m.z1 = surface.z1, m.z2 = surface.z2;
  m.lod = c.overlay_lod;
  for (const auto& v : surface.triangles)
    m.triangles.push_back(
        {static_cast<std::int32_t>(v[0]), static_cast<std::int32_t>(v[1]), static_cast<std::int32_t>(v[2])});
  return m;
}

MeasuredCells in_order(MeasuredCells cells) {
  for (auto& t : cells.triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(cells.triangles.begin(), cells.triangles.end());
  return cells;
}

namespace {

/// A double without what stands behind its point; it lies between −2^127 and 2^127. Sooner than a cast, which is a
/// call.
template <class Int>
Int whole(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const int shift = static_cast<int>(bits >> 52 & 0x7ff) - 1075;
  const Int size = static_cast<Int>((bits & 0xfffffffffffff) | 0x10000000000000);
  const Int value = shift <= -64 ? 0 : shift < 0 ? size >> -shift : size << std::min(shift, 73);
  return static_cast<std::int64_t>(bits) < 0 ? -value : value;
}

/// The power of two that takes a bound to 2^100 at most: 27 bits are left for rounding.
double steps_in_unit(double bound) {
  constexpr int bits = 100, most = 1000;  // of the bound; of the exponents of doubles
  int exponent = 0;
  std::frexp(bound, &exponent);
  return std::ldexp(1.0, std::clamp(bits - exponent, -most, most));
}

}  // namespace

PixelAdder::PixelAdder(const PixelGrid& grid, double height)
    : grid_(grid),
      per_step_(1 / grid.step),
      per_area_(steps_in_unit(grid.step * grid.step)),
      per_volume_(steps_in_unit(grid.step * grid.step * height)),
      pixels_(grid.columns * grid.rows) {}

void PixelAdder::add(const Corner& a, const Corner& b, const Corner& c, Pixel& pixel) const {
  const double area = 0.5 * ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
  const double volume = area / 3 * per_volume_;
  pixel.area += whole<Int128>(area * per_area_);
  pixel.z1 += whole<Int128>(volume * (a.z1 + b.z1 + c.z1));
  pixel.z2 += whole<Int128>(volume * (a.z2 + b.z2 + c.z2));
  pixel.d += whole<Int128>(volume * (a.d() + b.d() + c.d()));
}

void PixelAdder::add(const std::array<Corner, 3>& triangle) {
  const auto& [a, b, c] = triangle;
  if (!std::isfinite(a.z1 + b.z1 + c.z1 + a.z2 + b.z2 + c.z2))
    throw InputError("a cell has a height that is no finite number: leave it out of what is added up over pixels");
  const auto pixel = [&](std::size_t column, std::size_t row) -> Pixel& {
    return pixels_[column + grid_.columns * row];
  };
  // In one pixel, as nearly all are where there are many; by products, which are quicker than the quotients below.
  const double across = (a.x - grid_.x) * per_step_, up = (a.y - grid_.y) * per_step_;
  if (across >= 0 && across < static_cast<double>(grid_.columns) && up >= 0 && up < static_cast<double>(grid_.rows)) {
    const auto column = static_cast<std::int64_t>(across), row = static_cast<std::int64_t>(up);
    const auto is_beside = [&](const Corner& p) {
      const double x = (p.x - grid_.x) * per_step_ - static_cast<double>(column);
      const double y = (p.y - grid_.y) * per_step_ - static_cast<double>(row);
      return x >= 0 && x < 1 && y >= 0 && y < 1;
    };
    if (is_beside(b) && is_beside(c))
      return add(a, b, c, pixel(static_cast<std::size_t>(column), static_cast<std::size_t>(row)));
  }
  for_strips({a, b, c}, &Corner::y, grid_.y, grid_.step, grid_.rows, [&](std::size_t y, const Part& part) {
    for_strips(part, &Corner::x, grid_.x, grid_.step, grid_.columns, [&](std::size_t x, const Part& piece) {
      for (std::size_t k = 2; k < piece.size(); ++k) add(piece[0], piece[k - 1], piece[k], pixel(x, y));
    });
  });
}

PixelSums PixelAdder::sums() const {
  PixelSums sums;
  for (Array<double>* values : {&sums.area, &sums.z1, &sums.z2, &sums.d}) values->resize(pixels_.size());
  for_each_index(pixels_.size(), [&](std::size_t i) {
    const Pixel& p = pixels_[i];
    sums.area[i] = static_cast<double>(p.area) / per_area_;
    sums.z1[i] = static_cast<double>(p.z1) / per_volume_, sums.z2[i] = static_cast<double>(p.z2) / per_volume_;
    sums.d[i] = static_cast<double>(p.d) / per_volume_;
  });
  return sums;
}

PixelSums sum_over_pixels(const MeshView& mesh, const PixelGrid& grid, const Context& context) {
  double height = 0;
  for (const auto& t : mesh.triangles)
    for (const std::int32_t v : t) {
      const auto at = static_cast<std::size_t>(v);
      height = std::max({height, std::fabs(mesh.z1[at]) + std::fabs(mesh.z2[at])});
    }
  PixelAdder adder(grid, height);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t % check_every == 0) context.check();
    const Part p = triangle_of(mesh, t);
    adder.add(std::array{p[0], p[1], p[2]});
  }
  return adder.sums();
}

HeightsAt heights_at(const MeshView& mesh, std::span<const Point2> places, const Context& context) {
  const TriangleGrid grid(mesh);
  HeightsAt found;
  found.z1.assign(places.size(), nan), found.z2.assign(places.size(), nan);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i % check_every == 0) context.check();
    const std::int32_t t = grid.find(places[i]);
    if (t < 0) continue;
    std::tie(found.z1[i], found.z2[i]) =
        heights(triangle_of(mesh, static_cast<std::size_t>(t)), places[i].x, places[i].y);
  }
  return found;
}

Section section_along(const MeshView& mesh, std::span<const Point2> chain, const Context& context) {
  Section out;
  const auto put = [&](double s, double x, double y, double z1, double z2) {
    out.s.push_back(s), out.x.push_back(x), out.y.push_back(y), out.z1.push_back(z1), out.z2.push_back(z2);
  };
  double before = 0;
  for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
    const Point2 &p = chain[k], &q = chain[k + 1];
    const double length = std::hypot(q.x - p.x, q.y - p.y);
    if (!(length > 0)) continue;
    double reached = -1;  // nothing yet on this piece of the chain
    constexpr double same = 1e-12;
    for (const Stretch& found : stretches(mesh, p, q, context)) {
      if (found.to <= reached) continue;  // along a side that two cells share
      const double from = std::max(found.from, reached);
      const Part t = triangle_of(mesh, found.triangle);
      const auto corner = [&](double share) {
        const double x = p.x + share * (q.x - p.x), y = p.y + share * (q.y - p.y);
        const auto [z1, z2] = heights(t, x, y);
        put(before + share * length, x, y, z1, z2);
      };
      const bool follows =
          reached >= 0 ? from - reached <= same : !out.s.empty() && from <= same && out.s.back() >= before * (1 - same);
      if (!follows && !out.s.empty()) put(out.s.back(), out.x.back(), out.y.back(), nan, nan);
      if (!follows) corner(from);
      corner(found.to);
      reached = found.to;
    }
    before += length;
  }
  return out;
}

}  // namespace isopach
