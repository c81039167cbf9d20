#include "isopach/delaunay/triangulate.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

// A point as the seam sees it: from the left end l of the base l→r. `cross` is twice the area of l, r, point.
struct Offset {
  double x, y, lift, cross;
};

// The predicates of the seam. All are taken from l, so that the orientation above the base is a minor of the in_circle
// determinant and each point's lift serves several tests.
//
// The filters are those of geom/predicates.hpp with the permanent replaced by a bound of it: |p×q| <= |p||q|, so the
// permanent of in_circle is at most 3s² and that of orientation at most s, where s is the largest squared distance from
// l. (It also makes the absolute guard cover every underflow: their sum is below 2⁻¹⁰⁷⁰(s + 1).) What they cannot decide
// goes to the other file's filter and exact stage, unless the arithmetic was exact to begin with: where all coordinates
// are multiples of a power of two g (rasters, quantised scans) and s <= 2²⁵g², every intermediate result is an integer
// below 2⁵³ times a power of g; for orientation, where s <= 2⁵¹g².
class Plane {
 public:
  explicit Plane(std::span<const Point2> xy) : xy_(xy.data()) {
    const double g = common_step(xy);
    if (g > 0) exact_in_circle_ = 0x1p25 * g * g, exact_orientation_ = 0x1p51 * g * g;
  }

  [[nodiscard]] const Point2& operator[](Index node) const { return xy_[node]; }

  [[nodiscard]] int turn(Index a, Index b, Index c) const {
    const Point2 &p = xy_[a], &q = xy_[b], &r = xy_[c];
    const double qx = q.x - p.x, qy = q.y - p.y, rx = r.x - p.x, ry = r.y - p.y;
    const double left = qx * ry, right = qy * rx;
    const double det = left - right;
    const double bound = orientation_filter * (std::fabs(left) + std::fabs(right)) + underflow_guard;
    if (det > bound) return 1;
    if (det < -bound) return -1;
    if (std::max(qx * qx + qy * qy, rx * rx + ry * ry) <= exact_orientation_) return det > 0 ? 1 : (det < 0 ? -1 : 0);
    return orientation(p, q, r);
  }

  // The base; changes whenever one of its ends does.
  struct Base {
    Index l, r;
    Point2 origin;
    double x, y, lift;
  };
  [[nodiscard]] Base base(Index l, Index r) const {
    const Point2 &p = xy_[l], &q = xy_[r];
    const double x = q.x - p.x, y = q.y - p.y;
    return {l, r, p, x, y, x * x + y * y};
  }
  [[nodiscard]] Offset offset(const Base& b, Index node) const {
    const double x = xy_[node].x - b.origin.x, y = xy_[node].y - b.origin.y;
    return {x, y, x * x + y * y, b.x * y - b.y * x};
  }
  // Is c left of the base l→r?
  [[nodiscard]] bool above(const Base& b, const Offset& c, Index c_node) const {
    const double s = std::max(b.lift, c.lift);
    if (std::fabs(c.cross) > orientation_bound * s + underflow_guard || s <= exact_orientation_) return c.cross > 0;
    return orientation(xy_[b.l], xy_[b.r], xy_[c_node]) > 0;
  }
  // Is d inside the circle through l, r, c?
  [[nodiscard]] bool inside(const Base& b, const Offset& c, Index c_node, const Offset& d, Index d_node) const {
    const double cd = c.x * d.y - c.y * d.x;
    const double det = c.lift * d.cross - d.lift * c.cross - b.lift * cd;
    const double s = std::max(b.lift, std::max(c.lift, d.lift));
    if (std::fabs(det) > in_circle_bound * (s * s) + underflow_guard) return det > 0;
    if (s <= exact_in_circle_) return det == 0 ? exact_tie(b, c, d, cd) : det > 0;
    return inside_circle(xy_[b.l], xy_[b.r], xy_[c_node], xy_[d_node]);
  }

 private:
  static constexpr double orientation_bound = 3.4e-16, in_circle_bound = 3.4e-15;

  // tie_is_inside, its orientations read off the minors.
  static bool exact_tie(const Base& b, const Offset& c, const Offset& d, double cd) {
    const Point2 pl{0, 0}, pr{b.x, b.y}, pc{c.x, c.y}, pd{d.x, d.y};
    const bool r_over_l = lexicographic_less(pl, pr), d_over_c = lexicographic_less(pc, pd);
    const Point2 lr = r_over_l ? pr : pl, cd_greater = d_over_c ? pd : pc;
    if (lexicographic_less(lr, cd_greater)) return !d_over_c && d.cross > 0;
    return (r_over_l ? -cd : c.cross - d.cross + cd) > 0;
  }

  // The largest power of two that divides every coordinate, 0 if that is too small beside them to be of use.
  static double common_step(std::span<const Point2> xy) {
    int low = 1100, high = -1100;
    for (const Point2& p : xy) {
      for (const double value : {p.x, p.y}) {
        const auto bits = std::bit_cast<std::uint64_t>(value);
        const std::uint64_t fraction = bits & 0xfffffffffffffULL;
        const int exponent = static_cast<int>((bits >> 52) & 0x7ff) - 1023;
        if (value == 0) continue;
        high = std::max(high, exponent);
        low = std::min(low, exponent - 52 + (fraction == 0 ? 52 : std::countr_zero(fraction)));
      }
      if (high - low > 45) return 0;
    }
    return low > -400 && high < 400 ? std::ldexp(1.0, low) : 0;
  }

  const Point2* xy_;
  double exact_in_circle_ = -1, exact_orientation_ = -1;
};

// Divide and conquer on ranges of nodes along the curve. A range that begins with node `lo` owns the triangle slots from
// 2·lo: a part of m nodes has exactly 2m − 2 triangles with its ghosts, and a merge adds two to those of its halves. So
// nothing is ever allocated, parts can be built side by side, and triangles lie in memory as their nodes lie on the
// curve.
class Builder {
 public:
  Builder(std::span<const Point2> xy, std::span<const std::uint64_t> keys, Array<Triangle>& triangles)
      : xy_(xy), keys_(keys), t_(triangles.data()), starts_(xy.size()), start_(starts_.data()) {}

  // Returns a ghost.
  Index build() {
    Part whole = build(0, keys_.size());
    make(whole);
    return start_[whole.least_x];
  }

 private:
  static constexpr std::size_t parallel_size = 4096;

  // `count` nodes from `lo` on. Up to three are left unmade until they are merged. The extreme nodes: first and last in
  // lexicographic order of (x, y), and of (y, −x), which is the same after a quarter turn.
  struct Part {
    Index lo, count;
    Index least_x, most_x, least_y, most_y;
  };

  [[nodiscard]] bool before_x(Index a, Index b) const { return lexicographic_less(xy_[a], xy_[b]); }
  [[nodiscard]] bool before_y(Index a, Index b) const {
    const Point2 &p = xy_[a], &q = xy_[b];
    return p.y < q.y || (p.y == q.y && p.x > q.x);
  }

  void link(HalfEdge a, HalfEdge b) {
    t_[triangle_of(a)].n[side_of(a)] = b;
    t_[triangle_of(b)].n[side_of(b)] = a;
  }
  [[nodiscard]] Index next_ghost(Index g) const { return triangle_of(t_[g].n[2]); }
  [[nodiscard]] Index previous_ghost(Index g) const { return triangle_of(t_[g].n[1]); }
  void ghost(Index g, Index from, Index to) { t_[g].v = {to, from, no_index}; }

  Part build(std::size_t lo, std::size_t hi) {
    if (hi - lo <= parallel_size) return build_block(lo, hi);
    const std::size_t middle = cut(lo, hi);
    Part first, second;
    both([&] { first = build(lo, middle); }, [&] { second = build(middle, hi); });
    return join(first, second);
  }

  // Where the highest bit in which the keys differ changes: the middle of the square (or half of it) they fill. Nodes
  // of one cell are in lexicographic order: any cut will do.
  [[nodiscard]] std::size_t cut(std::size_t lo, std::size_t hi) const {
    const std::uint64_t difference = keys_[lo] ^ keys_[hi - 1];
    if (difference == 0) return lo + (hi - lo) / 2;
    const int bit = 63 - std::countl_zero(difference);
    const auto begin = keys_.begin();
    return static_cast<std::size_t>(std::lower_bound(begin + static_cast<std::ptrdiff_t>(lo),
                                                     begin + static_cast<std::ptrdiff_t>(hi),
                                                     keys_[hi - 1] >> bit << bit) -
                                    begin);
  }

  // The same cuts, found from left to right: a part is complete when a higher bit changes behind it.
  Part build_block(std::size_t lo, std::size_t hi) {
    struct Open {
      Part part;
      int bit;  // that changes behind it
    };
    std::array<Open, 65> open;
    std::size_t depth = 0;
    for (std::size_t i = lo; i < hi;) {
      std::size_t end = i + 1;
      while (end < hi && keys_[end] == keys_[i]) ++end;
      Part part = build_cell(i, end);
      const int bit = end == hi ? 64 : 63 - std::countl_zero(keys_[end - 1] ^ keys_[end]);
      while (depth > 0 && open[depth - 1].bit < bit) part = join(open[--depth].part, part);
      open[depth++] = {part, bit};
      i = end;
    }
    return open[0].part;
  }

  Part build_cell(std::size_t lo, std::size_t hi) {
    if (hi - lo <= 3) return {static_cast<Index>(lo), static_cast<Index>(hi - lo), 0, 0, 0, 0};
    const std::size_t middle = lo + (hi - lo) / 2;
    const Part first = build_cell(lo, middle);
    return join(first, build_cell(middle, hi));
  }

  // Parts that follow each other on the curve.
  Part join(Part first, Part second) {
    const Index count = first.count + second.count;
    if (count <= 3) return {first.lo, count, 0, 0, 0, 0};
    make(first);
    make(second);
    const Index slot = 2 * second.lo - 2;
    Part whole{first.lo, count, 0, 0, 0, 0};
    // The two are on either side of a straight cut, whichever way it runs.
    const bool first_is_left = before_x(first.most_x, second.least_x);
    if (first_is_left || before_x(second.most_x, first.least_x)) {
      const Part &left = first_is_left ? first : second, &right = first_is_left ? second : first;
      merge(left, left.most_x, right, right.least_x, slot);
      whole.least_x = left.least_x;
      whole.most_x = right.most_x;
      whole.least_y = before_y(left.least_y, right.least_y) ? left.least_y : right.least_y;
      whole.most_y = before_y(left.most_y, right.most_y) ? right.most_y : left.most_y;
    } else {
      const bool first_is_low = before_y(first.most_y, second.least_y);
      const Part &low = first_is_low ? first : second, &high = first_is_low ? second : first;
      merge(low, low.most_y, high, high.least_y, slot);
      whole.least_y = low.least_y;
      whole.most_y = high.most_y;
      whole.least_x = before_x(low.least_x, high.least_x) ? low.least_x : high.least_x;
      whole.most_x = before_x(low.most_x, high.most_x) ? high.most_x : low.most_x;
    }
    return whole;
  }

  void make(Part& part) {
    if (part.count > 3) return;
    const Index a = part.lo;
    part.least_x = part.most_x = part.least_y = part.most_y = a;
    for (Index b = a + 1; b < a + part.count; ++b) {
      part.least_x = before_x(b, part.least_x) ? b : part.least_x;
      part.most_x = before_x(part.most_x, b) ? b : part.most_x;
      part.least_y = before_y(b, part.least_y) ? b : part.least_y;
      part.most_y = before_y(part.most_y, b) ? b : part.most_y;
    }
    if (part.count == 2) two(a);
    if (part.count == 3) three(a, part);
  }

  void two(Index a) {
    const Index g = 2 * a;
    t_[g] = {{a + 1, a, no_index}, {half_edge(g + 1, 0), half_edge(g + 1, 2), half_edge(g + 1, 1)}};
    t_[g + 1] = {{a, a + 1, no_index}, {half_edge(g, 0), half_edge(g, 2), half_edge(g, 1)}};
    start_[a] = g;
    start_[a + 1] = g + 1;
  }

  void three(Index first, const Part& part) {
    const Index g = 2 * first;
    Index a = first, b = first + 1, c = first + 2;
    const int turn = xy_.turn(a, b, c);
    if (turn == 0) return collinear_three(g, part.least_x, 3 * first + 3 - part.least_x - part.most_x, part.most_x);
    if (turn < 0) std::swap(b, c);
    t_[g + 3] = {{a, b, c}, {half_edge(g, 0), half_edge(g + 1, 0), half_edge(g + 2, 0)}};
    t_[g] = {{b, a, no_index}, {half_edge(g + 3, 0), half_edge(g + 2, 2), half_edge(g + 1, 1)}};
    t_[g + 1] = {{c, b, no_index}, {half_edge(g + 3, 1), half_edge(g, 2), half_edge(g + 2, 1)}};
    t_[g + 2] = {{a, c, no_index}, {half_edge(g + 3, 2), half_edge(g + 1, 2), half_edge(g, 1)}};
    start_[a] = g;
    start_[b] = g + 1;
    start_[c] = g + 2;
  }

  void collinear_three(Index g, Index a, Index b, Index c) {
    ghost(g, a, b);
    ghost(g + 1, b, c);
    ghost(g + 2, c, b);
    ghost(g + 3, b, a);
    link(half_edge(g, 0), half_edge(g + 3, 0));
    link(half_edge(g + 1, 0), half_edge(g + 2, 0));
    for (Index k = 0; k < 4; ++k) link(half_edge(g + k, 2), half_edge(g + (k + 1) % 4, 1));
    start_[a] = g;
    start_[c] = g + 2;
  }

  // Guibas, Stolfi 1985, on ghosts. `left` lies left of (or below) `right`, l and r are their nodes next to the cut.
  // Between the halves the ghosts of the facing hull chains become the triangles of the seam: a ghost (c, l, none) gets
  // r as its third node, and nothing moves. start_ holds the ghost that starts at a node, kept right for extreme nodes:
  // the seam leaves all other ghosts of the new hull as they were.
  void merge(const Part& left, Index l, const Part& right, Index r, Index slot) {
    const bool has_left = left.count > 1, has_right = right.count > 1;
    Index gl = has_left ? start_[l] : no_index;                   // of the hull edge that starts at l
    Index gr = has_right ? previous_ghost(start_[r]) : no_index;  // of the one that ends at r
    lower_tangent(gl, gr, l, r);

    const Index bottom = slot, top = slot + 1;
    ghost(bottom, l, r);
    start_[l] = bottom;
    if (has_left) link(half_edge(bottom, 1), t_[gl].n[1]);
    if (has_right) link(half_edge(bottom, 2), t_[gr].n[2]);
    HalfEdge below = half_edge(bottom, 0);

    for (;;) {
      const Plane::Base base = xy_.base(l, r);
      Candidate cl{no_index, {}}, cr{no_index, {}};
      if (has_left) cl = candidate<left_side>(base, gl);
      if (has_right) cr = candidate<right_side>(base, gr);
      if (cl.node == no_index && cr.node == no_index) break;
      if (cl.node == no_index ||
          (cr.node != no_index && xy_.inside(base, cl.offset, cl.node, cr.offset, cr.node))) {
        const Index following = previous_ghost(gr);
        t_[gr].v[2] = l;  // (r, cr, l)
        link(half_edge(gr, 2), below);
        below = half_edge(gr, 1);
        r = cr.node;
        gr = following;
      } else {
        const Index following = next_ghost(gl);
        t_[gl].v[2] = r;  // (cl, l, r)
        link(half_edge(gl, 1), below);
        below = half_edge(gl, 2);
        l = cl.node;
        gl = following;
      }
    }

    ghost(top, r, l);
    start_[r] = top;
    link(half_edge(top, 0), below);
    link(half_edge(top, 1), has_right ? half_edge(gr, 2) : half_edge(bottom, 2));
    link(half_edge(top, 2), has_left ? half_edge(gl, 1) : half_edge(bottom, 1));
  }

  void lower_tangent(Index& gl, Index& gr, Index& l, Index& r) const {
    for (;;) {
      if (gr != no_index) {
        const Index g = next_ghost(gr);
        const Index y = t_[g].v[0];
        if (xy_.turn(l, r, y) < 0) {
          gr = g;
          r = y;
          continue;
        }
      }
      if (gl != no_index) {
        const Index g = previous_ghost(gl);
        const Index x = t_[g].v[1];
        if (xy_.turn(l, r, x) < 0) {
          gl = g;
          l = x;
          continue;
        }
      }
      return;
    }
  }

  struct Candidate {
    Index node;
    Offset offset;
  };
  // The sides of a ghost that lead on, away from the base, along the left hull and along the right one.
  static constexpr Index left_side = 2, right_side = 1;

  // The node that would join the base from one half, after deleting the edges from the base's end that the circle rule
  // forbids; no_index if none lies above the base. `g` is the ghost of the hull edge between the base's end and the
  // candidate. A deleted edge flips a triangle over to the outside: two ghosts again.
  template <Index on>
  Candidate candidate(const Plane::Base& base, Index g) {
    constexpr bool is_left = on == left_side;
    constexpr Index back = 3 - on;
    Candidate c;
    c.node = t_[g].v[is_left ? 0 : 1];
    c.offset = xy_.offset(base, c.node);
    if (!xy_.above(base, c.offset, c.node)) return {no_index, {}};
    for (;;) {
      const HalfEdge h = t_[g].n[0];  // l→c, c→r
      const Index t = triangle_of(h), k = side_of(h);
      const Index d = t_[t].v[previous_side(k)];
      if (d == no_index) return c;
      const Offset offset = xy_.offset(base, d);
      if (!xy_.inside(base, c.offset, c.node, offset, d)) return c;
      const HalfEdge beyond_own = t_[t].n[is_left ? previous_side(k) : next_side(k)];
      const HalfEdge beyond_other = t_[t].n[is_left ? next_side(k) : previous_side(k)];
      const HalfEdge following = t_[g].n[on];
      if (is_left) {
        ghost(g, base.l, d);
        ghost(t, d, c.node);
      } else {
        ghost(g, d, base.r);
        ghost(t, c.node, d);
      }
      link(half_edge(g, 0), beyond_own);
      link(half_edge(t, 0), beyond_other);
      link(half_edge(t, back), half_edge(g, on));
      link(half_edge(t, on), following);
      c = {d, offset};
    }
  }

  const Plane xy_;
  std::span<const std::uint64_t> keys_;
  Triangle* t_;
  Array<Index> starts_;
  Index* start_;
};

void exchange(Array<Triangle>& t, Index i, Index j) {
  const auto moved = [&](HalfEdge h) {
    if (triangle_of(h) == i) return half_edge(j, side_of(h));
    if (triangle_of(h) == j) return half_edge(i, side_of(h));
    return h;
  };
  std::swap(t[i], t[j]);
  for (const Index s : {i, j})
    for (auto& h : t[s].n) h = moved(h);
  for (const Index s : {i, j})
    for (Index k = 0; k < 3; ++k) t[triangle_of(t[s].n[k])].n[side_of(t[s].n[k])] = half_edge(s, k);
}

// Ghosts to the end. There are few of them: only they and as many real triangles move.
Index gather_ghosts(Array<Triangle>& t, Index ghost) {
  std::vector<Index> ring;
  for (Index g = ghost;;) {
    ring.push_back(g);
    g = triangle_of(t[g].n[2]);
    if (g == ghost) break;
  }
  const auto real = static_cast<Index>(t.size() - ring.size());
  std::sort(ring.begin(), ring.end());
  auto free = static_cast<Index>(t.size());
  for (const Index g : ring) {
    if (g >= real) break;
    do --free;
    while (t[free].v[2] == no_index);
    exchange(t, g, free);
  }
  return real;
}

}  // namespace

Triangulation triangulate(std::span<const Point2> xy, const CurveBox& box, const Context& context) {
  const std::size_t n = xy.size();
  if (n > max_nodes)
    throw UsageError(std::to_string(n) + " nodes are more than this build can index (" + std::to_string(max_nodes) +
                     "): build with -DISOPACH_INDEX_BITS=64 or thin the scan");
  Triangulation result;
  result.nodes = static_cast<Index>(n);
  if (n < 2) return result;
  context.check();
  result.triangles.resize(2 * n - 2);
  Array<std::uint64_t> keys(n);
  for_each_index(n, [&](std::size_t i) { keys[i] = curve_key(box, xy[i]); });
  const Index ghost = Builder(xy, keys, result.triangles).build();
  result.real = gather_ghosts(result.triangles, ghost);
  return result;
}

SortedTriangulation triangulate_unsorted(std::span<const Point2> points, const Context& context) {
  Box2 bounds;
  for (const Point2& p : points) bounds.add(p);
  const CurveBox box = curve_box(bounds);
  const Array<Index> sorted = curve_order(points, box);
  SortedTriangulation result;
  result.node_of.resize(points.size());
  result.xy.reserve(points.size());
  result.order.reserve(points.size());
  for (const Index id : sorted) {
    if (result.xy.empty() || !(result.xy.back() == points[id])) {
      result.xy.push_back(points[id]);
      result.order.push_back(id);
    }
    result.node_of[id] = static_cast<Index>(result.xy.size() - 1);
  }
  result.triangulation = triangulate(result.xy, box, context);
  return result;
}

}  // namespace isopach
