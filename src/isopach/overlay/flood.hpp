// The cells of one outer triangle of an overlay: a flood of the inner triangles that meet it, and the signs it decides
// by. For overlay.cpp alone.
#pragma once
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "isopach/geom/predicates.hpp"
#include "isopach/overlay/overlay.hpp"

namespace isopach {

namespace flooding {

inline unsigned is_negative(double x) { return static_cast<unsigned>(std::bit_cast<std::uint64_t>(x) >> 63); }

// Twice the area of a, b, q whose filter has failed: its sign is right, also where the value is 0 (then it is that of
// the perturbation). `turned`: ab is an edge of the inner mesh and q a node of the outer one, not the other way round.
[[gnu::noinline]] inline double turn_exactly(const Point2& a, const Point2& b, const Point2& q, bool turned) {
  const bool at_end = a == q || b == q, along_axis = (a.x == q.x && b.x == q.x) || (a.y == q.y && b.y == q.y);
  const int sign = at_end || along_axis ? 0 : exact::orientation(a, b, q);
  if (sign != 0) return std::copysign(exact::twice_area(a, b, q), sign);
  // det(a, b, q + δ) = det(a, b, q) + (b − a) × δ with δ = (ε, ε²); shifting ab instead takes −δ.
  const bool positive = b.y != a.y ? b.y < a.y : b.x > a.x;
  return positive != turned ? 0.0 : -0.0;
}

inline bool passes(double value, double left, double right) {
  return std::fabs(value) > orientation_filter * (std::fabs(left) + std::fabs(right)) + underflow_guard;
}

inline double turn(const Point2& a, const Point2& b, const Point2& q, bool turned) {
  const double left = (a.x - q.x) * (b.y - q.y), right = (a.y - q.y) * (b.x - q.x), value = left - right;
  return passes(value, left, right) ? value : turn_exactly(a, b, q, turned);
}

constexpr unsigned next3(unsigned i) { return i == 2 ? 0 : i + 1; }
// Bit i of the result: bit i + 1, round the three.
constexpr unsigned rotated(unsigned mask) { return (mask >> 1) | ((mask & 1) << 2); }

// An inner node q seen from the outer triangle t0 t1 t2.
struct NodeView {
  Index id;
  unsigned out;       // bit i: q lies right of side i, that is outside
  double x[3], y[3];  // t_i − q
  double side[3];     // orientation of t_i, t_i+1, q
};

// An inner edge seen from the outer triangle.
struct EdgeView {
  bool meets;        // it has a part inside
  unsigned right;    // bit i: t_i lies right of it
  unsigned crossed;  // bit i: it crosses side i
  double side[3];    // its orientation with t_i
};

struct Seen {
  Index inner;    // the triangle
  Index entry;    // its side that is known already
  NodeView a, b;  // nodes of that side
  EdgeView edge;
};

// The inner triangles met so far, in order; each once.
class Found {
 public:
  void clear() {
    if (count_ > few) table_.clear();
    count_ = 0;
  }
  [[nodiscard]] bool add(Index t) {
    if (count_ < few) {
      for (std::size_t i = 0; i < count_; ++i)
        if (first_[i] == t) return false;
      first_[count_++] = t;
      return true;
    }
    if (count_ == few) {
      table_.assign(128, no_index);
      for (const Index old : first_) place(old);
    }
    if (!place(t)) return false;
    if (2 * ++count_ > table_.size()) grow();
    return true;
  }

 private:
  static constexpr std::size_t few = 24;
  bool place(Index t) {
    const std::size_t mask = table_.size() - 1;
    std::size_t i = (static_cast<std::uint64_t>(t) * 0x9E3779B97F4A7C15u >> 32) & mask;
    for (; table_[i] != no_index; i = (i + 1) & mask)
      if (table_[i] == t) return false;
    table_[i] = t;
    return true;
  }
  void grow() {
    std::vector<Index> old(2 * table_.size(), no_index);
    old.swap(table_);
    for (const Index t : old)
      if (t != no_index) place(t);
  }
  std::size_t count_ = 0;
  std::array<Index, few> first_{};
  std::vector<Index> table_;
};

}  // namespace flooding

struct Overlay::Scratch::Buffers {
  flooding::Found found;
  Array<flooding::Seen> open;  // a stack
  Array<OverlayCell> cells;
};

// All cells of one outer triangle.
class Overlay::Flood {
  using NodeView = flooding::NodeView;
  using EdgeView = flooding::EdgeView;
  using Seen = flooding::Seen;

 public:
  Flood(const Overlay& overlay, Scratch& scratch, Index outer)
      : o_(overlay.outer_), i_(overlay.inner_), exchanged_(overlay.exchanged_), b_(*scratch.buffers_), t_(outer) {
    const auto& v = o_.t.triangles[outer].v;
    for (unsigned k = 0; k < 3; ++k) {
      v_[k] = v[k];
      p_[k] = o_.xy[v[k]];
      z_[k] = o_.z[v[k]];
      other_z_[k] = o_.other_z[v[k]];
      x_[k] = p_[k].x - p_[0].x;
      y_[k] = p_[k].y - p_[0].y;
    }
    for (unsigned k = 0; k < 3; ++k)
      dx_[k] = p_[flooding::next3(k)].x - p_[k].x, dy_[k] = p_[flooding::next3(k)].y - p_[k].y;
  }

  void run(const Entry& entry_of_t) {
    const Index start = entry_of_t.inner;
    past_corners_ = !entry_of_t.covers;
    b_.found.clear();
    b_.cells.clear();
    (void)b_.found.add(start);
    for (unsigned k = 0; k < 3; ++k) node_[k] = view(i_.t.triangles[start].v[k]);
    for (unsigned k = 0; k < 3; ++k) edge_[k] = view(node_[k], node_[flooding::next3(k)]);
    first_ = 0;
    visit(start, 3);
    while (!b_.open.empty()) {
      const Seen& seen = b_.open.back();
      const Index inner = seen.inner, entry = seen.entry;
      node_[0] = seen.a;
      node_[1] = seen.b;
      edge_[0] = seen.edge;
      b_.open.pop_back();
      node_[2] = view(i_.t.triangles[inner].v[previous_side(entry)]);
      edge_[1] = view(node_[1], node_[2]);
      edge_[2] = view(node_[2], node_[0]);
      first_ = entry;
      visit(inner, 0);
    }
  }

 private:
  [[nodiscard]] NodeView view(Index id) const {
    NodeView n;
    n.id = id;
    n.out = 0;
    const Point2& q = i_.xy[id];
    for (unsigned k = 0; k < 3; ++k) n.x[k] = p_[k].x - q.x, n.y[k] = p_[k].y - q.y;
    for (unsigned k = 0; k < 3; ++k) {
      const unsigned m = flooding::next3(k);
      const double left = n.x[k] * n.y[m], right = n.y[k] * n.x[m];
      n.side[k] = left - right;
      if (!flooding::passes(n.side[k], left, right)) [[unlikely]]
        n.side[k] = flooding::turn_exactly(p_[k], p_[m], q, false);
      n.out |= flooding::is_negative(n.side[k]) << k;
    }
    return n;
  }

  // An edge with both ends beyond one side does not meet the triangle. Its corners then count as left of the edge: a
  // corner in the inner triangle is so, and another one is right of an edge that does meet.
  [[nodiscard]] EdgeView view(const NodeView& a, const NodeView& b) const {
    EdgeView e{};
    if ((a.out & b.out) != 0) return e;
    for (unsigned k = 0; k < 3; ++k) {
      const double left = a.x[k] * b.y[k], right = a.y[k] * b.x[k];
      e.side[k] = left - right;
      if (!flooding::passes(e.side[k], left, right)) [[unlikely]]
        e.side[k] = flooding::turn_exactly(i_.xy[a.id], i_.xy[b.id], p_[k], true);
      e.right |= flooding::is_negative(e.side[k]) << k;
    }
    e.crossed = (a.out ^ b.out) & (e.right ^ flooding::rotated(e.right));
    e.meets = e.crossed != 0 || a.out == 0 || b.out == 0;
    return e;
  }

  // Whether an edge that meets the triangle does so at one of its corners alone, before the shift: an end lies on the
  // corner, and the other beyond a side at it. Of an edge along such a side both ends lie on the same side of it.
  static bool ends_at_corner(const NodeView& a, const NodeView& b) {
    for (unsigned k = 0; k < 3; ++k) {
      const unsigned sides_at_it = 1u << k | 1u << (k == 0 ? 2 : k - 1);
      if (a.x[k] == 0 && a.y[k] == 0) return (b.out & sides_at_it) != 0;
      if (b.x[k] == 0 && b.y[k] == 0) return (a.out & sides_at_it) != 0;
    }
    return false;
  }

  static EdgeView reversed(const EdgeView& e) {
    return {e.meets, ~e.right & 7u, e.crossed, {-e.side[0], -e.side[1], -e.side[2]}};
  }

  // node_ and edge_ are those of the triangle, from its side first_ on; edge `known` has been crossed.
  void visit(Index inner, unsigned known) {
    at_ = inner;
    add_cell(inner);
    const auto& twins = i_.t.triangles[inner].n;
    Index side = first_;
    for (unsigned k = 0; k < 3; ++k, side = next_side(side)) {
      if (k == known || !edge_[k].meets) continue;
      if (!past_corners_ && ends_at_corner(node_[k], node_[flooding::next3(k)])) continue;
      const Index next = triangle_of(twins[side]);
      if (i_.t.is_ghost(next) || !b_.found.add(next)) continue;
      Seen& seen = b_.open.emplace_back();
      seen.inner = next;
      seen.entry = side_of(twins[side]);
      seen.a = node_[flooding::next3(k)];
      seen.b = node_[k];
      seen.edge = reversed(edge_[k]);
    }
  }

  void add_cell(Index inner) {
    // Fields not set here are set corner by corner.
    b_.cells.resize(b_.cells.size() + 1);
    c_ = &b_.cells.back();
    c_->t1 = exchanged_ ? inner : t_;
    c_->t2 = exchanged_ ? t_ : inner;
    c_->origin = p_[0];
    c_->corners = 0;
    c_->crossings = 0;
    zo_ = exchanged_ ? c_->z2.data() : c_->z1.data();
    zi_ = exchanged_ ? c_->z1.data() : c_->z2.data();
    const unsigned in = ~(edge_[0].right | edge_[1].right | edge_[2].right) & 7u;  // corners in the inner triangle
    const unsigned crossed = edge_[0].crossed | edge_[1].crossed | edge_[2].crossed;
    c_->sides = crossed | in | flooding::rotated(in);
    if (crossed == 0) {
      for (unsigned k = 0; k < 3; ++k) in == 7 ? put_outer(k) : put_inner(k);
      return;
    }
    // Round the outer triangle; where it leaves the inner one, along the inner one's sides to where it comes in again.
    unsigned left_by = 3, first_entered_by = 3;
    for (unsigned i = 0; i < 3; ++i) {
      if ((in >> i & 1) != 0) put_outer(i);
      if ((crossed >> i & 1) == 0) continue;
      unsigned entered_by = 3, leaves_by = 3;
      for (unsigned j = 0; j < 3; ++j)
        if ((edge_[j].crossed >> i & 1) != 0) ((edge_[j].right >> i & 1) != 0 ? entered_by : leaves_by) = j;
      if (entered_by != 3) {
        if (left_by != 3)
          follow(left_by, entered_by);
        else
          first_entered_by = entered_by;
        put_crossing(i, entered_by);
        left_by = 3;
      }
      if (leaves_by != 3) {
        put_crossing(i, leaves_by);
        left_by = leaves_by;
      }
    }
    if (left_by != 3) follow(left_by, first_entered_by);
  }

  void follow(unsigned from, unsigned to) {
    while (from != to) {
      from = flooding::next3(from);
      put_inner(from);
    }
  }

  void put(OverlayCorner of, double x, double y, double zo, double zi) {
    const unsigned k = c_->corners++;
    c_->of[k] = of;
    c_->x[k] = x;
    c_->y[k] = y;
    zo_[k] = zo;
    zi_[k] = zi;
  }
  void put_outer(unsigned k) { put({v_[k], no_index}, x_[k], y_[k], z_[k], other_z_[k]); }
  void put_inner(unsigned k) {
    const NodeView& n = node_[k];
    put({no_index, n.id}, -n.x[0], -n.y[0], i_.other_z[n.id], i_.z[n.id]);
  }
  void put_crossing(unsigned i, unsigned j) {
    const NodeView &a = node_[j], &b = node_[flooding::next3(j)];
    const unsigned m = flooding::next3(i);
    double r = share(edge_[j].side[i], edge_[j].side[m]), u = share(a.side[i], b.side[i]);
    if (nearly_parallel(i, a, b)) [[unlikely]] {
      const Point2 &p = p_[i], &q = p_[m], &at_a = i_.xy[a.id], &at_b = i_.xy[b.id];
      r = share(exact::twice_area(at_a, at_b, p), exact::twice_area(at_a, at_b, q));
      u = share(exact::twice_area(p, q, at_a), exact::twice_area(p, q, at_b));
    }
    const double za = i_.z[a.id], zb = i_.z[b.id];
    const Index side = (first_ + j) % 3;
    c_->crossings |= static_cast<std::uint8_t>(1u << c_->corners);
    put({i, half_edge(at_, side)}, x_[i] + r * dx_[i], y_[i] + r * dy_[i], z_[i] + r * (z_[m] - z_[i]),
        za + u * (zb - za));
  }
  // Whether the areas at a crossing are so small beside the edges that rounding shows in their shares. The cells round
  // it would then not agree where it is, which on lattices that nearly share lines costs whole cells.
  [[nodiscard]] bool nearly_parallel(unsigned i, const NodeView& a, const NodeView& b) const {
    constexpr double sine = 1e-3;
    const double twice = std::fabs(a.side[i]) + std::fabs(b.side[i]), x = a.x[i] - b.x[i], y = a.y[i] - b.y[i];
    return twice * twice < sine * sine * (dx_[i] * dx_[i] + dy_[i] * dy_[i]) * (x * x + y * y);
  }
  // Of an edge up to its crossing, from the areas on both sides, which have opposite signs. Both 0: less than the
  // smallest double apart.
  static double share(double before, double after) {
    const double sum = std::fabs(before) + std::fabs(after);
    return sum > 0 ? std::fabs(before) / sum : 0.5;
  }

  const OverlayMesh &o_, &i_;
  bool exchanged_;
  Scratch::Buffers& b_;
  Index t_;
  bool past_corners_ = true;  // also across edges that touch the triangle at a corner alone
  Index at_ = 0, first_ = 0;  // the inner triangle, and its side that node_ and edge_ begin with
  Index v_[3];
  Point2 p_[3];
  double z_[3], other_z_[3], x_[3], y_[3], dx_[3], dy_[3];
  NodeView node_[3];
  EdgeView edge_[3];
  OverlayCell* c_ = nullptr;
  double *zo_ = nullptr, *zi_ = nullptr;
};

}  // namespace isopach
