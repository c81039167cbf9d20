#include "isopach/measure/texture/areal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/measures.hpp"
#include "isopach/overlay/smooth.hpp"

namespace isopach {
namespace {

constexpr std::size_t block = 1 << 13;

struct Corners {
  std::array<Point2, 3> p;
  std::array<double, 3> z;
  double area;
};

Corners corners(const TriangleSurface& s, std::size_t i) {
  const auto& v = s.triangles[i];
  return {{s.xy[v[0]], s.xy[v[1]], s.xy[v[2]]},
          {s.z[v[0]], s.z[v[1]], s.z[v[2]]},
          triangle_area(s.xy[v[0]], s.xy[v[1]], s.xy[v[2]])};
}

struct Level {
  Sum area, volume;
};

/// Area and mean height: the others are counted from it.
Level level_of(const TriangleSurface& s, double from) {
  return reduce_blocks<Level>(
      s.triangles.size(), block,
      [&](std::size_t begin, std::size_t end) {
        Level part;
        for (std::size_t i = begin; i < end; ++i) {
          const Corners c = corners(s, i);
          part.area.add(c.area);
          part.volume.add(c.area / 3 * ((c.z[0] - from) + (c.z[1] - from) + (c.z[2] - from)));
        }
        return part;
      },
      [](Level& total, const Level& part) { total.area.add(part.area), total.volume.add(part.volume); });
}

/// The power of two that brings heights near 1, so that their powers are neither lost nor infinite; it rounds nothing.
double power_for(const TriangleSurface& s, double mean) {
  constexpr int most = 1000;
  double largest = 0;
  for (const auto& v : s.triangles)
    for (const Index node : v) largest = std::max(largest, std::fabs(s.z[node] - mean));
  return largest > 0 ? std::ldexp(1.0, -std::clamp(std::ilogb(largest), -most, most)) : 1;
}

/// Sums of powers of heights times a power of two; slopes are those of the heights.
struct Moments {
  Sum size, second, third, fourth, slope, excess;
  double high = -std::numeric_limits<double>::infinity(), low = std::numeric_limits<double>::infinity();
};

void add(Moments& m, const Corners& c, double mean, double power) {
  const double a = (c.z[0] - mean) * power, b = (c.z[1] - mean) * power, d = (c.z[2] - mean) * power;
  const Parts parts = split_volume({c.area, {a, b, d}});
  m.size.add(parts.above + parts.below);
  // h_k by rows: h_k(a, b, d) = h_k(a, b) + d h_{k−1}(a, b, d)
  const double ab1 = a + b, ab2 = a * a + b * ab1, ab3 = a * a * a + b * ab2, ab4 = a * a * a * a + b * ab3;
  const double h1 = ab1 + d, h2 = ab2 + d * h1, h3 = ab3 + d * h2, h4 = ab4 + d * h3;
  m.second.add(c.area / 6 * h2), m.third.add(c.area / 10 * h3), m.fourth.add(c.area / 15 * h4);
  const double ux = c.p[1].x - c.p[0].x, uy = c.p[1].y - c.p[0].y, uz = (b - a) / power;
  const double vx = c.p[2].x - c.p[0].x, vy = c.p[2].y - c.p[0].y, vz = (d - a) / power;
  const double gx = (uz * vy - vz * uy) / (2 * c.area), gy = (vz * ux - uz * vx) / (2 * c.area);
  const double slope2 = gx * gx + gy * gy;
  if (std::isfinite(slope2)) {
    m.slope.add(c.area * slope2);
    m.excess.add(c.area * (slope2 / (1 + std::sqrt(1 + slope2))));  // √(1 + s²) − 1 without cancellation
  }
}

Moments moments_of(const TriangleSurface& s, double mean, double power) {
  return reduce_blocks<Moments>(
      s.triangles.size(), block,
      [&](std::size_t begin, std::size_t end) {
        Moments part;
        for (std::size_t i = begin; i < end; ++i) {
          const Corners c = corners(s, i);
          if (c.area > 0) add(part, c, mean, power);  // without area but for rounding
          for (unsigned k = 0; k < 3; ++k)
            if (s.triangles[i][k] < s.measured)
              part.high = std::max(part.high, c.z[k] - mean), part.low = std::min(part.low, c.z[k] - mean);
        }
        return part;
      },
      [](Moments& total, const Moments& part) {
        total.size.add(part.size), total.second.add(part.second), total.third.add(part.third);
        total.fourth.add(part.fourth), total.slope.add(part.slope), total.excess.add(part.excess);
        total.high = std::max(total.high, part.high), total.low = std::min(total.low, part.low);
      });
}

/// In the order of the nodes: the same bits whatever the triangles' order.
double root_mean_square_of_nodes(const TriangleSurface& s, double from, double power) {
  std::vector<unsigned char> used(s.measured, 0);
  for (const auto& v : s.triangles)
    for (const Index node : v)
      if (node < s.measured) used[node] = 1;
  Sum sum, squares;
  double nodes = 0;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i] != 0) sum.add(s.z[i] - from), ++nodes;
  if (nodes == 0) return 0;
  const double mean = sum.value() / nodes;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i] != 0) squares.add((s.z[i] - from - mean) * power * ((s.z[i] - from - mean) * power));
  return std::sqrt(squares.value() / nodes) / power;
}

/// Where the corners of a cut triangle are: the three old ones, then along each side, then inside row by row.
class Cut {
 public:
  explicit Cut(unsigned pieces) : k_(pieces), own_((pieces - 1) * (pieces - 2) / 2) {}
  [[nodiscard]] std::size_t inside() const { return own_; }
  [[nodiscard]] std::size_t on_side() const { return k_ - 1; }

  /// Corner (i, j) of the triangle: i steps from corner 0 to 1, j from 0 to 2. `side(s, n)`: id of the n-th point of
  /// side s, counted along it; `inner(n)` of the n-th inside.
  template <class Side, class Inner>
  [[nodiscard]] Index corner(const std::array<Index, 3>& v, unsigned i, unsigned j, Side&& side, Inner&& inner) const {
    if (i + j == 0) return v[0];
    if (i == k_) return v[1];
    if (j == k_) return v[2];
    if (j == 0) return side(0u, i - 1);
    if (i + j == k_) return side(1u, j - 1);
    if (i == 0) return side(2u, k_ - j - 1);
    std::size_t n = i - 1;
    for (unsigned row = 1; row < j; ++row) n += k_ - 1 - row;
    return inner(n);
  }
  template <class Inside>
  void for_inside(Inside&& f) const {
    for (unsigned j = 1; j < k_; ++j)
      for (unsigned i = 1; i + j < k_; ++i) f(i, j);
  }
  template <class Corner, class Triangle>
  void for_pieces(Corner&& at, Triangle&& f) const {
    for (unsigned j = 0; j < k_; ++j)
      for (unsigned i = 0; i + j < k_; ++i) {
        f(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < k_) f(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }

 private:
  unsigned k_;
  std::size_t own_;
};

Point2 between(const Point2& a, const Point2& b, const Point2& c, double s, double t) {
  return {a.x + s * (b.x - a.x) + t * (c.x - a.x), a.y + s * (b.y - a.y) + t * (c.y - a.y)};
}

}  // namespace

ArealParameters areal_parameters(const TriangleSurface& s, const Context& context) {
  context.check();
  ArealParameters p;
  if (s.triangles.empty()) return p;
  const double from = s.z[s.triangles[0][0]];
  const Level level = level_of(s, from);
  p.area = level.area.value();
  if (!(p.area > 0)) return p;
  p.mean = from + level.volume.value() / p.area;
  const double power = power_for(s, p.mean);
  const Moments m = moments_of(s, p.mean, power);
  p.sa = m.size.value() / p.area / power;
  const double sq = std::sqrt(m.second.value() / p.area);
  p.sq = sq / power;
  p.sp = std::max(m.high, 0.0), p.sv = std::max(-m.low, 0.0), p.sz = p.sp + p.sv;
  if (sq > 0) {
    p.ssk = m.third.value() / p.area / (sq * sq * sq);
    p.sku = m.fourth.value() / p.area / (sq * sq * sq * sq);
  }
  p.sdr = m.excess.value() / p.area;
  p.sdq = std::sqrt(m.slope.value() / p.area);
  p.sq_points = root_mean_square_of_nodes(s, p.mean, power);
  return p;
}

TriangleSurface refined(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                        std::span<const unsigned char> kept, unsigned pieces, const Context& context) {
  TriangleSurface out;
  out.xy.assign(xy.begin(), xy.end());
  out.z.assign(z.begin(), z.end());
  out.measured = xy.size();
  const auto is_kept = [&](Index i) { return !t.is_ghost(i) && (kept.empty() || kept[i] != 0); };
  std::vector<Index> used;
  for (Index i = 0; i < t.real; ++i)
    if (is_kept(i)) used.push_back(i);
  const Cut cut(pieces);
  const double step = 1.0 / pieces;
  if (static_cast<double>(used.size()) * pieces * pieces > static_cast<double>(max_nodes))
    throw UsageError("the surface has too many triangles to cut them: use linear interpolation");

  // New corners: on the sides, once each, by the half-edge that is met first; then inside the triangles.
  Locations where;
  Array<Index> first_on(pieces > 1 ? std::size_t{4} * t.real : 0);
  const auto add = [&](const Point2& p, Location::Kind kind, Index id) {
    out.xy.push_back(p);
    where.kind.push_back(kind), where.id.push_back(id);
  };
  if (pieces > 1)
    for (const Index i : used)
      for (Index side = 0; side < 3; ++side) {
        const HalfEdge h = half_edge(i, side), twin = t.twin(h);
        if (is_kept(triangle_of(twin)) && twin < h) continue;
        first_on[h] = static_cast<Index>(out.xy.size());
        const Point2 a = xy[t.origin(h)], b = xy[t.target(h)];
        for (unsigned n = 1; n < pieces; ++n) add(between(a, b, a, n * step, 0), Location::Kind::edge, h);
      }
  const std::size_t inside_begin = out.xy.size();
  for (const Index i : used) {
    const auto& v = t.triangles[i].v;
    cut.for_inside([&](unsigned a, unsigned b) {
      add(between(xy[v[0]], xy[v[1]], xy[v[2]], a * step, b * step), Location::Kind::triangle, i);
    });
  }
  if (pieces > 1) {
    const std::span<const Point2> made(out.xy.data() + xy.size(), out.xy.size() - xy.size());
    const Array<double> heights = interpolate_smooth(where, made, t, xy, z, context);
    out.z.insert(out.z.end(), heights.begin(), heights.end());
  }

  out.triangles.reserve(used.size() * pieces * pieces);
  for (std::size_t u = 0; u < used.size(); ++u) {
    const auto& v = t.triangles[used[u]].v;
    const auto on_side = [&](unsigned side, std::size_t n) {
      const HalfEdge h = half_edge(used[u], side), twin = t.twin(h);
      if (is_kept(triangle_of(twin)) && twin < h) return static_cast<Index>(first_on[twin] + (cut.on_side() - 1 - n));
      return static_cast<Index>(first_on[h] + n);
    };
    const auto inner = [&](std::size_t n) { return static_cast<Index>(inside_begin + u * cut.inside() + n); };
    cut.for_pieces([&](unsigned i, unsigned j) { return cut.corner(v, i, j, on_side, inner); },
                   [&](Index a, Index b, Index c) {
                     out.triangles.push_back({a, b, c});
                   });
  }
  return out;
}

}  // namespace isopach
