#include "isopach/overlay/localise.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/base/prefetch.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

/// All bits set, or none: for a choice that must not become a branch.
Index choose(bool condition) { return -static_cast<Index>(condition); }

std::uint64_t is_negative(double x) { return std::bit_cast<std::uint64_t>(x) >> 63; }

// orientation(a, b, q), quick where q is an end of ab or where ab runs along an axis: grids and shared nodes ask for it
// all the time.
int turn(const Point2& a, const Point2& b, const Point2& q) {
  const int sign = orientation_filtered(a, b, q);
  if (sign != 2) return sign;
  const bool at_end = a == q || b == q, along_axis = (a.x == q.x && b.x == q.x) || (a.y == q.y && b.y == q.y);
  return at_end || along_axis ? 0 : exact::orientation(a, b, q);
}

// Where the foot of q lies along the hull edge a→b: < 0 before a, > 0 past b, 0 between. The direction is scaled to 1,
// so that products of the smallest coordinates do not underflow (the walk along the hull would not end).
int foot_side(const Point2& q, const Point2& a, const Point2& b) {
  const double scale = std::max(std::fabs(b.x - a.x), std::fabs(b.y - a.y));
  const double dx = (b.x - a.x) / scale, dy = (b.y - a.y) / scale;
  if ((q.x - a.x) * dx + (q.y - a.y) * dy <= 0) return -1;
  return (q.x - b.x) * dx + (q.y - b.y) * dy >= 0 ? 1 : 0;
}

// From a ghost that q sees, along the hull to the edge nearest to q. The hull is convex, so the distance falls until it
// rises; a node between two edges belongs to the edge that starts there. False if the limit is reached before.
bool to_nearest_hull_edge(const Point2& q, const Triangulation& t, std::span<const Point2> xy, Index& g,
                          std::uint64_t& visited, std::uint64_t limit) {
  const auto side = [&](Index i) { return foot_side(q, xy[t.triangles[i].v[1]], xy[t.triangles[i].v[0]]); };
  for (;;) {
    const int s = side(g);
    if (s == 0) return true;
    const Index other = triangle_of(t.triangles[g].n[s > 0 ? 2 : 1]);
    const int o = side(other);
    if (o != 0 && (o > 0) != (s > 0)) {  // the node between them is nearest
      if (s > 0) g = other;
      return true;
    }
    if (visited == limit) return false;
    ++visited;
    g = other;
  }
}

Location in_triangle(Index t, int s0, int s1, int s2, const Triangulation& mesh) {
  const auto& triangle = mesh.triangles[t];
  const int zeros = (s0 == 0 ? 1 : 0) + (s1 == 0 ? 1 : 0) + (s2 == 0 ? 1 : 0);
  if (zeros == 0) return {Location::Kind::triangle, t};
  if (zeros == 2) {
    const Index k = s0 != 0 ? 2 : (s1 != 0 ? 0 : 1);  // the corner opposite to the side that is not touched
    return {Location::Kind::node, triangle.v[k]};
  }
  const Index k = s0 == 0 ? 0 : (s1 == 0 ? 1 : 2);
  const HalfEdge h = half_edge(t, k), twin = triangle.n[k];
  return {Location::Kind::edge, mesh.is_ghost(triangle_of(twin)) ? h : std::min(h, twin)};
}

// Nodes on one line (or a single one): by bisection along it.
class OnLine {
 public:
  OnLine(const Triangulation& t, std::span<const Point2> xy) : t_(t), xy_(xy) {
    if (t.nodes < 2) return;
    Index first = t.real;
    for (Index g = t.real; g < t.triangles.size(); ++g)
      if (lexicographic_less(xy[t.triangles[g].v[1]], xy[t.triangles[first].v[1]])) first = g;
    for (Index i = 0, g = first; i + 1 < t.nodes; ++i, g = triangle_of(t.triangles[g].n[2])) chain_.push_back(g);
  }
  [[nodiscard]] Location locate(const Point2& q, std::uint64_t& visited) const {
    if (t_.nodes == 0) return {};
    if (t_.nodes == 1) return {xy_[0] == q ? Location::Kind::node : Location::Kind::outside, 0};
    // The first edge whose end is not before the foot of q.
    std::size_t lo = 0, hi = chain_.size() - 1;
    while (lo < hi) {
      ++visited;
      const std::size_t middle = lo + (hi - lo) / 2;
      const auto [a, b] = ends(middle);
      if (q == xy_[a]) return {Location::Kind::node, a};
      if (q == xy_[b]) return {Location::Kind::node, b};
      if (foot_side(q, xy_[a], xy_[b]) > 0)
        lo = middle + 1;
      else
        hi = middle;
    }
    const auto [a, b] = ends(lo);
    if (q == xy_[a]) return {Location::Kind::node, a};
    if (q == xy_[b]) return {Location::Kind::node, b};
    const bool between =
        orientation(xy_[a], xy_[b], q) == 0 && lexicographic_less(xy_[a], q) && lexicographic_less(q, xy_[b]);
    return {between ? Location::Kind::edge : Location::Kind::outside, half_edge(chain_[lo], 0)};
  }

 private:
  [[nodiscard]] std::pair<Index, Index> ends(std::size_t i) const {
    return {t_.triangles[chain_[i]].v[1], t_.triangles[chain_[i]].v[0]};
  }
  const Triangulation& t_;
  std::span<const Point2> xy_;
  Array<Index> chain_;  // ghosts of the edges in lexicographic order
};

// Routes: in which order the nodes are located, and in which triangle each walk starts. Every triangle of a walk is
// noted as the answer (the last one stays), so that no branch depends on where the walk ends.
class InOrder {
 public:
  explicit InOrder(Locations& result) : kind_(result.kind.data()), id_(result.id.data()) {}
  [[nodiscard]] Index node(Index place) const { return place; }
  void prefetch(Index) const {}
  void note(Index, Index node, Index at) { id_[node] = at; }
  void settle(Index, Index node, const Location& found, Index) {
    kind_[node] = found.kind;
    id_[node] = found.id;
  }
  /// The walk before `place` ended in `at`.
  [[nodiscard]] Index start(Index, Index, Index at) const { return at; }

 private:
  Location::Kind* kind_;
  Index* id_;
};

class AlongTree {
 public:
  AlongTree(const SpanningTree& tree, Locations& result)
      : result_(result), order_(tree.order.data()), parent_(tree.parent.data()), reached_(tree.order.size()) {}
  [[nodiscard]] Index node(Index place) const { return order_[place]; }
  [[gnu::always_inline]] void prefetch(Index place) const {
    isopach::prefetch(order_ + place);
    isopach::prefetch(parent_ + place);
  }
  void note(Index place, Index node, Index at) {
    reached_[place] = at;
    result_.note(place, node, at);
  }
  void settle(Index place, Index node, const Location& found, Index at) {
    reached_[place] = at;
    result_.settle(place, node, found, at);
  }
  /// Where the parent lies; where the one before lies, if the parent is not of this run.
  /// Asked for the first place of a run too, it answers something of that run.
  [[nodiscard]] Index start(Index place, Index first, Index) const {
    const Index parent = parent_[place], before = place - (place != first ? 1 : 0);
    const Index known = choose(parent - first < place - first);
    return reached_[(parent & known) | (before & ~known)];
  }

 private:
  InOrder result_;
  const Index* order_;
  const Index* parent_;
  Array<Index> reached_;  // by place
};

// Every `stride`-th node of another route, for the triangles where its runs start.
template <class Route>
class Sample {
 public:
  Sample(const Route& route, std::size_t stride, std::size_t count)
      : route_(route), stride_(static_cast<Index>(stride)), reached_(count) {}
  [[nodiscard]] Index node(Index place) const { return route_.node(place * stride_); }
  void prefetch(Index) const {}
  void note(Index place, Index, Index at) { reached_[place] = at; }
  void settle(Index place, Index, const Location&, Index at) { reached_[place] = at; }
  [[nodiscard]] Index start(Index, Index, Index at) const { return at; }
  [[nodiscard]] Index reached(std::size_t place) const { return reached_[place]; }

 private:
  const Route& route_;
  Index stride_;
  Array<Index> reached_;
};

// Walks a run of places [place, end), at triangle `at` now.
struct Walker {
  Index place, first, end, at;
};

// A walk is a chain of memory accesses and of branches nobody can predict. So many runs are walked by turns, one
// triangle a turn: what a walker needs next is fetched while the others move; and of a triangle all three sides are
// looked at without a branch. Only ghosts, and points that the filter cannot tell from a side, take the way of
// `locate`.
template <class Route>
class Walks {
 public:
  Walks(std::span<const Point2> points, const Triangulation& t, std::span<const Point2> xy, Route& route)
      : points_(points.data()), t_(t), xy_(xy), route_(route) {}

  /// Walks all runs to their ends. Returns the triangles visited.
  std::uint64_t finish(std::span<Walker> walkers) {
    std::uint64_t visited = 0;
    while (!walkers.empty()) {
      for (const Walker& w : walkers) fetch_corners(w.at);
      for (std::size_t i = 0; i < walkers.size();) {
        Walker& w = walkers[i];
        fetch_ahead(w);
        step(w, visited);
        prefetch(&t_.triangles[w.at]);
        prefetch(&t_.triangles[w.at].n[2]);
        if (w.place != w.end) {
          ++i;
        } else {
          w = walkers.back();
          walkers = walkers.first(walkers.size() - 1);
        }
      }
    }
    return visited;
  }

 private:
  [[gnu::always_inline]] void fetch_corners(Index at) const {
    const Triangle& triangle = t_.triangles[at];
    prefetch(&xy_[triangle.v[0]]);
    prefetch(&xy_[triangle.v[1]]);
    prefetch(&xy_[triangle.v[t_.is_ghost(at) ? 0 : 2]]);
  }

  [[gnu::always_inline]] void fetch_ahead(const Walker& w) const {
    prefetch(points_ + route_.node(std::min(w.place + 1, w.end - 1)));
    route_.prefetch(std::min(w.place + 16, w.end - 1));
  }

  void step(Walker& w, std::uint64_t& visited) {
    const Index node = route_.node(w.place);
    const Point2& q = points_[node];
    if (t_.is_ghost(w.at)) [[unlikely]]
      return settle(w, visited);
    const Triangle& triangle = t_.triangles[w.at];
    const Point2 &a = xy_[triangle.v[0]], &b = xy_[triangle.v[1]], &c = xy_[triangle.v[2]];
    const double ax = a.x - q.x, ay = a.y - q.y, bx = b.x - q.x, by = b.y - q.y, cx = c.x - q.x, cy = c.y - q.y;
    const double ab = ax * by, ba = ay * bx, bc = bx * cy, cb = by * cx, ca = cx * ay, ac = cy * ax;
    const double side0 = ab - ba, side1 = bc - cb, side2 = ca - ac;
    const double least01 = std::min(side0, side1), least = std::min(least01, side2);
    // The filter of orientation, one for all sides. Not a number and infinity do not pass.
    const double all =
        std::fabs(ab) + std::fabs(ba) + (std::fabs(bc) + std::fabs(cb)) + (std::fabs(ca) + std::fabs(ac));
    if (!(std::fabs(least) > orientation_filter * all + underflow_guard)) [[unlikely]]
      return settle(w, visited);
    ++visited;
    route_.note(w.place, node, w.at);
    // Out through the side that q is farthest beyond, or on to the next node.
    const std::uint64_t is2 = is_negative(side2 - least01), is1 = is_negative(side1 - side0) & ~is2;
    const Index next = triangle_of(triangle.n[is1 + 2 * is2]);
    const auto inside = static_cast<Index>(1 - is_negative(least));
    w.place += inside;
    if (w.place == w.end) [[unlikely]]
      return;
    const Index start = route_.start(w.place, w.first, w.at), mask = choose(inside);
    w.at = (start & mask) | (next & ~mask);
  }

  // The end of this walk, by exact predicates.
  void settle(Walker& w, std::uint64_t& visited) {
    const Index node = route_.node(w.place);
    const Location found = locate(points_[node], t_, xy_, w.at, visited);
    route_.settle(w.place, node, found, w.at);
    if (++w.place != w.end) w.at = route_.start(w.place, w.first, w.at);
  }

  const Point2* points_;
  const Triangulation& t_;
  std::span<const Point2> xy_;
  Route& route_;
};

constexpr std::size_t walkers_at_once = 64;  // that take turns: the first-level cache has room for what they fetch
constexpr std::size_t smallest_block = std::size_t{1} << 15, most_blocks = 16;  // for threads
constexpr std::size_t sample_run = 64;

}  // namespace

Location locate(const Point2& q, const Triangulation& t, std::span<const Point2> xy, Index& at, std::uint64_t& visited,
                std::uint64_t limit) {
  Index from = 3;     // side we came in by
  int from_sign = 1;  // q lies on its inner side, or (from a ghost) on it
  Index current = at;
  for (;;) {
    if (visited == limit) {
      at = current;
      return {};
    }
    ++visited;
    const Triangle& triangle = t.triangles[current];
    if (t.is_ghost(current)) {
      const bool came_from_inside = from != 3;
      const int side = came_from_inside ? -1 : turn(xy[triangle.v[1]], xy[triangle.v[0]], q);
      if (side < 0) {
        at = current;
        if (!to_nearest_hull_edge(q, t, xy, at, visited, limit)) return {};
        return {Location::Kind::outside, half_edge(at, 0)};
      }
      from = side_of(triangle.n[0]);
      current = triangle_of(triangle.n[0]);
      from_sign = side;
      continue;
    }
    int sign[3];
    Index out = 3;
    for (Index k = 0; k < 3; ++k) {
      sign[k] = k == from ? from_sign : turn(xy[triangle.v[k]], xy[triangle.v[next_side(k)]], q);
      if (sign[k] < 0) {
        out = k;
        break;
      }
    }
    if (out == 3) {
      at = current;
      return in_triangle(current, sign[0], sign[1], sign[2], t);
    }
    from = side_of(triangle.n[out]);
    current = triangle_of(triangle.n[out]);
    from_sign = 1;
  }
}

namespace {

template <class Map>
std::uint64_t sum_blocks(std::size_t n, std::size_t block, const Map& map) {
  return reduce_blocks<std::uint64_t>(n, block, map, [](std::uint64_t& sum, std::uint64_t part) { sum += part; });
}

void locate_on_line(std::span<const Point2> points, const OnLine& line, Locations& result) {
  result.visited = sum_blocks(points.size(), default_block, [&](std::size_t begin, std::size_t end) {
    std::uint64_t visited = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const Location found = line.locate(points[i], visited);
      result.kind[i] = found.kind;
      result.id[i] = found.id;
    }
    return visited;
  });
}

// Runs of `length` places, each from its entry, `walkers_at_once` of them by turns. Returns the triangles visited.
template <class Route, class Entry>
std::uint64_t walk_runs(std::size_t n, std::size_t length, Walks<Route> walks, const Entry& entry) {
  return sum_blocks(n, walkers_at_once * length, [&](std::size_t begin, std::size_t end) {
    std::array<Walker, walkers_at_once> all;
    std::size_t count = 0;
    for (std::size_t from = begin; from < end; from += length) {
      const auto first = static_cast<Index>(from), last = static_cast<Index>(std::min(from + length, end));
      all[count++] = {first, first, last, entry(from / length)};
    }
    return walks.finish({all.data(), count});
  });
}

// Every run starts where the walk along a sample of the nodes, one of each run, has found its first node. The few runs
// of the sample itself are started one from the other.
template <class Route>
std::uint64_t walk(Route& route, std::span<const Point2> points, const Triangulation& t, std::span<const Point2> xy) {
  const std::size_t n = points.size(), blocks = std::clamp(n / smallest_block, std::size_t{1}, most_blocks);
  const std::size_t length = (n - 1) / (walkers_at_once * blocks) + 1, runs = (n - 1) / length + 1;
  Sample<Route> sample(route, length, runs);
  std::uint64_t visited = 0;
  Array<Index> entries;
  for (std::size_t run = 0; run < runs; run += sample_run) {
    Index at = entries.empty() ? 0 : entries.back();
    (void)locate(points[sample.node(static_cast<Index>(run))], t, xy, at, visited);
    entries.push_back(at);
  }
  visited += walk_runs(runs, sample_run, Walks(points, t, xy, sample), [&](std::size_t run) { return entries[run]; });
  visited += walk_runs(n, length, Walks(points, t, xy, route), [&](std::size_t run) { return sample.reached(run); });
  return visited;
}

template <class Make>
Locations localise_along(std::span<const Point2> points, const Triangulation& t, std::span<const Point2> xy,
                         const Make& make_route) {
  Locations result;
  result.kind.resize(points.size());
  result.id.resize(points.size());
  if (t.real == 0) {
    locate_on_line(points, OnLine(t, xy), result);
  } else if (!points.empty()) {
    for_blocks(points.size(), default_block, [&](std::size_t begin, std::size_t end) {
      std::fill(result.kind.begin() + begin, result.kind.begin() + end, Location::Kind::triangle);
    });
    auto route = make_route(result);
    result.visited = walk(route, points, t, xy);
  }
  return result;
}

}  // namespace

Locations localise(std::span<const Point2> points, const SpanningTree& tree, const Triangulation& t,
                   std::span<const Point2> xy, const Context& context) {
  context.check();
  return localise_along(points, t, xy, [&](Locations& result) { return AlongTree(tree, result); });
}

Locations localise_in_order(std::span<const Point2> points, const Triangulation& t, std::span<const Point2> xy,
                            const Context& context) {
  context.check();
  return localise_along(points, t, xy, [&](Locations& result) { return InOrder(result); });
}

}  // namespace isopach
