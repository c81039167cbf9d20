#include "isopach/delaunay/triangulate.hpp"

#include <algorithm>
#include <bit>
#include <string>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

// How the sides of a cut lie: for a cut across x the first part has the smaller x, for a cut across y the smaller y,
// unless `first_is_high`.
struct Cut {
  std::size_t middle;
  bool across_y;
  bool first_is_high;
};

// Divide and conquer on the nodes [lo, hi) of the curve. The part owns the triangle slots [2·lo, 2·hi − 2): a part of m
// nodes has exactly 2m − 2 triangles with its ghosts, and a merge adds two to those of its halves. So nothing is ever
// allocated, parts can be built side by side, and triangles lie in memory as their nodes lie on the curve.
class Builder {
 public:
  Builder(std::span<const Point2> xy, const Array<std::uint64_t>& keys, Array<Triangle>& triangles)
      : xy_(xy), keys_(keys), t_(triangles.data()) {}

  // Returns one ghost of the part, no_index for a part of one node.
  Index build(std::size_t lo, std::size_t hi) {
    const std::size_t n = hi - lo;
    if (n == 1) return no_index;
    if (n == 2) return two(static_cast<Index>(lo));
    if (n == 3) return three(static_cast<Index>(lo));
    const Cut cut = find_cut(lo, hi);
    Index first = no_index, second = no_index;
    if (n > parallel_size) {
      both([&] { first = build(lo, cut.middle); }, [&] { second = build(cut.middle, hi); });
    } else {
      first = build(lo, cut.middle);
      second = build(cut.middle, hi);
    }
    // A part of one node has no ghost to find it by.
    Part low{static_cast<Index>(lo), first}, high{static_cast<Index>(cut.middle), second};
    if (cut.first_is_high) std::swap(low, high);
    return merge(low, high, cut.across_y, static_cast<Index>(2 * cut.middle - 2));
  }

 private:
  static constexpr std::size_t parallel_size = 4096;

  struct Part {
    Index node;   // its only node if it has no ghost
    Index ghost;  // any of its ghosts, or no_index
  };

  void link(HalfEdge a, HalfEdge b) {
    t_[triangle_of(a)].n[side_of(a)] = b;
    t_[triangle_of(b)].n[side_of(b)] = a;
  }
  [[nodiscard]] Index next_ghost(Index g) const { return triangle_of(t_[g].n[2]); }
  [[nodiscard]] Index previous_ghost(Index g) const { return triangle_of(t_[g].n[1]); }
  void ghost(Index g, Index from, Index to) { t_[g].v = {to, from, no_index}; }

  Cut find_cut(std::size_t lo, std::size_t hi) const {
    const std::uint64_t difference = keys_[lo] ^ keys_[hi - 1];
    if (difference == 0) return {lo + (hi - lo) / 2, false, false};  // one cell: lexicographic order
    const int bit = 63 - std::countl_zero(difference);
    // First key with the bit set.
    const std::uint64_t boundary = keys_[hi - 1] >> bit << bit;
    const auto begin = keys_.begin() + static_cast<std::ptrdiff_t>(lo);
    const auto end = keys_.begin() + static_cast<std::ptrdiff_t>(hi);
    const auto middle = static_cast<std::size_t>(std::lower_bound(begin, end, boundary) - keys_.begin());
    // The digits above say how the square is turned: digits 0 and 3 swap the axes, digit 3 inverts both.
    const int level = bit / 2;
    const int above = 2 * (31 - level);  // bits of the prefix
    const std::uint64_t prefix = above == 0 ? 0 : keys_[lo] >> (64 - above);
    const std::uint64_t low_bits = 0x5555555555555555ULL;
    const std::uint64_t mask = above == 0 ? 0 : low_bits >> (64 - above);
    const std::uint64_t high = (prefix >> 1) & mask, low = prefix & mask;
    const bool swapped = (std::popcount(~(high ^ low) & mask) & 1) != 0;
    const bool inverted = (std::popcount(high & low) & 1) != 0;
    if ((bit & 1) != 0) return {middle, swapped, inverted};
    const bool later_half = ((keys_[lo] >> (bit + 1)) & 1) != 0;  // digits 2, 3 run downwards
    return {middle, !swapped, later_half != inverted};
  }

  Index two(Index a) {
    const Index g = 2 * a;
    ghost(g, a, a + 1);
    ghost(g + 1, a + 1, a);
    link(half_edge(g, 0), half_edge(g + 1, 0));
    link(half_edge(g, 1), half_edge(g + 1, 2));
    link(half_edge(g, 2), half_edge(g + 1, 1));
    return g;
  }

  Index three(Index first) {
    const Index g = 2 * first;
    Index a = first, b = first + 1, c = first + 2;
    const int turn = orientation(xy_[a], xy_[b], xy_[c]);
    if (turn == 0) return collinear_three(first);
    if (turn < 0) std::swap(b, c);
    t_[g + 3].v = {a, b, c};
    ghost(g, a, b);
    ghost(g + 1, b, c);
    ghost(g + 2, c, a);
    for (Index k = 0; k < 3; ++k) {
      link(half_edge(g + k, 0), half_edge(g + 3, k));
      link(half_edge(g + k, 2), half_edge(g + next_side(k), 1));
    }
    return g;
  }

  Index collinear_three(Index first) {
    const Index g = 2 * first;
    std::array<Index, 3> p{first, first + 1, first + 2};
    std::sort(p.begin(), p.end(), [&](Index i, Index j) { return lexicographic_less(xy_[i], xy_[j]); });
    ghost(g, p[0], p[1]);
    ghost(g + 1, p[1], p[2]);
    ghost(g + 2, p[2], p[1]);
    ghost(g + 3, p[1], p[0]);
    link(half_edge(g, 0), half_edge(g + 3, 0));
    link(half_edge(g + 1, 0), half_edge(g + 2, 0));
    for (Index k = 0; k < 4; ++k) link(half_edge(g + k, 2), half_edge(g + (k + 1) % 4, 1));
    return g;
  }

  // The ghost of the hull edge that starts at the extreme node: the last (or first) in lexicographic order of (x, y),
  // or of (y, −x) for a cut across y, which is the same after a quarter turn.
  Index extreme(Index g, bool across_y, bool last) const {
    const auto before = [&](const Point2& p, const Point2& q) {
      if (across_y) return p.y < q.y || (p.y == q.y && p.x > q.x);
      return lexicographic_less(p, q);
    };
    Index best = g;
    for (Index i = next_ghost(g); i != g; i = next_ghost(i)) {
      const Point2 &p = xy_[t_[i].v[1]], &q = xy_[t_[best].v[1]];
      if (last ? before(q, p) : before(p, q)) best = i;
    }
    return best;
  }

  // Guibas, Stolfi 1985, on ghosts. `left` lies left of (or below) `right`. Between the halves the ghosts of the facing
  // hull chains become the triangles of the seam: a ghost (c, l, none) gets r as its third node, and nothing moves.
  Index merge(const Part& left, const Part& right, bool across_y, Index slot) {
    const bool has_left = left.ghost != no_index, has_right = right.ghost != no_index;
    Index gl = no_index, gr = no_index;  // ghosts of the hull edge that starts at l, and of the one that ends at r
    Index l = left.node, r = right.node;
    if (has_left) {
      gl = extreme(left.ghost, across_y, true);
      l = t_[gl].v[1];
    }
    if (has_right) {
      gr = previous_ghost(extreme(right.ghost, across_y, false));
      r = t_[gr].v[0];
    }
    lower_tangent(gl, gr, l, r);

    const Index bottom = slot, top = slot + 1;
    ghost(bottom, l, r);
    if (has_left) link(half_edge(bottom, 1), t_[gl].n[1]);
    if (has_right) link(half_edge(bottom, 2), t_[gr].n[2]);
    HalfEdge base = half_edge(bottom, 0);

    for (;;) {
      const Index cl = has_left ? left_candidate(gl, l, r) : no_index;
      const Index cr = has_right ? right_candidate(gr, l, r) : no_index;
      if (cl == no_index && cr == no_index) break;
      if (cl == no_index || (cr != no_index && inside_circle(xy_[l], xy_[r], xy_[cl], xy_[cr]))) {
        const Index following = previous_ghost(gr);
        t_[gr].v[2] = l;  // (r, cr, l)
        link(half_edge(gr, 2), base);
        base = half_edge(gr, 1);
        r = cr;
        gr = following;
      } else {
        const Index following = next_ghost(gl);
        t_[gl].v[2] = r;  // (cl, l, r)
        link(half_edge(gl, 1), base);
        base = half_edge(gl, 2);
        l = cl;
        gl = following;
      }
    }

    ghost(top, r, l);
    link(half_edge(top, 0), base);
    link(half_edge(top, 1), has_right ? half_edge(gr, 2) : half_edge(bottom, 2));
    link(half_edge(top, 2), has_left ? half_edge(gl, 1) : half_edge(bottom, 1));
    return bottom;
  }

  void lower_tangent(Index& gl, Index& gr, Index& l, Index& r) const {
    for (;;) {
      if (gr != no_index) {
        const Index g = next_ghost(gr);
        const Index y = t_[g].v[0];
        if (orientation(xy_[l], xy_[r], xy_[y]) < 0) {
          gr = g;
          r = y;
          continue;
        }
      }
      if (gl != no_index) {
        const Index g = previous_ghost(gl);
        const Index x = t_[g].v[1];
        if (orientation(xy_[l], xy_[r], xy_[x]) < 0) {
          gl = g;
          l = x;
          continue;
        }
      }
      return;
    }
  }

  // The node that would join l and r from the left half, after deleting the edges from l that the circle rule forbids;
  // no_index if none lies above the base. A deleted edge flips a triangle over to the outside: two ghosts again.
  Index left_candidate(Index gl, Index l, Index r) {
    Index c = t_[gl].v[0];
    if (orientation(xy_[l], xy_[r], xy_[c]) <= 0) return no_index;
    for (;;) {
      const HalfEdge h = t_[gl].n[0];  // l→c
      const Index t = triangle_of(h), k = side_of(h);
      const Index d = t_[t].v[previous_side(k)];
      if (d == no_index || !inside_circle(xy_[l], xy_[r], xy_[c], xy_[d])) return c;
      const HalfEdge beyond_cd = t_[t].n[next_side(k)], beyond_dl = t_[t].n[previous_side(k)];
      const HalfEdge following = t_[gl].n[2];
      ghost(gl, l, d);
      ghost(t, d, c);
      link(half_edge(gl, 0), beyond_dl);
      link(half_edge(t, 0), beyond_cd);
      link(half_edge(t, 1), half_edge(gl, 2));
      link(half_edge(t, 2), following);
      c = d;
    }
  }

  Index right_candidate(Index gr, Index l, Index r) {
    Index c = t_[gr].v[1];
    if (orientation(xy_[l], xy_[r], xy_[c]) <= 0) return no_index;
    for (;;) {
      const HalfEdge h = t_[gr].n[0];  // c→r
      const Index t = triangle_of(h), k = side_of(h);
      const Index d = t_[t].v[previous_side(k)];
      if (d == no_index || !inside_circle(xy_[l], xy_[r], xy_[c], xy_[d])) return c;
      const HalfEdge beyond_rd = t_[t].n[next_side(k)], beyond_dc = t_[t].n[previous_side(k)];
      const HalfEdge preceding = t_[gr].n[1];
      ghost(gr, d, r);
      ghost(t, c, d);
      link(half_edge(gr, 0), beyond_rd);
      link(half_edge(t, 0), beyond_dc);
      link(half_edge(t, 2), half_edge(gr, 1));
      link(half_edge(t, 1), preceding);
      c = d;
    }
  }

  std::span<const Point2> xy_;
  const Array<std::uint64_t>& keys_;
  Triangle* t_;
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
  const Index ghost = Builder(xy, keys, result.triangles).build(0, n);
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
