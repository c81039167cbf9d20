#include "isopach/overlay/smooth.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "isopach/base/parallel.hpp"

namespace isopach {

namespace {

constexpr unsigned terms = 9;                                // of SmoothSurface
constexpr std::array<unsigned, 3> terms_of_degree{9, 5, 2};  // cubic, quadratic, plane
constexpr std::array<unsigned, 3> least_neighbours{13, 7, 2};
constexpr double singular = 1e-8;  // a pivot below this share of its diagonal: the direction is not sampled
constexpr double excess = 0.125;   // of the range of heights seen

using Monomials = std::array<double, terms>;
Monomials monomials(double x, double y) {
  return {x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y};
}

/// A node's neighbours and theirs, and theirs again where these are few; a hub's are cut off.
class Ring {
 public:
  void collect(Index node, const Triangulation& t, std::span<const HalfEdge> leaving) {
    size_ = 0;
    add_neighbours(node, node, t, leaving, most / 2);
    const std::size_t first = size_;
    for (std::size_t i = 0; i < first; ++i) add_neighbours(nodes_[i], node, t, leaving, most);
    const std::size_t second = size_;
    if (second >= enough) return;
    for (std::size_t i = first; i < second; ++i) add_neighbours(nodes_[i], node, t, leaving, most);
  }
  [[nodiscard]] std::span<const Index> nodes() const { return {nodes_.data(), size_}; }

 private:
  static constexpr std::size_t most = 40, enough = 16;

  void add_neighbours(Index of, Index centre, const Triangulation& t, std::span<const HalfEdge> leaving,
                      std::size_t limit) {
    const HalfEdge start = leaving[of];
    HalfEdge h = start;
    do {
      const Index n = t.target(h);
      if (n != no_index && n != centre && size_ < limit &&
          std::find(nodes_.begin(), nodes_.begin() + size_, n) == nodes_.begin() + size_)
        nodes_[size_++] = n;
      h = t.next_leaving(h);
    } while (h != start && size_ < limit);
  }

  std::array<Index, most> nodes_{};
  std::size_t size_ = 0;
};

/// Solves the leading m equations by LDLᵀ; false where a pivot is lost.
bool solve(std::array<std::array<double, terms>, terms> a, Monomials b, unsigned m, Monomials& c) {
  for (unsigned j = 0; j < m; ++j) {
    const double diagonal = a[j][j];
    for (unsigned k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k] * a[k][k];
    if (!(a[j][j] > singular * diagonal)) return false;
    for (unsigned i = j + 1; i < m; ++i) {
      for (unsigned k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k] * a[k][k];
      a[i][j] /= a[j][j];
    }
  }
  for (unsigned i = 0; i < m; ++i)
    for (unsigned k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
  for (unsigned i = 0; i < m; ++i) b[i] /= a[i][i];
  for (unsigned i = m; i-- > 0;)
    for (unsigned k = i + 1; k < m; ++k) b[i] -= a[k][i] * b[k];
  c = {};
  std::copy_n(b.begin(), m, c.begin());
  return std::all_of(c.begin(), c.end(), [](double v) { return std::isfinite(v); });
}

double cross(const Point2& o, const Point2& a, const Point2& b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

/// The Clough–Tocher weight of each corner at barycentric l. Bernstein coefficients of the sub-triangle at the side ij
/// that l lies in, one for each weight. An edge's inner coefficient is the one that makes the derivative across it 0.
std::array<double, 3> corner_weights(const std::array<Point2, 3>& p, const std::array<double, 3>& l) {
  const unsigned k = l[0] <= l[1] && l[0] <= l[2] ? 0 : l[1] <= l[2] ? 1 : 2, i = (k + 1) % 3, j = (k + 2) % 3;
  const Point2 centre{(p[0].x + p[1].x + p[2].x) / 3, (p[0].y + p[1].y + p[2].y) / 3};
  std::array<double, 3> foot{};  // of the centroid on side s → s + 1, as a part of it
  for (unsigned s = 0; s < 3; ++s) {
    const Point2 &a = p[s], &b = p[(s + 1) % 3];
    const double dx = b.x - a.x, dy = b.y - a.y;
    foot[s] = ((centre.x - a.x) * dx + (centre.y - a.y) * dy) / (dx * dx + dy * dy);
  }
  const double u = l[i] - l[k], v = l[j] - l[k], c = 3 * l[k];
  std::array<double, 3> weight{};
  for (unsigned w = 0; w < 3; ++w) {
    std::array<double, 3> one{}, side{}, inner{};
    one[w] = 1;
    for (unsigned s = 0; s < 3; ++s) side[s] = (1 - foot[s]) * one[s] + foot[s] * one[(s + 1) % 3];
    for (unsigned s = 0; s < 3; ++s) inner[s] = (one[s] + side[s] + side[(s + 2) % 3]) / 3;
    weight[w] = one[i] * u * u * (u + 3 * v + 3 * c) + one[j] * v * v * (v + 3 * u + 3 * c) + 6 * side[i] * u * v * c +
                3 * c * c * (inner[i] * u + inner[j] * v) + c * c * c * (inner[0] + inner[1] + inner[2]) / 3;
  }
  return weight;
}

}  // namespace

double SmoothSurface::NodeFunction::at(double dx, double dy) const {
  const Monomials m = monomials(dx * scale, dy * scale);
  double value = 0;
  for (unsigned k = 0; k < terms; ++k) value += c[k] * m[k];
  return value;
}

SmoothSurface::NodeFunction SmoothSurface::fit(Index node, std::span<const Index> seen, std::span<const Point2> xy,
                                               std::span<const double> z) {
  NodeFunction f;
  double square = 0;
  for (const Index n : seen) {
    const double dx = xy[n].x - xy[node].x, dy = xy[n].y - xy[node].y;
    square += dx * dx + dy * dy;
    f.low = std::min(f.low, z[n] - z[node]), f.high = std::max(f.high, z[n] - z[node]);
  }
  square /= static_cast<double>(seen.size());
  const double scale = 1 / std::sqrt(square);
  if (!std::isfinite(scale)) return f;
  std::array<std::array<double, terms>, terms> a{};
  Monomials b{};
  for (const Index n : seen) {
    const double x = (xy[n].x - xy[node].x) * scale, y = (xy[n].y - xy[node].y) * scale, r = x * x + y * y + 0.1;
    const double weight = 1 / (r * r), dz = z[n] - z[node];
    const Monomials m = monomials(x, y);
    for (unsigned i = 0; i < terms; ++i) {
      b[i] += weight * m[i] * dz;
      for (unsigned j = 0; j <= i; ++j) a[i][j] += weight * m[i] * m[j];
    }
  }
  for (std::size_t degree = 0; degree < terms_of_degree.size(); ++degree)
    if (seen.size() >= least_neighbours[degree] && solve(a, b, terms_of_degree[degree], f.c)) {
      f.scale = scale;
      return f;
    }
  f.c = {};
  return f;
}

double SmoothSurface::in_triangle(const Point2& q, const Triangle& t, double linear) const {
  const std::array<Point2, 3> p{xy_[t.v[0]], xy_[t.v[1]], xy_[t.v[2]]};
  std::array<double, 3> l{cross(q, p[1], p[2]), cross(q, p[2], p[0]), cross(q, p[0], p[1])};
  const double area = l[0] + l[1] + l[2];
  for (double& part : l) part = std::max(0.0, part / area);
  const std::array<double, 3> weight = corner_weights(p, l);
  double value = 0, low = linear, high = linear;
  for (unsigned s = 0; s < 3; ++s) {
    const NodeFunction& f = functions_[t.v[s]];
    const double own = z_[t.v[s]];
    value += weight[s] * (own - linear + f.at(q.x - p[s].x, q.y - p[s].y));
    low = std::min(low, own + f.low), high = std::max(high, own + f.high);
  }
  value += linear;
  if (!std::isfinite(value)) return linear;
  const double margin = excess * (high - low);
  return std::clamp(value, low - margin, high + margin);
}

SmoothSurface::SmoothSurface(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                             const Context& context)
    : t_(t), xy_(xy), z_(z) {
  if (t.real == 0) return;
  Array<HalfEdge> leaving(xy.size());
  for (Index i = t.real; i-- > 0;)
    for (Index k = 0; k < 3; ++k) leaving[t.triangles[i].v[k]] = half_edge(i, k);
  functions_.resize(xy.size());
  for_blocks(xy.size(), default_block, [&](std::size_t begin, std::size_t end) {
    Ring ring;
    for (std::size_t i = begin; i < end; ++i) {
      ring.collect(static_cast<Index>(i), t, leaving);
      functions_[i] = fit(static_cast<Index>(i), ring.nodes(), xy, z);
    }
  });
  context.check();
}

Array<double> SmoothSurface::at(const Locations& where, std::span<const Point2> points, const Context& context) const {
  Array<double> value = interpolate(where, points, t_, xy_, z_, context);
  if (functions_.empty()) return value;
  for_each_index(where.size(), [&](std::size_t i) {
    const Location at = where[i];
    if (at.kind != Location::Kind::triangle && at.kind != Location::Kind::edge) return;
    const Index triangle = at.kind == Location::Kind::edge ? triangle_of(at.id) : at.id;
    value[i] = in_triangle(points[i], t_.triangles[triangle], value[i]);
  });
  return value;
}

Array<double> interpolate_smooth(const Locations& where, std::span<const Point2> points, const Triangulation& t,
                                 std::span<const Point2> xy, std::span<const double> z, const Context& context) {
  return SmoothSurface(t, xy, z, context).at(where, points, context);
}

}  // namespace isopach
