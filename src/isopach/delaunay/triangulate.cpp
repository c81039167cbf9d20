#include "isopach/delaunay/triangulate.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/ghosts.hpp"
#include "isopach/delaunay/plane.hpp"

namespace isopach {

namespace {

// Divide and conquer on ranges of nodes along the curve. A range that begins with node `lo` owns the triangle slots
// from 2·lo: a part of m nodes has exactly 2m − 2 triangles with its ghosts, and a merge adds two to those of its
// halves. So nothing is ever allocated, parts can be built side by side, and triangles lie in memory as their nodes lie
// on the curve.
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
    Part whole{first.lo, count, 0, 0, 0, 0};
    // The two are on either side of a straight cut, whichever way it runs.
    const bool across_x = before_x(first.most_x, second.least_x) || before_x(second.most_x, first.least_x);
    const bool ordered = across_x ? before_x(first.most_x, second.least_x) : before_y(first.most_y, second.least_y);
    const Part &low = ordered ? first : second, &high = ordered ? second : first;
    whole.least_x = across_x || before_x(low.least_x, high.least_x) ? low.least_x : high.least_x;
    whole.most_x = across_x || before_x(low.most_x, high.most_x) ? high.most_x : low.most_x;
    whole.least_y = !across_x || before_y(low.least_y, high.least_y) ? low.least_y : high.least_y;
    whole.most_y = !across_x || before_y(low.most_y, high.most_y) ? high.most_y : low.most_y;
    const double x = xy_[whole.most_x].x - xy_[whole.least_x].x, y = xy_[whole.most_y].y - xy_[whole.least_y].y;
    merge(low, across_x ? low.most_x : low.most_y, high, across_x ? high.least_x : high.least_y, x * x + y * y,
          2 * second.lo - 2);
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

  // The sides of a ghost that lead on, away from the base, along the left hull and along the right one.
  static constexpr Index left_side = 2, right_side = 1;

  // One half as the seam sees it: the candidate c that would join the base l→r, and the node d behind the edge between
  // the half's end of the base and c. Offsets are taken from that end.
  //
  // With X = b×c, A = ±c×d, f(p) = |p|² − c·p, where b is the base and p its other end or d: in_circle(l, r, c, d) is
  // −(X·f(d) + A·f(b)), and X the orientation of c above the base. A and f(d) outlive the steps of the other half.
  struct Half {
    Index ghost = no_index;  // of the hull edge between the end and c
    Index c = no_index, d = no_index;
    Point2 to_c{0, 0}, to_d{0, 0};
    double area = 0, behind = 0;      // A, f(d)
    double above = 0, other_end = 0;  // X, f(b)
  };

  // Bounds of the rounding errors of X and of the sum, for points within sqrt(s) of each other: by Shewchuk's way of
  // counting (1997), with u = 2⁻⁵³, |X̂ − X| <= 4u·s, and each of the two products carries at most 11u on monomials that
  // add up to at most 2s². The constants leave 2 % for terms of higher order and for underflow, which is below
  // 2⁻¹⁰⁷⁰(s + 1), see underflow_guard.
  struct Bounds {
    double orientation, in_circle;
    // (4s² is infinite wherever a sum may be.)
    explicit Bounds(double s)
        : orientation(4.53e-16 * s + underflow_guard), in_circle(1.2475e-15 * (4 * s * s) + underflow_guard) {}
  };

  // [Guibas1985], on ghosts. `left` lies left of (or below) `right`, l and r are their nodes next to the cut.
  // Between the halves the ghosts of the facing hull chains become the triangles of the seam: a ghost (c, l, none) gets
  // r as its third node, and nothing moves. start_ holds the ghost that starts at a node, kept right for extreme nodes:
  // the seam leaves all other ghosts of the new hull as they were.
  void merge(const Part& left, Index l, const Part& right, Index r, double extent, Index slot) {
    const Bounds bounds(extent);
    const bool has_left = left.count > 1, has_right = right.count > 1;
    Half hl, hr;
    if (has_left) hl.ghost = start_[l];
    if (has_right) hr.ghost = previous_ghost(start_[r]);
    lower_tangent(hl.ghost, hr.ghost, l, r);

    const Index bottom = slot, top = slot + 1;
    ghost(bottom, l, r);
    start_[l] = bottom;
    if (has_left) link(half_edge(bottom, 1), t_[hl.ghost].n[1]);
    if (has_right) link(half_edge(bottom, 2), t_[hr.ghost].n[2]);
    HalfEdge below = half_edge(bottom, 0);

    if (has_left) look<left_side>(hl, xy_[l]);
    if (has_right) look<right_side>(hr, xy_[r]);
    for (;;) {
      const bool left_joins = has_left && candidate<left_side>(hl, l, r, bounds);
      const bool right_joins = has_right && candidate<right_side>(hr, l, r, bounds);
      if (!left_joins && !right_joins) break;
      if (!left_joins || (right_joins && right_first(hl, hr.c, l, r, bounds))) {
        const Index g = hr.ghost;
        hr.ghost = previous_ghost(g);
        t_[g].v[2] = l;  // (r, c, l)
        link(half_edge(g, 2), below);
        below = half_edge(g, 1);
        r = hr.c;
        look<right_side>(hr, xy_[r]);
      } else {
        const Index g = hl.ghost;
        hl.ghost = next_ghost(g);
        t_[g].v[2] = r;  // (c, l, r)
        link(half_edge(g, 1), below);
        below = half_edge(g, 2);
        l = hl.c;
        look<left_side>(hl, xy_[l]);
      }
    }

    ghost(top, r, l);
    start_[r] = top;
    link(half_edge(top, 0), below);
    link(half_edge(top, 1), has_right ? half_edge(hr.ghost, 2) : half_edge(bottom, 2));
    link(half_edge(top, 2), has_left ? half_edge(hl.ghost, 1) : half_edge(bottom, 1));
  }

  static Point2 offset(const Point2& from, const Point2& to) { return {to.x - from.x, to.y - from.y}; }

  // Sets c and d from the ghost.
  template <Index on>
  void look(Half& h, const Point2& end) const {
    h.c = t_[h.ghost].v[on == left_side ? 0 : 1];
    h.to_c = offset(end, xy_[h.c]);
    look_behind<on>(h, end);
  }
  template <Index on>
  void look_behind(Half& h, const Point2& end) const {
    const HalfEdge edge = t_[h.ghost].n[0];
    h.d = t_[triangle_of(edge)].v[previous_side(side_of(edge))];
    if (h.d == no_index) {  // a circle never forbids an edge with nothing behind it
      h.area = 0;
      h.behind = std::numeric_limits<double>::infinity();
      return;
    }
    h.to_d = offset(end, xy_[h.d]);
    h.area = on == left_side ? Plane::cross(h.to_c, h.to_d) : Plane::cross(h.to_d, h.to_c);
    h.behind = Plane::dot(h.to_d, h.to_d) - Plane::dot(h.to_c, h.to_d);
  }

  // Does a node of this half lie above the base? Then it is c, after deleting the edges that the circle rule forbids.
  template <Index on>
  bool candidate(Half& h, Index l, Index r, const Bounds& bounds) {
    const Point2 b = offset(xy_[l], xy_[r]);
    h.above = Plane::cross(b, h.to_c);
    if (!(h.above > bounds.orientation)) {
      if (h.above < -bounds.orientation || xy_.turn(l, r, h.c) <= 0) return false;
      h.above = std::max(h.above, 0.0);  // positive, whatever rounding says
    }
    for (;;) {
      const double along = Plane::dot(b, h.to_c);
      h.other_end = on == left_side ? Plane::dot(b, b) - along : Plane::dot(b, b) + along;
      const double det = h.above * h.behind + h.area * h.other_end;
      if (det > bounds.in_circle) return true;
      if (!(det < -bounds.in_circle) && (h.d == no_index || !xy_.inside(l, r, h.c, h.d))) return true;
      remove_edge<on>(h);
      h.c = h.d;
      h.to_c = h.to_d;
      look_behind<on>(h, xy_[on == left_side ? l : r]);
      h.above = std::max(Plane::cross(b, h.to_c), 0.0);  // inside the circle, so above the base
    }
  }

  // Both halves have a candidate: is that of the right one inside the circle of the other?
  [[nodiscard]] bool right_first(const Half& left, Index cr, Index l, Index r, const Bounds& bounds) const {
    const Point2 d = offset(xy_[l], xy_[cr]);
    const double behind = Plane::dot(d, d) - Plane::dot(left.to_c, d);
    const double det = left.above * behind + Plane::cross(left.to_c, d) * left.other_end;
    if (det < -bounds.in_circle) return true;
    return !(det > bounds.in_circle) && xy_.inside(l, r, left.c, cr);
  }

  // Flips the triangle behind the edge end–c over to the outside: two ghosts, end–d and d–c.
  template <Index on>
  void remove_edge(const Half& h) {
    constexpr bool is_left = on == left_side;
    const Index g = h.ghost;
    const HalfEdge edge = t_[g].n[0];  // l→c, c→r
    const Index t = triangle_of(edge), k = side_of(edge);
    const HalfEdge beyond_end = t_[t].n[is_left ? previous_side(k) : next_side(k)];
    const HalfEdge beyond_c = t_[t].n[is_left ? next_side(k) : previous_side(k)];
    const HalfEdge following = t_[g].n[on];
    if (is_left) {
      t_[g].v[0] = h.d;
      ghost(t, h.d, h.c);
    } else {
      t_[g].v[1] = h.d;
      ghost(t, h.c, h.d);
    }
    link(half_edge(g, 0), beyond_end);
    link(half_edge(t, 0), beyond_c);
    link(half_edge(t, 3 - on), half_edge(g, on));
    link(half_edge(t, on), following);
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

  const Plane xy_;
  std::span<const std::uint64_t> keys_;
  Triangle* t_;
  Array<Index> starts_;
  Index* start_;
};

void check_size(std::size_t n) {
  if (n > max_nodes)
    throw UsageError(std::to_string(n) + " nodes are more than this build can index (" + std::to_string(max_nodes) +
                     "): build with -DISOPACH_INDEX_BITS=64 or thin the scan");
}

Triangulation triangulate_keyed(std::span<const Point2> xy, std::span<const std::uint64_t> keys) {
  Triangulation result;
  result.nodes = static_cast<Index>(xy.size());
  if (xy.size() < 2) return result;
  result.triangles.resize(2 * xy.size() - 2);
  const Index ghost = Builder(xy, keys, result.triangles).build();
  result.real = gather_ghosts(result.triangles, ghost);
  return result;
}

// Sorted points become nodes: of equal ones, which follow each other, the first.
void merge_equal(Array<Point2>& xy, Array<std::uint64_t>& keys, Array<Index>& order, Array<Index>& node_of) {
  const std::size_t n = xy.size();
  node_of.resize(n);
  const auto is_first = [&](std::size_t i) { return i == 0 || !(xy[i] == xy[i - 1]); };
  std::vector<std::size_t> place((n + default_block - 1) / default_block);
  for_blocks(n, default_block, [&](std::size_t begin, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < end; ++i) count += is_first(i) ? 1 : 0;
    place[begin / default_block] = count;
  });
  std::size_t nodes = 0;
  for (std::size_t& p : place) nodes += std::exchange(p, nodes);
  if (nodes == n) {
    for_each_index(n, [&](std::size_t i) { node_of[order[i]] = static_cast<Index>(i); });
    return;
  }
  Array<Point2> new_xy(nodes);
  Array<std::uint64_t> new_keys(nodes);
  Array<Index> new_order(nodes);
  for_blocks(n, default_block, [&](std::size_t begin, std::size_t end) {
    std::size_t next = place[begin / default_block];
    for (std::size_t i = begin; i < end; ++i) {
      if (is_first(i)) {
        new_xy[next] = xy[i];
        new_keys[next] = keys[i];
        new_order[next++] = order[i];
      }
      node_of[order[i]] = static_cast<Index>(next - 1);
    }
  });
  xy.swap(new_xy);
  keys.swap(new_keys);
  order.swap(new_order);
}

}  // namespace

Triangulation triangulate(std::span<const Point2> xy, const CurveBox& box, const Context& context) {
  check_size(xy.size());
  context.check();
  Array<std::uint64_t> keys(xy.size());
  for_each_index(xy.size(), [&](std::size_t i) { keys[i] = curve_key(box, xy[i]); });
  return triangulate_keyed(xy, keys);
}

Triangulation triangulate(std::span<const Point2> xy, std::span<const std::uint64_t> keys, const Context& context) {
  if (keys.size() != xy.size()) throw std::logic_error("triangulate: as many keys as nodes");
  check_size(xy.size());
  context.check();
  return triangulate_keyed(xy, keys);
}

SortedTriangulation triangulate_unsorted(std::span<const Point2> points, const Context& context) {
  context.check();
  const Box2 bounds = reduce_blocks<Box2>(
      points.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Box2 box;
        for (std::size_t i = begin; i < end; ++i) box.add(points[i]);
        return box;
      },
      [](Box2& total, const Box2& box) { total.add(box); });
  SortedTriangulation result;
  Array<std::uint64_t> keys;
  result.order = curve_order(points, curve_box(bounds), &keys, &result.xy);
  merge_equal(result.xy, keys, result.order, result.node_of);
  check_size(result.xy.size());
  context.check();
  result.triangulation = triangulate_keyed(result.xy, keys);
  return result;
}

}  // namespace isopach
