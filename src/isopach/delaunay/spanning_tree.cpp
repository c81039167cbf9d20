#include "isopach/delaunay/spanning_tree.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "isopach/base/parallel.hpp"

namespace isopach {

namespace {

// Total order of the edges: length, then the curve order of the ends (a function of the point set, like the length).
struct Edge {
  double length2;
  Index a, b;
  friend bool operator<(const Edge& p, const Edge& q) {
    if (p.length2 != q.length2) return p.length2 < q.length2;
    return std::minmax(p.a, p.b) < std::minmax(q.a, q.b);
  }
};

double length2(const Point2& p, const Point2& q) { return (q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y); }

// Side of a real triangle that is its longest edge: never in the tree (cycle rule).
Index longest_side(const Triangle& t, std::span<const Point2> xy) {
  Edge e[3];
  for (Index k = 0; k < 3; ++k) {
    const Index p = t.v[k], q = t.v[next_side(k)];
    e[k] = {length2(xy[p], xy[q]), p, q};
  }
  const Index k = e[0] < e[1] ? 1 : 0;
  return e[k] < e[2] ? 2 : k;
}

// Nodes of one block are neighbours on the curve and have most of their edges among themselves, in the triangles of the
// same share of the array. A block is a task for one thread, and its work fits the second-level cache.
constexpr std::size_t block_nodes = std::size_t{1} << 13, block_triangles = 2 * block_nodes;

// Edges that no triangle has for its longest side: about 1.3 a node are left of 3.
struct Candidates {
  Array<Edge> home;  // both ends in the block whose triangles they come from
  Array<Edge> away;  // all others
};

class Sweep {
 public:
  Sweep(const Triangulation& t, std::span<const Point2> xy, std::size_t block)
      : t_(t),
        xy_(xy),
        first_node_(static_cast<Index>(block * block_nodes)),
        begin_(static_cast<Index>(block * block_triangles)),
        end_(static_cast<Index>(std::min(t.triangles.size(), (block + 1) * block_triangles))) {}

  // Every edge is looked at from its later triangle, when the longest side of the earlier one is known.
  [[nodiscard]] Candidates run() {
    Candidates found;
    if (begin_ >= end_) return found;
    const Index size = end_ - begin_, real_end = std::clamp(t_.real, begin_, end_);
    longest_.resize(size);
    home_.resize(2 * std::size_t{size} + 1);
    real_triangles(real_end, found);
    for (Index i = real_end; i < end_; ++i) ghost(i, found);
    found.home.assign(home_.begin(), home_.begin() + static_cast<std::ptrdiff_t>(count_));
    return found;
  }

 private:
  // Without a branch on lengths, which nobody can predict: an edge is always written down, and counted if it counts.
  void real_triangles(Index end, Candidates& found) {
    Edge* home = home_.data();
    std::size_t count = 0;
    for (Index i = begin_; i < end; ++i) {
      const Triangle& triangle = t_.triangles[i];
      for (const Index v : t_.triangles[std::min(i + 16, end - 1)].v) __builtin_prefetch(&xy_[v]);
      const Point2 &a = xy_[triangle.v[0]], &b = xy_[triangle.v[1]], &c = xy_[triangle.v[2]];
      const double l[3] = {length2(a, b), length2(b, c), length2(c, a)};
      const double most = std::max(std::max(l[0], l[1]), l[2]);
      const unsigned is0 = l[0] == most, is1 = l[1] == most, is2 = l[2] == most;
      Index longest = is1 + 2 * is2;
      if (is0 + is1 + is2 != 1) [[unlikely]]
        longest = longest_side(triangle, xy_);
      longest_[i - begin_] = static_cast<std::uint8_t>(longest);
      for (Index k = 0; k < 3; ++k) {
        const HalfEdge h = triangle.n[k];
        const Index other = triangle_of(h), p = triangle.v[k], q = triangle.v[next_side(k)];
        home[count] = {l[k], p, q};
        if (other < begin_) [[unlikely]] {
          if (k == longest || longest_side(t_.triangles[other], xy_) == side_of(h)) continue;
          if (is_home(p) && is_home(q))
            ++count;
          else
            found.away.push_back(home[count]);
          continue;
        }
        const unsigned before = other < i;
        const Index known = std::min(other, i) - begin_;
        const unsigned counts = before & unsigned{k != longest} & unsigned{longest_[known] != side_of(h)};
        const unsigned stays = unsigned{is_home(p)} & unsigned{is_home(q)};
        if (counts > stays) [[unlikely]]
          found.away.push_back(home[count]);
        count += counts & stays;
      }
    }
    count_ = count;
  }

  [[nodiscard]] bool is_home(Index node) const { return node - first_node_ < block_nodes; }

  // Of a ghost only the hull edge has two nodes. Its other side is a real triangle, or for collinear nodes a ghost.
  void ghost(Index i, Candidates& found) {
    const Triangle& triangle = t_.triangles[i];
    const HalfEdge h = triangle.n[0];
    const Index other = triangle_of(h);
    if (other > i || (!t_.is_ghost(other) && longest_side(t_.triangles[other], xy_) == side_of(h))) return;
    const Index p = triangle.v[0], q = triangle.v[1];
    const Edge e{length2(xy_[p], xy_[q]), p, q};
    if (is_home(p) && is_home(q))
      home_[count_++] = e;
    else
      found.away.push_back(e);
  }

  const Triangulation& t_;
  std::span<const Point2> xy_;
  Index first_node_, begin_, end_;
  Array<std::uint8_t> longest_;
  Array<Edge> home_;
  std::size_t count_ = 0;
};

// An edge between components of a block, or of the whole. A component is active (a number) or settled: its shortest
// edge leaves the block. It then keeps its number, with the topmost bit set.
struct Link {
  Edge edge;
  Index p, q;
};
constexpr Index settled = ~(no_index >> 1);
constexpr Index outside = settled | settled >> 1;  // from here on: ends in other blocks, by the number of the away edge

// Borůvka with contraction: every active component takes its shortest edge, components that meet become one, links
// whose ends have met are dropped. Each round at least halves the active components. A component whose shortest edge
// leaves the block is settled, as is all that joins it (its shortest edge is the same one): links between settled ones
// are left over.
class Boruvka {
 public:
  Boruvka(Array<Link>& links, Index components) : links_(links), components_(components) {}

  // Appends the edges of the tree that lie within to `tree`, returns what is left over in `left`, settled ends.
  void run(Array<Edge>& tree, Array<Link>& left) {
    while (!links_.empty()) {
      find_shortest();
      join(tree);
      contract();
      drop(left);
    }
    settled_ += components_;
  }
  [[nodiscard]] Index settled_components() const { return settled_; }

 private:
  struct Best {
    double length2;
    Index link;
  };

  void offer(Index component, Index link, double length2) {
    Best& best = best_[component];
    if (length2 == best.length2) [[unlikely]] {
      if (best.link == no_index || links_[link].edge < links_[best.link].edge) best.link = link;
      return;
    }
    const Index shorter = -static_cast<Index>(length2 < best.length2);
    best.length2 = std::min(length2, best.length2);
    best.link = (link & shorter) | (best.link & ~shorter);
  }

  void find_shortest() {
    best_.assign(components_, {std::numeric_limits<double>::infinity(), no_index});
    for (Index i = 0; i < links_.size(); ++i) {
      const Link& l = links_[i];
      if (l.p < settled) offer(l.p, i, l.edge.length2);
      if (l.q < settled) offer(l.q, i, l.edge.length2);
    }
  }

  // Every active component points to the one its shortest edge leads to. Of two that chose the same edge, the lesser
  // becomes the root of all that point there.
  void join(Array<Edge>& tree) {
    to_.resize(components_);
    std::size_t count = tree.size();
    tree.resize(count + components_ + 1);
    for (Index c = 0; c < components_; ++c) {
      const Index chosen = best_[c].link;
      const Link& l = links_[chosen];
      const Index other = l.p ^ l.q ^ c;
      tree[count] = l.edge;
      if (other >= settled) [[unlikely]] {
        to_[c] = other >= outside ? settled + settled_++ : other;
        count += other < outside ? 1 : 0;
        continue;
      }
      const Index both = static_cast<Index>(best_[other].link == chosen), root = both & static_cast<Index>(c < other);
      to_[c] = (c & -root) | (other & ~-root);
      count += 1 - (both & static_cast<Index>(other < c));
    }
    tree.resize(count);
  }

  // Labels of the roots, in their order, so that numbers stay in curve order.
  void contract() {
    for (Index c = 0; c < components_; ++c) {
      Index root = c;
      while (root < settled && to_[root] != root) root = to_[root];
      for (Index i = c; i != root && to_[i] != root;) {
        const Index following = to_[i];
        to_[i] = root;
        i = following;
      }
    }
    label_.resize(components_);
    Index roots = 0;
    for (Index c = 0; c < components_; ++c) label_[c] = roots, roots += to_[c] == c ? 1 : 0;
    for (Index c = 0; c < components_; ++c)
      if (to_[c] < settled) to_[c] = label_[to_[c]];
    components_ = roots;
  }

  void drop(Array<Link>& left) {
    std::size_t kept = 0;
    for (Link l : links_) {
      if (l.p < settled) l.p = to_[l.p];
      if (l.q < settled) l.q = to_[l.q];
      links_[kept] = l;
      if ((l.p & l.q) >= settled) [[unlikely]] {
        if (l.p != l.q) left.push_back(l);
        continue;
      }
      kept += l.p != l.q ? 1 : 0;
    }
    links_.resize(kept);
  }

  Array<Link>& links_;
  Index components_;
  Index settled_ = 0;
  Array<Best> best_;
  Array<Index> to_, label_;
};

struct Block {
  Candidates found;
  Array<Index> away;  // those of all blocks that end here, by their number
  Array<Edge> tree;
  Array<Link> left;
  Index components = 0;  // settled
};

void contract_block(Block& block, std::size_t number, std::size_t nodes, Array<Link>& away) {
  const auto first = static_cast<Index>(number * block_nodes);
  const auto size = static_cast<Index>(std::min(block_nodes, nodes - first));
  Array<Link> links(block.found.home.size() + block.away.size());
  std::size_t count = 0;
  for (const Edge& e : block.found.home) links[count++] = {e, e.a - first, e.b - first};
  for (const Index i : block.away) {
    const Edge& e = away[i].edge;
    links[count++] = {e, e.a - first < size ? e.a - first : outside + i,
                      e.b - first < size ? e.b - first : outside + i};
  }
  block.tree.reserve(size);
  Boruvka boruvka(links, size);
  boruvka.run(block.tree, block.left);
  block.components = boruvka.settled_components();
  std::size_t kept = 0;
  for (const Link& l : block.left) {
    if (l.q >= outside)
      away[l.q - outside].p = l.p;
    else if (l.p >= outside)
      away[l.p - outside].q = l.q;
    else
      block.left[kept++] = l;
  }
  block.left.resize(kept);
}

// All away edges, in the order of the blocks they come from; every block learns which end in it.
Array<Link> deliver_away(std::vector<Block>& blocks) {
  Array<Link> away;
  for (Block& block : blocks)
    for (const Edge& e : block.found.away) {
      const auto i = static_cast<Index>(away.size());
      away.push_back({e, no_index, no_index});
      const std::size_t of_a = e.a / block_nodes, of_b = e.b / block_nodes;
      blocks[of_a].away.push_back(i);
      if (of_b != of_a) blocks[of_b].away.push_back(i);
    }
  return away;
}

// What is left of the blocks, contracted together. Appends to the tree of the last block.
void contract_rest(std::vector<Block>& blocks, const Array<Link>& away) {
  std::vector<Index> offset;
  Index components = 0;
  for (const Block& block : blocks) {
    offset.push_back(components - settled);
    components += block.components;
  }
  Array<Link> links;
  for (std::size_t k = 0; k < blocks.size(); ++k)
    for (const Link& l : blocks[k].left) links.push_back({l.edge, l.p + offset[k], l.q + offset[k]});
  for (const Link& l : away)
    if (l.p != no_index)
      links.push_back({l.edge, l.p + offset[l.edge.a / block_nodes], l.q + offset[l.edge.b / block_nodes]});
  Array<Link> none;
  Boruvka(links, components).run(blocks.back().tree, none);
}

// Depth first from node 0.
SpanningTree walk(const std::vector<Block>& blocks, std::size_t nodes) {
  Array<Index> start(nodes + 1), neighbour(2 * nodes + 3);
  std::fill(start.begin(), start.end(), 0);
  for (const Block& block : blocks)
    for (const Edge& e : block.tree) ++start[e.a], ++start[e.b];
  Index sum = 0;
  for (auto& s : start) {
    const Index count = s;
    s = sum;
    sum += count;
  }
  for (const Block& block : blocks)
    for (const Edge& e : block.tree) {
      neighbour[start[e.a]++] = e.b;
      neighbour[start[e.b]++] = e.a;
    }
  SpanningTree tree;
  tree.order.resize(nodes);
  tree.parent.resize(nodes);
  if (nodes == 0) return tree;
  // No branch on the number of neighbours: the first three are always put on the stack, and counted if they count.
  struct Waiting {
    Index node, parent;  // parent: place in the order
  };
  Array<Waiting> stack(nodes + 3);
  stack[0] = {0, no_index};
  std::size_t waiting = 1;
  for (Index place = 0; waiting > 0; ++place) {
    const auto [v, parent] = stack[--waiting];
    tree.order[place] = v;
    tree.parent[place] = parent;
    const Index above = parent == no_index ? no_index : tree.order[parent];
    const Index first = v == 0 ? 0 : start[v - 1], last = start[v];  // start[] has moved on by one place
    for (Index i = 0; i < 3; ++i) {
      const Index next = neighbour[first + i];
      stack[waiting] = {next, place};
      waiting += static_cast<std::size_t>(first + i < last) & static_cast<std::size_t>(next != above);
    }
    for (Index i = first + 3; i < last; ++i)
      if (neighbour[i] != above) stack[waiting++] = {neighbour[i], place};
  }
  return tree;
}

}  // namespace

SpanningTree spanning_tree(const Triangulation& t, std::span<const Point2> xy, const Context& context) {
  context.check();
  std::vector<Block> blocks((t.nodes + block_nodes - 1) / block_nodes);
  for_blocks(blocks.size(), 1, [&](std::size_t k, std::size_t) { blocks[k].found = Sweep(t, xy, k).run(); });
  Array<Link> away = deliver_away(blocks);
  for_blocks(blocks.size(), 1, [&](std::size_t k, std::size_t) { contract_block(blocks[k], k, t.nodes, away); });
  if (blocks.size() > 1) contract_rest(blocks, away);
  return walk(blocks, t.nodes);
}

}  // namespace isopach
