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
  const Point2 &a = xy[t.v[0]], &b = xy[t.v[1]], &c = xy[t.v[2]];
  const auto length2 = [](const Point2& p, const Point2& q) {
    return (q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y);
  };
  const double l0 = length2(a, b), l1 = length2(b, c), l2 = length2(c, a);
  if (l0 == l1 || l1 == l2 || l2 == l0) {
    const Edge e0 = make_edge(xy, t.v[0], t.v[1]), e1 = make_edge(xy, t.v[1], t.v[2]),
               e2 = make_edge(xy, t.v[2], t.v[0]);
    if (e0 < e1) return e1 < e2 ? 2 : 1;
    return e0 < e2 ? 2 : 0;
  }
  const Index k = l0 < l1 ? 1 : 0;
  return (l0 < l1 ? l1 : l0) < l2 ? 2 : k;
}

// About 1.3 edges a node are left of 3. Every edge is looked at once, from its triangle of the lower id.
Array<Edge> candidate_edges(const Triangulation& t, std::span<const Point2> xy) {
  const std::size_t triangles = t.triangles.size();
  Array<std::uint8_t> longest(triangles);
  for_each_index(triangles, [&](std::size_t i) {
    longest[i] = i < t.real ? static_cast<std::uint8_t>(longest_side(t.triangles[i], xy)) : std::uint8_t{3};
  });
  const auto collect = [&](std::size_t begin, std::size_t end, Array<Edge>& edges) {
    for (std::size_t i = begin; i < end; ++i) {
      const Triangle& triangle = t.triangles[i];
      for (Index k = 0; k < 3; ++k) {
        const HalfEdge h = triangle.n[k];
        if ((triangle_of(h) < i) | (longest[i] == k) | (longest[triangle_of(h)] == side_of(h))) continue;
        if (i >= t.real && k != 0) continue;  // of a ghost only the hull edge has two nodes
        edges.push_back(make_edge(xy, triangle.v[k], triangle.v[next_side(k)]));
      }
    }
  };
  return reduce_blocks<Array<Edge>>(
      triangles, std::size_t{1} << 16,
      [&](std::size_t begin, std::size_t end) {
        Array<Edge> part;
        part.reserve((end - begin) * 3 / 4);
        collect(begin, end, part);
        return part;
      },
      [](Array<Edge>& all, const Array<Edge>& part) { all.insert(all.end(), part.begin(), part.end()); });
}

// An edge between components; `id` leads back to its nodes.
struct Link {
  double length2;
  Index id;
  Index p, q;  // components of its ends
};

// Shorter, or as long and earlier. Ids are in the order of half-edges, not of nodes, so a tie looks the nodes up.
bool shorter(const Link& l, const Link& m, const Array<Edge>& edges) {
  if (l.length2 != m.length2) return l.length2 < m.length2;
  return edges[l.id] < edges[m.id];
}

// Every component points to the one its shortest edge leads to; pairs that chose the same edge point at each other. The
// lesser of such a pair becomes the root of all that point there. Returns the number of roots; `to` becomes labels in
// the order of the roots, so that numbers stay in curve order.
Index contract(Array<Index>& to) {
  const auto n = static_cast<Index>(to.size());
  for (Index c = 0; c < n; ++c)
    if (to[to[c]] == c && c < to[c]) to[c] = c;
  for (Index c = 0; c < n; ++c) {
    Index root = c;
    while (to[root] != root) root = to[root];
    for (Index i = c; to[i] != root && i != root;) {
      const Index following = to[i];
      to[i] = root;
      i = following;
    }
  }
  Array<Index> label(n);
  Index roots = 0;
  for (Index c = 0; c < n; ++c)
    if (to[c] == c) label[c] = roots++;
  for (Index c = 0; c < n; ++c) to[c] = label[to[c]];
  return roots;
}

// Borůvka with contraction: every component takes its shortest outgoing edge, components that meet become one, edges
// whose ends have met are dropped. Each round at least halves the components, and what is left of the edges with them.
Array<Edge> boruvka(const Array<Edge>& edges, std::size_t nodes) {
  Array<Edge> tree;
  tree.reserve(nodes > 0 ? nodes - 1 : 0);
  Array<Link> links(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i)
    links[i] = {edges[i].length2, static_cast<Index>(i), edges[i].a, edges[i].b};
  auto components = static_cast<Index>(nodes);
  Array<Index> best, to;
  while (!links.empty()) {
    best.assign(components, no_index);
    for (std::size_t i = 0; i < links.size(); ++i)
      for (const Index c : {links[i].p, links[i].q})
        if (best[c] == no_index || shorter(links[i], links[best[c]], edges)) best[c] = static_cast<Index>(i);
    to.resize(components);
    for (Index c = 0; c < components; ++c) {
      const Link& l = links[best[c]];
      to[c] = l.p == c ? l.q : l.p;
      // Chosen from both ends, an edge is taken once, by the lesser.
      if (best[to[c]] != best[c] || c < to[c]) tree.push_back(edges[l.id]);
    }
    components = contract(to);
    std::size_t kept = 0;
    for (Link l : links) {
      l.p = to[l.p];
      l.q = to[l.q];
      if (l.p != l.q) links[kept++] = l;
    }
    links.resize(kept);
  }
  return tree;
}

// Depth first from node 0.
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
