#include "isopach/overlay/insert.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "isopach/base/parallel.hpp"
#include "isopach/base/prefetch.hpp"
#include "isopach/delaunay/ghosts.hpp"
#include "isopach/delaunay/plane.hpp"

namespace isopach {

namespace {

// next_side and previous_side without a branch: which side a cavity is entered by, nobody can predict.
constexpr Index side_after(Index side) { return (9U >> (2 * side)) & 3U; }
constexpr Index side_before(Index side) { return (18U >> (2 * side)) & 3U; }

// A node to be inserted, and the place of the triangle of the mesh that it lies in, or near.
struct Guest {
  Index node, place;
};
using Guests = Array<Guest>;

// The places [begin, end) that a task may read and write.
struct Places {
  Index begin, end;
  [[nodiscard]] bool hold(Index t) const { return t - begin < end - begin; }
};

// How many tests all tasks have made together, and how many they may. Whether the sum exceeds the limit in the end does
// not depend on when a task looks at it.
struct Budget {
  std::uint64_t limit;
  std::uint64_t spent = 0;
};

// A node as the one that is inserted sees it: where it lies from there, and its height on the paraboloid above that.
struct Offset {
  double x, y, lift;
};
Offset offset(const Point2& from, const Point2& to) {
  const double x = to.x - from.x, y = to.y - from.y;
  return {x, y, x * x + y * y};
}
double cross(const Offset& a, const Offset& b) { return a.x * b.y - a.y * b.x; }

// What is looked at next: across the side from→to of a triangle in conflict. `area` is cross(from, to).
struct Opening {
  HalfEdge twin;
  Index origin;
  Offset from, to;
  double area;
};

struct RimSide {
  HalfEdge outside;
  Index origin;
};

// For counter-clockwise a, b, c seen from q: 1 if q is inside their circle, −1 outside, 0 if that is open. The filter
// of geom/predicates.hpp; its permanent is at most la·lb + lb·lc + lc·la, as |ax·by| + |ay·bx| <= |a||b| <= (la +
// lb)/2. The constant leaves 1e-7 for the rounding of that sum.
int circle_sign(double la, double lb, double lc, double bc, double ca, double ab) {
  constexpr double filter = in_circle_filter * (1 + 1e-7);
  const double det = la * bc + lb * ca + lc * ab;
  const double bound = filter * (la * lb + lb * lc + lc * la) + underflow_guard * (1 + la + lb + lc);
  return det > bound ? 1 : (det < -bound ? -1 : 0);
}

// Inserts nodes one after the other, within some places.
class Inserter {
 public:
  Inserter(const Plane& xy, Triangle* t, Places places, Budget& budget)
      : xy_(xy), t_(t), places_(places), budget_(budget) {
    make_room(64);
  }

  // Returns those whose cavities reach beyond the places. Gives up when the budget is spent.
  Guests run(const Guests& guests) {
    Guests deferred;
    Index last_place = no_index, at = no_index;
    for (std::size_t i = 0; i < guests.size(); ++i) {
      if (i % 256 == 0 && is_spent()) break;
      look_ahead(guests, i);
      const Guest& guest = guests[i];
      // Several in one triangle of the mesh: the one before has just been there.
      if (guest.place != last_place || at == no_index) at = guest.place;
      last_place = guest.place;
      at = insert(guest.node, at);
      if (at == no_index) deferred.push_back(guest);
    }
    (void)is_spent();
    return deferred;
  }

 private:
  // Adds what was done since the last time.
  bool is_spent() {
    const std::uint64_t more = std::exchange(tests_, 0);
    return take_next(budget_.spent, more) + more > budget_.limit;
  }

  // Inlined, lest the compiler drops it (see prefetch).
  [[gnu::always_inline]] void look_ahead(const Guests& guests, std::size_t i) const {
    constexpr std::size_t far = 12, near = 6;
    if (i + far >= guests.size()) return;
    prefetch(&t_[guests[i + far].place]);
    const Index place = guests[i + near].place;
    if (!places_.hold(place)) return;
    for (const HalfEdge h : t_[place].n) prefetch(&t_[triangle_of(h)]);
  }

  // Returns a triangle at the node, or none if the cavity leaves the places; nothing has changed then.
  Index insert(Index node, Index at) {
    dead_.clear(), rim_.clear(), open_.clear();
    has_ghosts_ = false;
    if (!find_first(node, at)) return no_index;
    while (!open_.empty())
      if (!look_across(node, taken(open_.pop()))) return no_index;
    dead_.push_back(2 * node);
    dead_.push_back(2 * node + 1);
    has_ghosts_ ? fill<true>(node) : fill<false>(node);
    return dead_[0];
  }

  // A stack whose room is known to suffice.
  template <class T>
  struct Stack {
    Array<T> items;
    std::size_t size = 0;
    void clear() { size = 0; }
    [[nodiscard]] bool empty() const { return size == 0; }
    void push_back(const T& item) { items[size++] = item; }
    const T& pop() { return items[--size]; }
    T& operator[](std::size_t i) { return items[i]; }
    const T& operator[](std::size_t i) const { return items[i]; }
  };

  // For a cavity of d triangles: its rim has d + 2 sides, and no more are open at a time.
  [[gnu::noinline]] void make_room(std::size_t d) {
    dead_.items.resize(d + 4);
    rim_.items.resize(d + 4);
    open_.items.resize(d + 4);
  }

  void kill(Index t) {
    if (dead_.size + 4 > dead_.items.size()) [[unlikely]]
      make_room(2 * dead_.items.size());
    dead_.push_back(t);
  }

  [[nodiscard]] bool is_in_conflict(const Triangle& w, Index node, int circle) const {
    return circle > 0 || (circle == 0 && xy_.inside(w.v[0], w.v[1], w.v[2], node));
  }
  [[nodiscard]] bool is_beyond(const Triangle& ghost, Index node) const {
    const Index a = ghost.v[1], b = ghost.v[0];
    const int turn = xy_.turn(a, b, node);
    if (turn != 0) return turn < 0;
    return lexicographic_less(xy_[a], xy_[node]) != lexicographic_less(xy_[b], xy_[node]);  // between the two
  }

  // Walks to a triangle in conflict and opens its sides. A visibility walk, which cannot cycle [Edelsbrunner1989].
  bool find_first(Index node, Index at) {
    const Point2& q = xy_[node];
    for (;; ++tests_) {
      if (!places_.hold(at)) return false;
      const Triangle& w = t_[at];
      if (w.v[2] == no_index) {
        if (is_beyond(w, node)) return open_ghost(node, at);
        at = triangle_of(w.n[0]);
        continue;
      }
      const Offset a = offset(q, xy_[w.v[0]]), b = offset(q, xy_[w.v[1]]), c = offset(q, xy_[w.v[2]]);
      const double ab = cross(a, b), bc = cross(b, c), ca = cross(c, a);
      if (is_in_conflict(w, node, circle_sign(a.lift, b.lift, c.lift, bc, ca, ab))) {
        kill(at);
        open_.push_back({w.n[2], w.v[2], c, a, ca});
        open_.push_back({w.n[1], w.v[1], b, c, bc});
        open_.push_back({w.n[0], w.v[0], a, b, ab});
        return true;
      }
      at = triangle_of(w.n[side_towards(w, node, {ab, bc, ca}, a.lift + b.lift + c.lift)]);
    }
  }

  // A side that has the node strictly beyond it: there is one, as the triangle does not contain it.
  [[nodiscard]] Index side_towards(const Triangle& w, Index node, const std::array<double, 3>& area,
                                   double size) const {
    const Index least = area[0] <= area[1] && area[0] <= area[2] ? 0 : (area[1] <= area[2] ? 1 : 2);
    if (area[least] < -(orientation_filter * size + underflow_guard)) return least;
    for (Index k = 0; k < 2; ++k)
      if (xy_.turn(w.v[k], w.v[next_side(k)], node) < 0) return k;
    return 2;
  }

  bool open_ghost(Index node, Index ghost) {
    kill(ghost);
    has_ghosts_ = true;
    for (Index k = 3; k-- > 0;) open_.push_back(opening_of_ghost(node, ghost, k));
    return true;
  }

  // Only the side of the hull edge has two ends; across the others there is a ghost, which asks for none.
  [[nodiscard]] Opening opening_of_ghost(Index node, Index ghost, Index side) const {
    const Triangle& w = t_[ghost];
    Opening opening{w.n[side], w.v[side], {}, {}, 0};
    if (side != 0) return opening;
    opening.from = offset(xy_[node], xy_[w.v[0]]);
    opening.to = offset(xy_[node], xy_[w.v[1]]);
    opening.area = cross(opening.from, opening.to);
    return opening;
  }

  // One by one: a wide load of what narrow stores have just written would wait for them.
  static Opening taken(const Opening& o) {
    return {o.twin, o.origin, {o.from.x, o.from.y, o.from.lift}, {o.to.x, o.to.y, o.to.lift}, o.area};
  }

  // What lies across is in conflict and opens its two other sides, the first of which is looked across at once; or the
  // side is of the rim. So sides come to the rim in counter-clockwise order. False if what lies across is out of reach.
  bool look_across(Index node, Opening o) {
    const Point2& q = xy_[node];
    for (;;) {
      ++tests_;
      const Index t = triangle_of(o.twin), side = side_of(o.twin);
      if (!places_.hold(t)) return false;
      const Triangle& w = t_[t];
      if (w.v[2] == no_index) [[unlikely]]
        return look_at_ghost(node, o);
      // The triangle is (to, from, c).
      const Index apex = w.v[side_before(side)];
      const Offset c = offset(q, xy_[apex]);
      const double from_c = cross(o.from, c), c_to = cross(c, o.to);
      if (!is_in_conflict(w, node, circle_sign(o.to.lift, o.from.lift, c.lift, from_c, c_to, -o.area))) {
        rim_.push_back({o.twin, o.origin});
        return true;
      }
      kill(t);
      const HalfEdge later = w.n[side_before(side)];
      prefetch(&t_[triangle_of(later)]);
      open_.push_back({later, apex, c, o.to, c_to});
      o.twin = w.n[side_after(side)];
      o.to = c;
      o.area = from_c;
    }
  }

  bool look_at_ghost(Index node, const Opening& o) {
    const Index ghost = triangle_of(o.twin), side = side_of(o.twin);
    if (!is_beyond(t_[ghost], node)) {
      rim_.push_back({o.twin, o.origin});
      return true;
    }
    kill(ghost);
    has_ghosts_ = true;
    open_.push_back(opening_of_ghost(node, ghost, side_before(side)));
    open_.push_back(opening_of_ghost(node, ghost, side_after(side)));
    return true;
  }

  // The triangles (origin i, origin i + 1, node), in the places of the dead ones and the two of the node. One that has
  // the infinite node is turned so that it comes last.
  template <bool has_ghosts>
  void fill(Index node) {
    const std::size_t sides = rim_.size;
    if (sides != dead_.size) throw std::logic_error("insert: a cavity that is no disc");
    const auto first_corner = [&](std::size_t i, std::size_t following) -> Index {
      if (!has_ghosts) return 0;
      return rim_[i].origin == no_index ? 2 : (rim_[following].origin == no_index ? 1 : 0);
    };
    std::size_t before = sides - 1;
    for (std::size_t i = 0; i < sides; ++i) {
      const std::size_t after = i + 1 == sides ? 0 : i + 1;
      const std::size_t after_next = has_ghosts && after + 1 != sides ? after + 1 : 0;
      const Index k = first_corner(i, after), next = next_side(k), previous = previous_side(k);
      const RimSide& side = rim_[i];
      Triangle& w = t_[dead_[i]];
      w.v[k] = side.origin;
      w.v[next] = rim_[after].origin;
      w.v[previous] = node;
      w.n[k] = side.outside;
      w.n[next] = half_edge(dead_[after], previous_side(first_corner(after, after_next)));
      w.n[previous] = half_edge(dead_[before], next_side(first_corner(before, i)));
      t_[triangle_of(side.outside)].n[side_of(side.outside)] = half_edge(dead_[i], k);
      before = i;
    }
  }

  const Plane& xy_;
  Triangle* t_;
  const Places places_;
  Budget& budget_;
  std::uint64_t tests_ = 0;  // not yet in the budget
  bool has_ghosts_ = false;
  Stack<Index> dead_;  // and then places of the new ones
  Stack<RimSide> rim_;
  Stack<Opening> open_;
};

// All of it: the copy, the insertions block by block, the end.
class Insertion {
 public:
  Insertion(const MeshToExtend& mesh, const NodesToInsert& nodes, std::span<const Point2> xy, const Context& context,
            const InsertOptions& options)
      : mesh_(mesh),
        nodes_(nodes),
        plane_(xy),
        context_(context),
        nodes_at_once_(options.nodes_at_once),
        united_(mesh.triangulation.nodes) {
    const std::size_t n = xy.size();
    for_each_index(n, [&](std::size_t u) {
      if (mesh_.node[u] != no_index) united_[mesh_.node[u]] = static_cast<Index>(u);
    });
    result_.nodes = static_cast<Index>(n);
    result_.triangles.resize(2 * n);
    budget_.limit = std::min(options.most_tests * (n - united_.size()), options.most_tests_of_union * n) + 1000;
  }

  std::optional<Triangulation> run() {
    copy();
    context_.check();
    const Guests left = insert_range(0, result_.nodes);
    context_.check();
    if (budget_.spent > budget_.limit) return std::nullopt;
    if (!left.empty()) throw std::logic_error("insert: a node without a place");
    finish();
    return std::move(result_);
  }

 private:
  [[nodiscard]] Index place_of(Index t) const { return 2 * united_[t >> 1] + (t & 1); }
  [[nodiscard]] HalfEdge place_of_side(HalfEdge h) const { return half_edge(place_of(triangle_of(h)), side_of(h)); }

  void copy() {
    const auto& from = mesh_.triangulation.triangles;
    for_each_index(from.size(), [&](std::size_t i) {
      const Triangle& t = from[i];
      Triangle& to = result_.triangles[place_of(static_cast<Index>(i))];
      for (Index k = 0; k < 3; ++k) {
        to.v[k] = t.v[k] == no_index ? no_index : united_[t.v[k]];
        to.n[k] = place_of_side(t.n[k]);
      }
    });
  }

  // The nodes [begin, end) of the union, those left over that reach beyond their triangles. What two halves leave is
  // tried again in the whole.
  Guests insert_range(std::size_t begin, std::size_t end) {
    Guests guests;
    if (end - begin <= nodes_at_once_) {
      context_.check();
      guests = list(begin, end);
    } else {
      const std::size_t middle = begin + (end - begin) / 2;
      Guests second;
      both([&] { guests = insert_range(begin, middle); }, [&] { second = insert_range(middle, end); });
      guests.insert(guests.end(), second.begin(), second.end());
    }
    const Places places{static_cast<Index>(2 * begin), static_cast<Index>(2 * end)};
    return Inserter(plane_, result_.triangles.data(), places, budget_).run(guests);
  }

  // Without a branch on whose a node is, which nobody can predict: every node is written down, and counted if it
  // counts.
  [[nodiscard]] Guests list(std::size_t begin, std::size_t end) const {
    if (nodes_.in_mesh.size() == 0) return {};
    Guests guests(end - begin + 1);
    std::size_t count = 0;
    Index id = 0;
    for (std::size_t u = begin; u < end; ++u) {
      const bool is_new = mesh_.node[u] == no_index;
      const Index node = is_new ? nodes_.node[u] : 0;
      const Index at = nodes_.in_mesh.id[node];
      const bool is_triangle = nodes_.in_mesh.kind[node] == Location::Kind::triangle;
      id = is_new ? (is_triangle ? at : triangle_of(at)) : id;
      guests[count] = {static_cast<Index>(u), place_of(id)};
      count += is_new ? 1 : 0;
    }
    guests.resize(count);
    return guests;
  }

  // The two places that the last node of the mesh does not use are filled from the end, where two are too many.
  void finish() {
    auto& t = result_.triangles;
    const Index free = 2 * united_.back();
    for (Index k = 2; k-- > 0;) {
      const auto last = static_cast<Index>(t.size() - 1);
      if (free + k != last) move(last, free + k);
      t.pop_back();
    }
    Index ghost = static_cast<Index>(t.size()) - 1;
    while (t[ghost].v[2] != no_index) --ghost;  // most meshes end with one
    result_.real = gather_ghosts(t, ghost);
  }

  void move(Index from, Index to) {
    auto& t = result_.triangles;
    t[to] = t[from];
    for (Index k = 0; k < 3; ++k) t[triangle_of(t[to].n[k])].n[side_of(t[to].n[k])] = half_edge(to, k);
  }

  const MeshToExtend& mesh_;
  const NodesToInsert& nodes_;
  const Plane plane_;
  const Context& context_;
  const std::size_t nodes_at_once_;  // their triangles fit the second-level cache
  Array<Index> united_;              // by node of the mesh: the node of the union
  Triangulation result_;
  Budget budget_{};
};

}  // namespace

std::optional<Triangulation> insert(const MeshToExtend& mesh, const NodesToInsert& nodes, std::span<const Point2> xy,
                                    const Context& context, const InsertOptions& options) {
  context.check();
  return Insertion(mesh, nodes, xy, context, options).run();
}

}  // namespace isopach
