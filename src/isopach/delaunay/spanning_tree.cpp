#include "isopach/delaunay/spanning_tree.hpp"

#include <algorithm>

#include "isopach/base/parallel.hpp"

namespace isopach {

namespace {

// Total order of the edges: length, then the curve order of the ends (a function of the point set, like the length).
struct Edge {
  double length2;
  Index a, b;  // a < b
  friend bool operator<(const Edge& p, const Edge& q) {
    if (p.length2 != q.length2) return p.length2 < q.length2;
    return p.a != q.a ? p.a < q.a : p.b < q.b;
  }
};

Edge make_edge(std::span<const Point2> xy, Index a, Index b) {
  if (a > b) std::swap(a, b);
  const double dx = xy[b].x - xy[a].x, dy = xy[b].y - xy[a].y;
  return {dx * dx + dy * dy, a, b};
}

// Side of a real triangle that is its longest edge: never in the tree (cycle rule).
Index longest_side(const Triangle& t, std::span<const Point2> xy) {
  const Edge e0 = make_edge(xy, t.v[0], t.v[1]), e1 = make_edge(xy, t.v[1], t.v[2]), e2 = make_edge(xy, t.v[2], t.v[0]);
  if (e0 < e1) return e1 < e2 ? 2 : 1;
  return e0 < e2 ? 2 : 0;
}

// About 1.3 edges a node are left of 3.
Array<Edge> candidate_edges(const Triangulation& t, std::span<const Point2> xy) {
  const std::size_t triangles = t.triangles.size();
  Array<std::uint8_t> longest(triangles);
  for_each_index(triangles, [&](std::size_t i) {
    longest[i] = i < t.real ? static_cast<std::uint8_t>(longest_side(t.triangles[i], xy)) : std::uint8_t{3};
  });
  // Every edge is looked at once, from its half-edge of the lower id.
  const auto keeps = [&](Index i, Index k) {
    const HalfEdge h = t.triangles[i].n[k];
    if (h < half_edge(i, k) || longest[i] == k || longest[triangle_of(h)] == side_of(h)) return false;
    return t.triangles[i].v[k] != no_index && t.triangles[i].v[next_side(k)] != no_index;
  };
  constexpr std::size_t block = 1 << 15;
  std::vector<std::size_t> start(triangles / block + 2, 0);
  for_blocks(triangles, block, [&](std::size_t begin, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < end; ++i)
      for (Index k = 0; k < 3; ++k) count += keeps(static_cast<Index>(i), k) ? 1 : 0;
    start[begin / block + 1] = count;
  });
  for (std::size_t b = 1; b < start.size(); ++b) start[b] += start[b - 1];
  Array<Edge> edges(start.back());
  for_blocks(triangles, block, [&](std::size_t begin, std::size_t end) {
    std::size_t place = start[begin / block];
    for (std::size_t i = begin; i < end; ++i)
      for (Index k = 0; k < 3; ++k)
        if (keeps(static_cast<Index>(i), k))
          edges[place++] = make_edge(xy, t.triangles[i].v[k], t.triangles[i].v[next_side(k)]);
  });
  return edges;
}

// Borůvka: every component takes its shortest outgoing edge; components that meet become one. An edge whose ends have
// met is dropped. Each round at least halves the components.
Array<Edge> boruvka(Array<Edge> edges, std::size_t nodes) {
  Array<Edge> tree;
  tree.reserve(nodes > 0 ? nodes - 1 : 0);
  Array<Index> component(nodes), best(nodes);
  for (std::size_t i = 0; i < nodes; ++i) component[i] = static_cast<Index>(i);
  const auto root = [&](Index v) {
    while (component[v] != v) {
      component[v] = component[component[v]];
      v = component[v];
    }
    return v;
  };
  while (!edges.empty()) {
    std::fill(best.begin(), best.end(), no_index);
    std::size_t kept = 0;
    for (const Edge e : edges) {
      const Index ra = root(e.a), rb = root(e.b);
      if (ra == rb) continue;
      const auto id = static_cast<Index>(kept);
      edges[kept++] = e;
      for (const Index r : {ra, rb})
        if (best[r] == no_index || e < edges[best[r]]) best[r] = id;
    }
    edges.resize(kept);
    for (std::size_t v = 0; v < nodes; ++v) {
      if (best[v] == no_index) continue;
      const Edge& e = edges[best[v]];
      const Index ra = root(e.a), rb = root(e.b);
      if (ra == rb) continue;  // the edge was chosen from its other end
      component[std::max(ra, rb)] = std::min(ra, rb);
      tree.push_back(e);
    }
  }
  return tree;
}

// Depth first from node 0, neighbours in curve order.
SpanningTree walk(const Array<Edge>& edges, std::size_t nodes) {
  Array<Index> start(nodes + 1), neighbour(2 * edges.size());
  std::fill(start.begin(), start.end(), 0);
  for (const Edge& e : edges) ++start[e.a], ++start[e.b];
  Index sum = 0;
  for (auto& s : start) {
    const Index count = s;
    s = sum;
    sum += count;
  }
  for (const Edge& e : edges) {
    neighbour[start[e.a]++] = e.b;
    neighbour[start[e.b]++] = e.a;
  }
  SpanningTree tree;
  tree.order.resize(nodes);
  tree.parent.resize(nodes);
  if (nodes == 0) return tree;
  struct Waiting {
    Index node, parent;  // parent: place in the order
  };
  Array<Waiting> stack;
  stack.push_back({0, no_index});
  Index place = 0;
  while (!stack.empty()) {
    const auto [v, parent] = stack.back();
    stack.pop_back();
    tree.order[place] = v;
    tree.parent[place] = parent;
    const Index above = parent == no_index ? no_index : tree.order[parent];
    const Index first = v == 0 ? 0 : start[v - 1], last = start[v];  // start[] has moved on by one place
    std::sort(neighbour.begin() + static_cast<std::ptrdiff_t>(first),
              neighbour.begin() + static_cast<std::ptrdiff_t>(last));
    for (Index i = last; i-- > first;)
      if (neighbour[i] != above) stack.push_back({neighbour[i], place});
    ++place;
  }
  return tree;
}

}  // namespace

SpanningTree spanning_tree(const Triangulation& t, std::span<const Point2> xy, const Context& context) {
  context.check();
  return walk(boruvka(candidate_edges(t, xy), t.nodes), t.nodes);
}

}  // namespace isopach
