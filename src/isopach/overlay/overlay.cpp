#include "isopach/overlay/overlay.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/first_corner.hpp"
#include "isopach/geom/predicates.hpp"
#include "isopach/overlay/flood.hpp"

namespace isopach {

namespace {

using flooding::is_negative, flooding::next3, flooding::turn;

constexpr std::size_t block = 1 << 12;
constexpr Index hub_degree = 32;  // a node with more triangles is a hub

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

}  // namespace

Overlay::Scratch::Scratch() : buffers_(std::make_unique<Buffers>()) {}
Overlay::Scratch::~Scratch() = default;

Overlay::Overlay(const OverlayMesh& m1, const OverlayMesh& m2, const Context& context)
    : exchanged_(comes_second(m1, m2)), outer_(exchanged_ ? m2 : m1), inner_(exchanged_ ? m1 : m2) {
  context.check();
  if (inner_.t.real == 0) {  // nothing covers an area
    start_.assign(outer_.xy.size(), no_index);
    return;
  }
  start_ = shifted_locations(outer_, inner_, true);
  find_hubs();
  find_late(context);
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
void Overlay::find_late(const Context& context) {
  std::vector<Start> round = at_the_rim(context);
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
      for (std::size_t i = first + begin; i < first + end; ++i) {
        context.check();
        spread(late_[i], scratch, next);
      }
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

std::vector<Overlay::Start> Overlay::at_the_rim(const Context& context) const {
  return gather_blocks<std::vector<Start>>(outer_.t.real, block, [&](std::size_t begin, std::size_t end) {
    context.check();
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
