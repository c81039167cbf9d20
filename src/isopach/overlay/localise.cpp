#include "isopach/overlay/localise.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "isopach/base/parallel.hpp"
#include "isopach/geom/predicates.hpp"

namespace isopach {

namespace {

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

// Points of one block are located one after the other; the first of each block continues from the block before.
constexpr std::size_t block_size = 1 << 15;

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
      const int side = came_from_inside ? -1 : orientation(xy[triangle.v[1]], xy[triangle.v[0]], q);
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
      sign[k] = k == from ? from_sign : orientation(xy[triangle.v[k]], xy[triangle.v[next_side(k)]], q);
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

Locations localise(std::span<const Point2> points, const SpanningTree& tree, const Triangulation& t,
                   std::span<const Point2> xy, const Context& context) {
  const std::size_t n = points.size();
  Locations result;
  result.kind.resize(n);
  result.id.resize(n);
  if (n == 0) return result;
  context.check();
  const std::size_t blocks = (n + block_size - 1) / block_size;
  std::vector<std::uint64_t> visited(blocks, 0);
  if (t.real == 0) {
    const OnLine line(t, xy);
    for_blocks(n, block_size, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Location found = line.locate(points[i], visited[begin / block_size]);
        result.kind[i] = found.kind;
        result.id[i] = found.id;
      }
    });
  } else {
    std::vector<Index> entry(blocks);
    Index at = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      (void)locate(points[tree.order[b * block_size]], t, xy, at, visited[b]);
      entry[b] = at;
    }
    for_blocks(n, block_size, [&](std::size_t begin, std::size_t end) {
      const std::size_t b = begin / block_size;
      Array<Index> reached(end - begin);  // triangle of each place of this block
      Index here = entry[b];
      for (std::size_t p = begin; p < end; ++p) {
        const Index parent = tree.parent[p];
        if (parent != no_index && parent >= begin) here = reached[parent - begin];
        const Index node = tree.order[p];
        const Location found = locate(points[node], t, xy, here, visited[b]);
        reached[p - begin] = here;
        result.kind[node] = found.kind;
        result.id[node] = found.id;
      }
    });
  }
  for (const std::uint64_t v : visited) result.visited += v;
  return result;
}

}  // namespace isopach
