// The interface triangles, contour by contour.
//
// One step of a contour, from the interface edge p→q to the triangle on its left: the apex is either the node y that
// would follow if q alone were added to p's triangulation, or the node x that would follow if p alone were added to
// q's; it is the one inside the circle of the other. y is found by turning left around p through the triangles whose
// circles hold q (they are dead), x by turning right around q through those whose circles hold p. When the contour goes
// on from p→q to p→x, y is at or further left of where it was, so nobody ever turns back: every corner of every dead
// triangle is turned through once, which makes the whole linear.
//
// That is also how missing contours are found. All triangles of T at a pure node p inside the corner of a dead triangle
// are interface triangles, so the contour through them turns through that corner. A corner of a dead triangle that
// nobody turned through therefore has a contour that is still to be made, and it starts there.
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "isopach/base/parallel.hpp"
#include "isopach/base/prefetch.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/geom/predicates.hpp"
#include "isopach/overlay/seam.hpp"

namespace isopach::seam {

namespace {

// Whether the circle of triangle t holds q. That of a ghost is the open half-plane outside its hull edge with the edge.
bool holds(const Mesh& m, Index t, const Point2& q) {
  const auto at = [&](Index k) -> const Point2& { return m.xy[node_at(read_shared(m.triangles[t].v[k]))]; };
  if (t < m.real) return inside_circle(at(0), at(1), at(2), q);
  const Point2 &a = at(1), &b = at(0);
  const int side = orientation(a, b, q);
  if (side != 0) return side < 0;
  return lexicographic_less(a, q) != lexicographic_less(b, q) && !(a == q) && !(b == q);
}

// A triangle and one of its corners.
struct Corner {
  Index t, k;
};

// What turns around one node of an interface edge: left (counter-clockwise) around p, right around q. It stands in a
// dead triangle at the side that leads on, centre→rim, and remembers what it has computed of the triangle beyond, for
// the same triangle is asked again for every node of the other colour that the contour passes.
template <bool left>
class Fan {
 public:
  Corner at;      // the dead triangle, and its corner at the centre
  Index centre;   // node
  Index rim;      // the other end of the side, no_index for the infinite node
  HalfEdge side;  // that side, as the dead triangle has it: rim→centre (left) or centre→rim (right)
  Index link;     // twin of the side, or the tag of the interface triangle that leans on it

  Fan(const Mesh& m, Corner corner) : m_(&m) { stand(corner); }

  // Moves the centre, or stands at another corner of the same triangle.
  void stand(Corner corner) {
    centre = node(corner.t, corner.k);
    centre_xy_ = m_->xy[centre];
    at = corner;
    rim = node(at.t, left ? previous_side(at.k) : next_side(at.k));
    if (rim != no_index) u_ = relative(rim);
    look_beyond();
  }

  // Whether the circle of the triangle beyond holds q, a node of the other colour, at `w` from the centre.
  [[nodiscard]] bool beyond_holds(const Point2& q, const Point2& w, double w2) {
    if (beyond_ == Beyond::unseen) look_closely();
    if (beyond_ == Beyond::tagged) return false;  // a side of T: nothing beyond it concerns this contour
    if (beyond_ == Beyond::real) {
      const double vw = v_.d.x * w.y, wv = w.x * v_.d.y, wu = w.x * u_.d.y, uw = u_.d.x * w.y;
      const double det = u_.square * (vw - wv) + v_.square * (wu - uw) + w2 * cross_;
      const double permanent =
          (std::fabs(vw) + std::fabs(wv)) * u_.square + (std::fabs(wu) + std::fabs(uw)) * v_.square + cross_size_ * w2;
      // The guard grows with the lifts, as in in_circle_filtered.
      const double bound = in_circle_filter * permanent + underflow_guard * (1 + u_.square + v_.square + w2);
      if (det > bound) return !left;
      if (det < -bound) return left;
    }
    return holds(*m_, triangle_of(link), q);
  }

  // Into the triangle beyond.
  void advance() {
    const Index k = side_of(link);
    at = {triangle_of(link), left ? k : next_side(k)};
    rim = apex_;
    u_ = v_;
    look_beyond();
  }

  // To the rim, which becomes the centre.
  void step_out() { stand({at.t, left ? previous_side(at.k) : next_side(at.k)}); }

  [[nodiscard]] const Point2& xy() const { return centre_xy_; }

 private:
  enum class Beyond { tagged, unseen, real, ghostly };
  struct Relative {
    Point2 d;
    double square;
  };

  [[nodiscard]] Relative relative(Index node) const {
    const Point2& p = m_->xy[node];
    const double x = p.x - centre_xy_.x, y = p.y - centre_xy_.y;
    return {{x, y}, x * x + y * y};
  }

  [[nodiscard]] Index node(Index t, Index k) const { return node_at(read_shared(m_->triangles[t].v[k])); }

  void look_beyond() {
    side = half_edge(at.t, left ? previous_side(at.k) : at.k);
    link = read_shared(m_->triangles[at.t].n[side_of(side)]);
    beyond_ = is_tag(link) ? Beyond::tagged : Beyond::unseen;
    prefetch(&m_->triangles[triangle_of(is_tag(link) ? side : link)]);
  }

  void look_closely() {
    apex_ = node(triangle_of(link), previous_side(side_of(link)));
    if (apex_ != no_index) v_ = relative(apex_);
    if (apex_ == no_index || rim == no_index) {
      beyond_ = Beyond::ghostly;
      return;
    }
    beyond_ = Beyond::real;
    const double uv = u_.d.x * v_.d.y, vu = v_.d.x * u_.d.y;
    cross_ = uv - vu;
    cross_size_ = std::fabs(uv) + std::fabs(vu);
  }

  const Mesh* m_;
  Point2 centre_xy_{};
  Relative u_{}, v_{};  // rim and apex of the triangle beyond, from the centre
  double cross_ = 0, cross_size_ = 0;
  Index apex_ = no_index;
  Beyond beyond_ = Beyond::tagged;
};

// An interface edge as the interface triangle on one side of it knows it.
struct Reached {
  HalfEdge edge;  // 4·record + side
  bool made;      // by this contour, or found made by another
};

class Tracer {
 public:
  Tracer(Seam& s, Index& next_record, bool concurrent) : s_(s), next_record_(next_record), concurrent_(concurrent) {}
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;
  // What is left of the last records taken goes back, unless others were taken since.
  ~Tracer() { (void)claim(next_record_, free_end_, free_); }

  // Makes the contours through all pure corners of the dead triangle t of mesh 0 that nobody turned through.
  void complete(Index t) {
    for (Index k = 0; k < 3; ++k) {
      if (s_.turned(0, t, k) || !s_.is_pure(0, s_.at(0, t, k))) continue;
      start(t, k);
      found_ = true;
    }
  }
  [[nodiscard]] bool has_found() const { return found_; }

  // The triangle of mesh `c` that holds a pure node of the other mesh.
  [[nodiscard]] Index holder(int c, Index node_of_other) const {
    const Mesh &m = s_.mesh[c], &other = s_.mesh[1 - c];
    const Location where = (*other.in_other)[node_of_other];
    if (where.kind == Location::Kind::triangle) return where.id;
    if (where.kind == Location::Kind::edge) return triangle_of(where.id);
    // The nearest hull edge is seen from outside, or the one before or after it is.
    const Point2& q = other.xy[node_of_other];
    const auto size = static_cast<Index>(m.triangles.size());
    Index before = triangle_of(where.id), after = before;
    for (Index i = m.real; i <= size; ++i) {
      if (holds(m, after, q)) return after;
      if (holds(m, before, q)) return before;
      after = triangle_of(s_.twin(c, half_edge(after, 2)));
      before = triangle_of(s_.twin(c, half_edge(before, 1)));
    }
    throw std::logic_error("merge: a node outside the hull sees no edge of it");
  }

 private:
  void turn_through(int c, Index t, Index k) {
    Index& v = s_.mesh[c].triangles[t].v[k];
    write_shared(v, read_shared(v) | turned_bit);
  }

  Index new_record() {
    if (free_ == free_end_) {
      free_ = concurrent_ ? take_next(next_record_, chunk) : next_record_;
      if (!concurrent_) next_record_ += chunk;
      free_end_ = free_ + chunk;
      if (free_end_ > s_.first_proxy) throw std::logic_error("merge: more interface triangles than there can be");
    }
    return free_++;
  }

  // Puts the tag of a new triangle on the half-edge it leans on; false if one leans there already.
  bool lean(int c, HalfEdge h, Index& link, Index tag_of_new) {
    Index& word = s_.mesh[c].triangles[triangle_of(h)].n[side_of(h)];
    if (concurrent_) return claim(word, link, tag_of_new);
    word = tag_of_new;
    return true;
  }

  // From the interface edge p→q, p of colour A at corner `a` of a dead triangle that holds q, and q at corner `b` of
  // one that holds p: all interface triangles on the left, until the contour closes, ends, or meets one that is made.
  template <int A>
  Reached trace(Corner a, Corner b) {
    constexpr int B = 1 - A;
    Fan<true> p(s_.mesh[A], a);
    Fan<false> q(s_.mesh[B], b);
    Reached first{no_index, false};
    HalfEdge last = no_index;  // the side of the last triangle that leads on
    for (;;) {
      const Point2 pq{q.xy().x - p.xy().x, q.xy().y - p.xy().y}, qp{-pq.x, -pq.y};
      const double pq2 = pq.x * pq.x + pq.y * pq.y;
      // By turns, so that what the one fan needs next is on its way while the other is asked.
      for (bool p_turns = true, q_turns = true; p_turns || q_turns;) {
        p_turns = p_turns && p.beyond_holds(q.xy(), pq, pq2);
        if (p_turns) {
          p.advance();
          turn_through(A, p.at.t, p.at.k);
        }
        q_turns = q_turns && q.beyond_holds(p.xy(), qp, pq2);
        if (q_turns) {
          q.advance();
          turn_through(B, q.at.t, q.at.k);
        }
      }
      const bool ends = s_.is_same(A, p.rim, q.rim);
      const bool on_left = ends || rim_of_p_wins(p, q, s_.mesh[A], s_.mesh[B]);

      // The triangle of this step, or the one that is there already.
      Index& link = on_left ? p.link : q.link;
      Index record = no_index;
      bool made = false;
      if (!is_tag(link)) {
        record = new_record();
        s_.records[record] = {link, on_left ? q.centre : p.centre, {no_index, no_index}};
        s_.records[record].across[on_left ? 0 : 1] = last;
        made = on_left ? lean(A, p.side, link, tag(record)) : lean(B, q.side, link, tag(record));
        if (!made) --free_;
      }
      if (!made) record = record_of(link);
      const HalfEdge entered = half_edge(record, on_left ? 1 : 2);
      if (last == no_index)
        first = {entered, made};
      else
        s_.records[record_of(last)].across[side_of(last) - 1] = entered;
      if (!made) return first;
      if (ends) {
        lean_on_second<B>(record, q.side, q.link);
        return first;
      }

      if (on_left) {
        last = half_edge(record, 2);
        p.step_out();
        turn_through(A, p.at.t, p.at.k);
      } else {
        last = half_edge(record, 1);
        q.step_out();
        turn_through(B, q.at.t, q.at.k);
      }
    }
  }

  // Whether the triangle on the left of p→q has its apex at p's rim and not at q's: whichever circle is empty.
  static bool rim_of_p_wins(const Fan<true>& p, const Fan<false>& q, const Mesh& mp, const Mesh& mq) {
    if (q.rim == no_index) return true;
    if (p.rim == no_index) return false;
    return !inside_circle(p.xy(), q.xy(), mp.xy[p.rim], mq.xy[q.rim]);
  }

  // The last triangle of a contour, with a shared apex, leans on both triangulations.
  template <int B>
  void lean_on_second(Index record, HalfEdge h, Index link) {
    const Index proxy = concurrent_ ? take_next(s_.proxies, Index{1}) : s_.proxies++;
    if (proxy >= s_.records.size()) throw std::logic_error("merge: more contours than there can be");
    s_.records[proxy] = {link, no_index, {no_index, no_index}};
    s_.records[record].across[1] = tag(proxy);
    if (!lean(B, h, link, tag(proxy))) throw std::logic_error("merge: two contours end in one triangle");
  }

  // The contour through corner k of the dead triangle t of mesh 0, both ways from its first edge.
  void start(Index t, Index k) {
    const Corner a{t, k};
    const HalfEdge at_foe = first_edge(a);
    const Corner b{triangle_of(at_foe), side_of(at_foe)};
    turn_through(0, a.t, a.k);
    turn_through(1, b.t, b.k);
    const Reached left = trace<0>(a, b), right = trace<1>(b, a);
    if (left.made) s_.records[record_of(left.edge)].across[side_of(left.edge) - 1] = right.edge;
    if (right.made) s_.records[record_of(right.edge)].across[side_of(right.edge) - 1] = left.edge;
  }

  // An edge pq of T from the pure node p = corner a to a node q of mesh 1 inside the circle of a.t, as the half-edge
  // that starts at q in a triangle of mesh 1 whose circle holds p.
  //
  // Seen from p through an inversion (u → u/|u|²) the neighbours of p in T are the corners of a convex hull, that of
  // its neighbours in both triangulations; the nodes inside the circle of a.t lie beyond one of its edges. The one
  // furthest in the direction of that edge's normal, which is that of the circle's centre, is a corner of the hull.
  HalfEdge first_edge(const Corner& a) {
    const Mesh &m0 = s_.mesh[0], &m1 = s_.mesh[1];
    const Index p = s_.at(0, a.t, a.k);
    gather_rim(p);
    gather_star(a);
    foes_.clear();
    for (const HalfEdge h : rim_) {
      const Index q = s_.origin(1, h);
      if (s_.is_pure(1, q) && holds(m0, a.t, m1.xy[q])) foes_.push_back(h);
    }
    if (foes_.empty()) throw std::logic_error("merge: a dead triangle without a node in its circle");
    if (foes_.size() == 1) return foes_[0];
    const HalfEdge far = furthest(m0.xy[p], towards_centre(a));
    return far != no_index ? far : first_edge_exactly(m0.xy[p]);
  }

  [[nodiscard]] Point2 towards_centre(const Corner& a) const {
    const Mesh& m = s_.mesh[0];
    if (a.t >= m.real) {
      const Point2 &from = m.xy[s_.at(0, a.t, 1)], &to = m.xy[s_.at(0, a.t, 0)];
      return {to.y - from.y, from.x - to.x};
    }
    const Point2 &p = m.xy[s_.at(0, a.t, a.k)], &b = m.xy[s_.at(0, a.t, next_side(a.k))],
                 &c = m.xy[s_.at(0, a.t, previous_side(a.k))];
    const double bx = b.x - p.x, by = b.y - p.y, cx = c.x - p.x, cy = c.y - p.y;
    const double b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    return {cy * b2 - by * c2, bx * c2 - cx * b2};
  }

  // The foe that is furthest in the direction after inversion about p, if it is so beyond rounding, and else no_index.
  [[nodiscard]] HalfEdge furthest(const Point2& p, const Point2& direction) const {
    struct Height {
      double value, error;
    };
    const double length = std::fabs(direction.x) + std::fabs(direction.y);
    const auto height = [&](const Point2& w) -> Height {
      const double x = w.x - p.x, y = w.y - p.y, square = x * x + y * y;
      return {(x * direction.x + y * direction.y) / square, 1e-14 * length / std::sqrt(square)};
    };
    const auto point = [&](HalfEdge h) -> const Point2& { return s_.mesh[1].xy[s_.origin(1, h)]; };
    HalfEdge best = foes_[0];
    Height top = height(point(best));
    for (const HalfEdge h : foes_)
      if (const Height here = height(point(h)); here.value > top.value) best = h, top = here;
    const auto is_below = [&](const Point2& w) {
      const Height here = height(w);
      return here.value + here.error < top.value - top.error;
    };
    for (const HalfEdge h : rim_)
      if (h != best && s_.origin(1, h) != no_index && !is_below(point(h))) return no_index;
    for (const Index w : star_)
      if (!is_below(s_.mesh[0].xy[w])) return no_index;
    return best;
  }

  // The same by triangulating p with its neighbours in both triangulations.
  [[nodiscard]] HalfEdge first_edge_exactly(const Point2& p) const {
    const Mesh &m0 = s_.mesh[0], &m1 = s_.mesh[1];
    Array<Point2> around{p};
    for (const HalfEdge h : foes_) around.push_back(m1.xy[s_.origin(1, h)]);
    for (const HalfEdge h : rim_)
      if (s_.origin(1, h) != no_index) around.push_back(m1.xy[s_.origin(1, h)]);
    for (const Index w : star_) around.push_back(m0.xy[w]);
    const SortedTriangulation star = triangulate_unsorted(around, {});
    HalfEdge found = no_index;
    for (const Triangle& triangle : star.triangulation.triangles)
      for (Index k = 0; k < 3; ++k)
        if (triangle.v[k] == star.node_of[0])
          for (std::size_t i = 0; i < foes_.size(); ++i)
            if (triangle.v[next_side(k)] == star.node_of[i + 1]) found = std::min(found, foes_[i]);
    if (found == no_index) throw std::logic_error("merge: a node in the circle of a dead triangle, and no edge to any");
    return found;
  }

  // The triangles of mesh 1 whose circles hold p form a disc without inner nodes; its rim, as half-edges from inside.
  void gather_rim(Index node) {
    const Mesh& m = s_.mesh[1];
    const Point2& p = s_.mesh[0].xy[node];
    const Index inside = holder(1, node);
    rim_.clear();
    open_.assign({half_edge(inside, 2), half_edge(inside, 1), half_edge(inside, 0)});
    while (!open_.empty()) {
      const HalfEdge h = open_.back();
      open_.pop_back();
      const Index link = s_.link(1, h);
      if (is_tag(link) || !holds(m, triangle_of(link), p)) {
        rim_.push_back(h);
      } else {
        open_.push_back(half_edge(triangle_of(link), previous_side(side_of(link))));
        open_.push_back(half_edge(triangle_of(link), next_side(side_of(link))));
      }
    }
  }

  // The neighbours in mesh 0 of the node at a corner.
  void gather_star(const Corner& a) {
    star_.clear();
    HalfEdge h = half_edge(a.t, a.k);
    do {
      if (const Index w = s_.target(0, h); w != no_index) star_.push_back(w);
      h = s_.next_leaving(0, h);
    } while (h != half_edge(a.t, a.k));
  }

  static constexpr Index chunk = 256;
  Seam& s_;
  Index& next_record_;
  bool concurrent_;
  bool found_ = false;
  Index free_ = 0, free_end_ = 0;
  Array<HalfEdge> rim_, open_, foes_;
  Array<Index> star_;
};

// The outward directions at a hull node, as the arc from that of the node before it on the hull, counter-clockwise, to
// the opposite of that of the node after it (both turned by a quarter). Whether the direction to w lies in it.
bool in_normal_arc(const Point2& centre, const Point2& before, const Point2& after, const Point2& w) {
  const int from_before = orientation(centre, before, w);
  if (from_before < 0) return false;
  if (from_before == 0 && lexicographic_less(centre, before) != lexicographic_less(centre, w)) return false;
  return orientation(centre, after, w) >= 0;
}

// Whether the shared node is on the hull of T: the outward directions that both hulls leave it have one in common.
bool is_on_hull(const Seam& s, Index united) {
  std::array<const Point2*, 2> before{}, after{};
  for (const int c : {0, 1}) {
    const HalfEdge out = s.find(c, united, no_index);
    if (out == no_index) return false;
    after[c] = &s.mesh[c].xy[s.apex(c, out)];
    before[c] = &s.mesh[c].xy[s.apex(c, s.twin(c, out))];
  }
  const Point2& centre = s.mesh[0].xy[s.mesh[0].own[united]];
  return in_normal_arc(centre, *before[0], *after[0], *before[1]) ||
         in_normal_arc(centre, *before[1], *after[1], *before[0]);
}

// For a side of mesh 0 both ends of which are shared: whether it is a side of T. It is if the other mesh has it too and
// neither mesh's node on the one side lies in the circle of the other's triangle on the other side.
bool is_side_of_both(const Seam& s, HalfEdge left_0) {
  const Index from = s.united(0, s.origin(0, left_0)), to = s.united(0, s.target(0, left_0));
  if (from == no_index || to == no_index) return is_on_hull(s, std::min(from, to));
  const HalfEdge left_1 = s.find(1, from, to);
  if (left_1 == no_index) return false;
  const auto fits = [&](int c, HalfEdge left, HalfEdge other_left) {
    const Index right = s.apex(1 - c, s.twin(1 - c, other_left));
    return right == no_index || !holds(s.mesh[c], triangle_of(left), s.mesh[1 - c].xy[right]);
  };
  return fits(0, left_0, left_1) && fits(1, left_1, left_0);
}

// Dead triangles that no contour has touched lie next to dead ones, across sides that are none of T.
void complete_all(const Seam& s, Tracer& tracer, Index t, Array<Index>& open) {
  open.assign({t});
  while (!open.empty()) {
    const Index dead = open.back();
    open.pop_back();
    tracer.complete(dead);
    for (Index k = 0; k < 3; ++k) {
      const HalfEdge h = half_edge(dead, k);
      const Index link = s.link(0, h);
      if (is_tag(link) || s.is_dead(0, triangle_of(link))) continue;
      if (!s.is_pure(0, s.origin(0, h)) && !s.is_pure(0, s.target(0, h)) && is_side_of_both(s, h)) continue;
      open.push_back(triangle_of(link));
    }
  }
}

// Triangles without a pure corner are in T if both meshes have them, and dead if not: no contour tells.
void classify_shared(Seam& s) {
  for (Mesh& m : s.mesh) {
    m.leaving.resize(m.xy.size());
    m.state.assign(m.triangles.size(), State::unknown);
    for (Index t = 0; t < m.triangles.size(); ++t)
      for (Index k = 0; k < (t < m.real ? 3U : 2U); ++k) m.leaving[m.triangles[t].v[k]] = half_edge(t, k);
  }
  for (const int c : {0, 1})
    for_each_index(s.mesh[c].triangles.size(), [&](std::size_t i) {
      const auto t = static_cast<Index>(i);
      const auto& v = s.mesh[c].triangles[t].v;
      if (s.is_pure(c, v[0]) || s.is_pure(c, v[1]) || s.is_pure(c, v[2])) return;
      const HalfEdge other = s.find(1 - c, s.united(c, v[0]), s.united(c, v[1]));
      const bool twice = other != no_index && s.united(1 - c, s.apex(1 - c, other)) == s.united(c, v[2]);
      s.mesh[c].state[t] = twice ? State::twice : State::dead;
    });
}

// Nodes of mesh 1 whose contours one task starts.
constexpr std::size_t nodes_at_once = std::size_t{1} << 15;

}  // namespace

HalfEdge Seam::find(int c, Index a, Index b) const {
  if (a == no_index) {
    const HalfEdge h = find(c, b, a);
    return h == no_index ? h : twin(c, h);
  }
  const Index node = mesh[c].own[a];
  if (node == no_index) return no_index;
  HalfEdge h = mesh[c].leaving[node];
  do {
    if (united(c, target(c, h)) == b) return h;
    h = next_leaving(c, h);
  } while (h != mesh[c].leaving[node]);
  return no_index;
}

void trace_contours(Seam& s) {
  if (s.any_shared) classify_shared(s);
  const bool concurrent = thread_count() > 1;
  Index next_record = 0;
  // Every dead region of mesh 0 holds pure nodes of mesh 1.
  for_blocks(s.mesh[1].xy.size(), nodes_at_once, [&](std::size_t begin, std::size_t end) {
    Tracer tracer(s, next_record, concurrent);
    for (auto node = static_cast<Index>(begin); node < end; ++node)
      if (s.is_pure(1, node)) tracer.complete(tracer.holder(0, node));
  });
  // What a late contour turns through may lie before the place where it was found: until nothing is.
  for (bool again = true; again;)
    again = reduce_blocks<std::uint8_t>(
                s.mesh[0].triangles.size(), 2 * nodes_at_once,
                [&](std::size_t begin, std::size_t end) {
                  Tracer tracer(s, next_record, concurrent);
                  Array<Index> open;
                  for (auto t = static_cast<Index>(begin); t < end; ++t)
                    if (s.is_dead(0, t)) complete_all(s, tracer, t, open);
                  return static_cast<std::uint8_t>(tracer.has_found());
                },
                [](std::uint8_t& any, std::uint8_t one) { any |= one; }) != 0;
}

}  // namespace isopach::seam
