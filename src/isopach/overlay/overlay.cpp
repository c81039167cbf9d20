#include "isopach/overlay/overlay.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/first_corner.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

constexpr std::size_t block = 1 << 12;
constexpr Index hub_degree = 32;  // a node with more triangles is a hub

unsigned is_negative(double x) { return static_cast<unsigned>(std::bit_cast<std::uint64_t>(x) >> 63); }

// Twice the area of a, b, q whose filter has failed: its sign is right, also where the value is 0 (then it is that of
// the perturbation). `turned`: ab is an edge of the inner mesh and q a node of the outer one, not the other way round.
[[gnu::noinline]] double turn_exactly(const Point2& a, const Point2& b, const Point2& q, bool turned) {
  const bool at_end = a == q || b == q, along_axis = (a.x == q.x && b.x == q.x) || (a.y == q.y && b.y == q.y);
  const int sign = at_end || along_axis ? 0 : exact::orientation(a, b, q);
  if (sign != 0) return std::copysign(exact::twice_area(a, b, q), sign);
  // det(a, b, q + δ) = det(a, b, q) + (b − a) × δ with δ = (ε, ε²); shifting ab instead takes −δ.
  const bool positive = b.y != a.y ? b.y < a.y : b.x > a.x;
  return positive != turned ? 0.0 : -0.0;
}

bool passes(double value, double left, double right) {
  return std::fabs(value) > orientation_filter * (std::fabs(left) + std::fabs(right)) + underflow_guard;
}

double turn(const Point2& a, const Point2& b, const Point2& q, bool turned) {
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

}  // namespace

struct Overlay::Scratch::Buffers {
  Found found;
  Array<Seen> open;  // a stack
  Array<OverlayCell> cells;
};

Overlay::Scratch::Scratch() : buffers_(std::make_unique<Buffers>()) {}
Overlay::Scratch::~Scratch() = default;

// All cells of one outer triangle.
class Overlay::Flood {
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
    for (unsigned k = 0; k < 3; ++k) dx_[k] = p_[next3(k)].x - p_[k].x, dy_[k] = p_[next3(k)].y - p_[k].y;
  }

  void run(const Entry& entry_of_t) {
    const Index start = entry_of_t.inner;
    past_corners_ = !entry_of_t.covers;
    b_.found.clear();
    b_.cells.clear();
    (void)b_.found.add(start);
    for (unsigned k = 0; k < 3; ++k) node_[k] = view(i_.t.triangles[start].v[k]);
    for (unsigned k = 0; k < 3; ++k) edge_[k] = view(node_[k], node_[next3(k)]);
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
      const unsigned m = next3(k);
      const double left = n.x[k] * n.y[m], right = n.y[k] * n.x[m];
      n.side[k] = left - right;
      if (!passes(n.side[k], left, right)) [[unlikely]]
        n.side[k] = turn_exactly(p_[k], p_[m], q, false);
      n.out |= is_negative(n.side[k]) << k;
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
      if (!passes(e.side[k], left, right)) [[unlikely]]
        e.side[k] = turn_exactly(i_.xy[a.id], i_.xy[b.id], p_[k], true);
      e.right |= is_negative(e.side[k]) << k;
    }
    e.crossed = (a.out ^ b.out) & (e.right ^ rotated(e.right));
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
      if (!past_corners_ && ends_at_corner(node_[k], node_[next3(k)])) continue;
      const Index next = triangle_of(twins[side]);
      if (i_.t.is_ghost(next) || !b_.found.add(next)) continue;
      Seen& seen = b_.open.emplace_back();
      seen.inner = next;
      seen.entry = side_of(twins[side]);
      seen.a = node_[next3(k)];
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
    c_->sides = crossed | in | rotated(in);
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
      from = next3(from);
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
    const NodeView &a = node_[j], &b = node_[next3(j)];
    const unsigned m = next3(i);
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

namespace {

// Which mesh is the outer one: a rule that does not depend on which is first.
bool comes_second(const OverlayMesh& m1, const OverlayMesh& m2) {
  if (m1.t.real != m2.t.real) return m1.t.real < m2.t.real;
  return std::lexicographical_compare(m2.xy.begin(), m2.xy.end(), m1.xy.begin(), m1.xy.end(), lexicographic_less);
}

bool strictly_outside(Location::Kind kind) { return kind == Location::Kind::outside || kind == Location::Kind::none; }

// The triangle of `t` that q lies in, the inner mesh being shifted; no_index outside. Walks from `at`, a triangle
// that touches q.
Index shifted_locate(const Point2& q, const Triangulation& t, std::span<const Point2> xy, Index at, bool inner) {
  while (!t.is_ghost(at)) {
    const Triangle& s = t.triangles[at];
    unsigned k = 0;
    while (k < 3 && is_negative(turn(xy[s.v[k]], xy[s.v[next3(k)]], q, inner)) == 0) ++k;
    if (k == 3) return at;
    at = triangle_of(s.n[k]);
  }
  return no_index;
}

// A real triangle at each node.
Array<Index> triangle_of_nodes(const Triangulation& t) {
  Array<Index> of(t.nodes);
  for (Index i = 0; i < t.real; ++i)
    for (const Index v : t.triangles[i].v) of[v] = i;
  return of;
}

// Per node of `m` the triangle of `other` that it lies in, shifted; no_index outside. `inner`: `other` is the inner
// one.
Array<Index> shifted_locations(const OverlayMesh& m, const OverlayMesh& other, bool inner) {
  Array<Index> found(m.xy.size());
  const bool any_on_node =
      std::find(m.in_other.kind.begin(), m.in_other.kind.end(), Location::Kind::node) != m.in_other.kind.end();
  const Array<Index> at_node = any_on_node ? triangle_of_nodes(other.t) : Array<Index>{};
  for_each_index(found.size(), [&](std::size_t i) {
    const Location at = m.in_other[i];
    if (at.kind == Location::Kind::triangle) {
      found[i] = at.id;
      return;
    }
    found[i] = strictly_outside(at.kind)
                   ? no_index
                   : shifted_locate(m.xy[i], other.t, other.xy,
                                    at.kind == Location::Kind::node ? at_node[at.id] : triangle_of(at.id), inner);
  });
  return found;
}

// Whether the ray from the tip through p is in the angle from a (included) to b (not), which is less than 180°.
bool is_in_angle(const Point2& tip, const Point2& a, const Point2& b, const Point2& p) {
  const int after = orientation(tip, a, p);
  if (after == 0) return (a.x - tip.x) * (p.x - tip.x) >= 0 && (a.y - tip.y) * (p.y - tip.y) >= 0;
  return after > 0 && orientation(tip, p, b) > 0;
}

// Ghosts whose hull edge reaches into a box.
std::vector<Index> ghosts_near(const Triangulation& t, std::span<const Point2> xy, const Box2& box) {
  std::vector<Index> near;
  for (Index g = t.real; g < t.triangles.size(); ++g) {
    Box2 edge;
    edge.add(xy[t.triangles[g].v[0]]);
    edge.add(xy[t.triangles[g].v[1]]);
    if (edge.min.x <= box.max.x && box.min.x <= edge.max.x && edge.min.y <= box.max.y && box.min.y <= edge.max.y)
      near.push_back(g);
  }
  return near;
}

Box2 box_of(std::span<const Point2> points) {
  Box2 box;
  for (const Point2& p : points) box.add(p);
  return box;
}

}  // namespace

Overlay::Overlay(const OverlayMesh& m1, const OverlayMesh& m2, const Context& context)
    : exchanged_(comes_second(m1, m2)), outer_(exchanged_ ? m2 : m1), inner_(exchanged_ ? m1 : m2) {
  context.check();
  if (inner_.t.real == 0) {  // nothing covers an area
    start_.assign(outer_.xy.size(), no_index);
    return;
  }
  start_ = shifted_locations(outer_, inner_, true);
  find_hubs();
  find_late();
}

void Overlay::find_hubs() {
  const auto& kind = outer_.in_other.kind;
  if (std::find(kind.begin(), kind.end(), Location::Kind::node) == kind.end()) return;
  degree_.resize(inner_.t.nodes);
  std::fill(degree_.begin(), degree_.end(), Index{0});
  for (Index t = 0; t < inner_.t.real; ++t)
    for (const Index v : inner_.t.triangles[t].v) ++degree_[v];
  bool any = false;
  for (std::size_t i = 0; i < kind.size() && !any; ++i)
    any = kind[i] == Location::Kind::node && degree_[outer_.in_other.id[i]] > hub_degree;
  if (any)
    at_node_ = triangle_of_nodes(inner_.t);
  else
    degree_ = {};
}

// Round the inner node on outer node v of t, its k-th corner: the first triangle whose corner there overlaps t's.
Index Overlay::first_in_corner(Index t, unsigned k) const {
  const auto& v = outer_.t.triangles[t].v;
  const Index node = outer_.in_other.id[v[k]];
  const Point2 &tip = outer_.xy[v[k]], &from = outer_.xy[v[next3(k)]], &to = outer_.xy[v[next3(next3(k))]];
  const auto& triangles = inner_.t.triangles;
  const Index s = at_node_[node];
  Index side = 0;
  while (triangles[s].v[side] != node) ++side;
  const HalfEdge first = half_edge(s, side);
  HalfEdge h = first;
  do {
    const Triangle& inner = triangles[triangle_of(h)];
    if (!inner_.t.is_ghost(triangle_of(h))) {
      const Point2 &a = inner_.xy[inner.v[next_side(side_of(h))]], &b = inner_.xy[inner.v[previous_side(side_of(h))]];
      // Two angles overlap if the first leg of one is in the other.
      if (is_in_angle(tip, from, to, a) || is_in_angle(tip, a, b, from)) return triangle_of(h);
    }
    h = inner_.t.next_leaving(h);
  } while (h != first);
  return no_index;
}

// Of the two inner triangles at an edge that the k-th corner of t lies on, one whose side of it t's corner reaches
// into.
Index Overlay::beside_edge(Index t, unsigned k, HalfEdge edge) const {
  const auto& v = outer_.t.triangles[t].v;
  for (const HalfEdge h : {edge, inner_.t.twin(edge)}) {
    if (inner_.t.is_ghost(triangle_of(h))) continue;
    const Point2 &a = inner_.xy[inner_.t.origin(h)], &b = inner_.xy[inner_.t.target(h)];
    if (orientation(a, b, outer_.xy[v[next3(k)]]) > 0 || orientation(a, b, outer_.xy[v[next3(next3(k))]]) > 0)
      return triangle_of(h);
  }
  return no_index;
}

// Where both meshes have a hub at one place, every triangle of one touches every one of the other there: as many cells
// without area as pairs. Then the flood starts in a triangle that is known to cover a part of t, and leaves out edges
// that end at a corner of t: those across which it goes on still connect all parts of t that have an area.
Overlay::Entry Overlay::entry(std::size_t item) const {
  const Index t = outer_of(item);
  return entry(t, item < outer_.t.real ? start_of(t) : late_[item - outer_.t.real].inner);
}

Overlay::Entry Overlay::entry(Index t, Index start) const {
  if (degree_.empty() || start == no_index) return {start, false};
  unsigned least = 3;
  bool hub = false;
  for (unsigned k = 0; k < 3; ++k) {
    const Location at = outer_.in_other[outer_.t.triangles[t].v[k]];
    if (at.kind != Location::Kind::node) continue;
    hub = hub || degree_[at.id] > hub_degree;
    if (least == 3 || degree_[at.id] < degree_[outer_.in_other.id[outer_.t.triangles[t].v[least]]]) least = k;
  }
  if (!hub) return {start, false};
  for (unsigned k = 0; k < 3; ++k)
    if (const Location at = outer_.in_other[outer_.t.triangles[t].v[k]]; at.kind == Location::Kind::triangle)
      return {at.id, true};
    else if (at.kind == Location::Kind::edge)
      return {beside_edge(t, k, at.id), true};
  return {first_in_corner(t, least), true};
}

double Overlay::bound_of_difference() const {
  if (outer_.z.empty() || inner_.z.empty()) return 0;
  const auto [low, high] = std::minmax_element(outer_.z.begin(), outer_.z.end());
  const auto [low_inner, high_inner] = std::minmax_element(inner_.z.begin(), inner_.z.end());
  return std::max(*high - *low_inner, *high_inner - *low);
}

double Overlay::estimated_cells(const Context& context) const {
  constexpr std::size_t most_items = 1024, enough_cells = 2'000'000;
  constexpr double golden = 0.6180339887498949;  // its multiples, less whole numbers, lie evenly however many there are
  const std::size_t n = items();
  Scratch scratch;
  std::size_t counted = 0, cells_of_them = 0;
  for (; counted < std::min(n, most_items) && cells_of_them < enough_cells; ++counted) {
    context.check();
    const double place = golden * static_cast<double>(counted);
    const auto item = static_cast<std::size_t>((place - std::floor(place)) * static_cast<double>(n));
    cells_of_them += cells(n <= most_items ? counted : item, scratch).size();
  }
  if (counted == 0) return 0;
  return static_cast<double>(cells_of_them) / static_cast<double>(counted) * static_cast<double>(n);
}

Box2 Overlay::box() const {
  Box2 box = box_of(outer_.xy);
  box.add(box_of(inner_.xy));
  return box;
}

std::array<Point2, 2> Overlay::first_side(std::size_t item) const {
  const std::array<Index, 3> v = from_first_corner(outer_.t.triangles[outer_of(item)].v);
  return {outer_.xy[v[0]], outer_.xy[v[1]]};
}

bool Overlay::has_node_inside(Index t) const { return start_of(t) != no_index; }

Index Overlay::start_of(Index t) const {
  for (const Index v : outer_.t.triangles[t].v)
    if (start_[v] != no_index) return start_[v];
  return no_index;
}

// Outer triangles without a node inside are reached from their neighbours, round by round: the cells hang together,
// because both hulls are convex.
void Overlay::find_late() {
  std::vector<Start> round = at_the_rim();
  if (round.empty() && std::all_of(start_.begin(), start_.end(), [](Index s) { return s == no_index; }))
    round = without_nodes_inside();
  if (round.empty()) return;
  Array<unsigned char> done(outer_.t.real);
  std::fill(done.begin(), done.end(), static_cast<unsigned char>(0));
  while (!round.empty()) {
    const std::size_t first = late_.size();
    for (const Start& s : round)
      if (done[s.outer] == 0) done[s.outer] = 1, late_.push_back(s);
    round = gather_blocks<std::vector<Start>>(late_.size() - first, 64, [&](std::size_t begin, std::size_t end) {
      std::vector<Start> next;
      Scratch scratch;
      for (std::size_t i = first + begin; i < first + end; ++i) spread(late_[i], scratch, next);
      return next;
    });
  }
}

// Where a triangle's cells touch a side behind which a triangle without a node inside lies.
void Overlay::spread(const Start& from, Scratch& scratch, std::vector<Start>& next) const {
  // A triangle that the other mesh only touches leads on through its cells without area.
  const Entry covered = entry(from.outer, from.inner);
  Flood(*this, scratch, from.outer).run(covered.inner == no_index ? Entry{from.inner, false} : covered);
  unsigned open = 0;
  const auto& sides = outer_.t.triangles[from.outer].n;
  for (unsigned k = 0; k < 3; ++k) {
    const Index t = triangle_of(sides[k]);
    if (!outer_.t.is_ghost(t) && !has_node_inside(t)) open |= 1u << k;
  }
  for (const OverlayCell& c : scratch.buffers_->cells)
    for (unsigned k = 0; k < 3; ++k)
      if ((open & c.sides) >> k & 1) {
        next.push_back({triangle_of(sides[k]), exchanged_ ? c.t1 : c.t2});
        open &= ~(1u << k);
      }
}

std::vector<Overlay::Start> Overlay::at_the_rim() const {
  return gather_blocks<std::vector<Start>>(outer_.t.real, block, [&](std::size_t begin, std::size_t end) {
    std::vector<Start> next;
    Scratch scratch;
    for (std::size_t i = begin; i < end; ++i) {
      const auto t = static_cast<Index>(i);
      const Triangle& triangle = outer_.t.triangles[t];
      const auto known = [&](Index v) { return start_[v] != no_index; };
      const auto inside = std::count_if(triangle.v.begin(), triangle.v.end(), known);
      if (inside != 1 && inside != 2) continue;  // with three inside no neighbour is without
      if (std::any_of(triangle.n.begin(), triangle.n.end(), [&](HalfEdge h) {
            return !outer_.t.is_ghost(triangle_of(h)) && !has_node_inside(triangle_of(h));
          }))
        spread({t, start_of(t)}, scratch, next);
    }
    return next;
  });
}

// No outer node lies in the inner hull: an inner node in the outer hull will do, or a crossing of both hulls.
std::vector<Overlay::Start> Overlay::without_nodes_inside() const {
  const Array<Index> found = shifted_locations(inner_, outer_, false);
  const auto first = std::find_if(found.begin(), found.end(), [](Index t) { return t != no_index; });
  if (first != found.end()) {
    const auto node = static_cast<Index>(first - found.begin());
    return {{*first, triangle_of_nodes(inner_.t)[node]}};
  }
  const Triangulation &o = outer_.t, &i = inner_.t;
  const std::vector<Index> of_inner = ghosts_near(i, inner_.xy, box_of(outer_.xy));
  for (const Index g : ghosts_near(o, outer_.xy, box_of(inner_.xy)))
    for (const Index h : of_inner) {
      const Point2 &a = outer_.xy[o.triangles[g].v[0]], &b = outer_.xy[o.triangles[g].v[1]],
                   &p = inner_.xy[i.triangles[h].v[0]], &q = inner_.xy[i.triangles[h].v[1]];
      if (is_negative(turn(a, b, p, false)) != is_negative(turn(a, b, q, false)) &&
          is_negative(turn(p, q, a, true)) != is_negative(turn(p, q, b, true)))
        return {{triangle_of(o.triangles[g].n[0]), triangle_of(i.triangles[h].n[0])}};
    }
  return {};
}

std::span<const OverlayCell> Overlay::cells(std::size_t item, Scratch& scratch) const {
  const Index t = outer_of(item);
  if (!outer_.kept.empty() && outer_.kept[t] == 0) return {};
  const Entry start = entry(item);
  if (start.inner == no_index) return {};
  Flood(*this, scratch, t).run(start);
  Array<OverlayCell>& cells = scratch.buffers_->cells;
  if (!inner_.kept.empty())
    cells.erase(std::remove_if(cells.begin(), cells.end(),
                               [&](const OverlayCell& c) { return inner_.kept[exchanged_ ? c.t1 : c.t2] == 0; }),
                cells.end());
  return cells;
}

}  // namespace isopach
