#include "isopach/overlay/localise_by_interface.hpp"

#include <algorithm>

#include "isopach/base/parallel.hpp"
#include "isopach/geom/predicates.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {

namespace {

constexpr std::uint64_t first_budget = 8;
constexpr std::size_t block_size = 4096;

// A half-edge of T that leaves each node: one of the interface if there is any.
Array<HalfEdge> interface_edges(const UnitedNodes& g, const Triangulation& t) {
  const std::size_t n = g.xy.size();
  Array<unsigned char> colour(n);
  for_each_index(n, [&](std::size_t u) {
    colour[u] = static_cast<unsigned char>((g.of_1[u] != no_index ? 1 : 0) | (g.of_2[u] != no_index ? 2 : 0));
  });
  Array<HalfEdge> leaving(n + 1, no_index);  // one more, to write what is not wanted (no branch to mispredict)
  const auto offer = [&](Index u, Index w, HalfEdge h) {
    const int wanted = static_cast<int>(colour[u] != colour[w]) | static_cast<int>(leaving[u] == no_index);
    leaving[wanted != 0 ? u : n] = h;
  };
  for (Index i = 0; i < t.real; ++i) {
    const auto& v = t.triangles[i].v;
    offer(v[0], v[1], half_edge(i, 0));
    offer(v[1], v[2], half_edge(i, 1));
    offer(v[2], v[0], half_edge(i, 2));
  }
  for (Index i = t.real; i < t.triangles.size(); ++i) offer(t.triangles[i].v[0], t.triangles[i].v[1], half_edge(i, 0));
  return leaving;
}

// Nodes of one colour ("own"), to be located in the mesh of the other. Own nodes go by their own ids, nodes of T by
// theirs: places.
class Search {
 public:
  Search(const UnitedNodes& g, const Triangulation& t, const Array<HalfEdge>& leaving, std::span<const Index> own,
         std::span<const Index> other, std::size_t count, const Triangulation& mesh, std::span<const Point2> xy)
      : g_(g), t_(t), leaving_(leaving), own_(own), other_(other), mesh_(mesh), xy_(xy) {
    at_node_.resize(mesh.nodes);
    for (Index i = 0; i < mesh.real; ++i)
      for (Index k = 0; k < 3; ++k) at_node_[mesh.triangles[i].v[k]] = half_edge(i, k);
    place_.resize(count + 1);
    for_each_index(own.size(), [&](std::size_t u) {
      if (own[u] != no_index) place_[own[u]] = static_cast<Index>(u);
    });
    place_.resize(count);
    result_.kind.resize(count);
    result_.id.resize(count);
    reached_.resize(count);
    level_of_.resize(count);
  }

  Locations run(const Context& context) {
    Array<Index> waiting = from_the_interface();
    aim(waiting);
    for (std::uint64_t budget = first_budget; !waiting.empty(); budget *= 2) {
      context.check();
      spread(waiting, budget);
      std::erase_if(waiting, [&](Index p) { return level_of_[p] != unsettled; });
    }
    return std::move(result_);
  }

 private:
  static constexpr Index unsettled = 0, at_once = 1, attempted = no_index;  // levels
  static bool is_settled(Index level) { return level != unsettled && level != attempted; }

  struct Found {
    Location location;
    Index at = no_index;
    std::uint64_t visited = 0;
    explicit operator bool() const { return location.kind != Location::Kind::none; }
  };
  void walk(Index p, Index from, std::uint64_t budget, Found& found) const {
    found.at = from;
    found.location = locate(g_.xy[place_[p]], mesh_, xy_, found.at, found.visited, found.visited + budget);
  }
  void settle(Index p, const Found& found, Index level) {
    result_.kind[p] = found.location.kind;
    result_.id[p] = found.location.id;
    reached_[p] = found.at;
    level_of_[p] = level;
  }

  // The own node at a node of T (which may be none: ghosts have such), or no_index.
  [[nodiscard]] Index own_at(Index place) const { return place == no_index ? no_index : own_[place]; }
  // The node of the mesh that own node p has its interface edge to, or no_index.
  [[nodiscard]] Index partner(Index p) const { return other_[t_.target(leaving_[place_[p]])]; }

  /// f(id) for every own node next to own node p in T.
  template <class F>
  void for_neighbours(Index p, F&& f) const {
    const HalfEdge first = leaving_[place_[p]];
    HalfEdge h = first;
    do {
      const Index neighbour = own_at(t_.target(h));
      if (neighbour != no_index) f(neighbour);
      h = t_.next_leaving(h);
    } while (h != first);
  }

  // Shared nodes are located at once, nodes with an interface edge from its other end. Returns the rest.
  Array<Index> from_the_interface() {
    struct Part {
      Array<Index> waiting;
      std::uint64_t visited = 0;
    };
    Part all = reduce_blocks<Part>(
        place_.size(), block_size,
        [&](std::size_t begin, std::size_t end) {
          // Where to start, for all of a block first: reads far apart that wait for nothing but memory.
          for (auto p = static_cast<Index>(begin); p < end; ++p) {
            const Index shared = other_[place_[p]];
            const Index q = shared != no_index ? shared : partner(p);
            reached_[p] = q != no_index ? triangle_of(at_node_[q]) : no_index;
            result_.id[p] = shared;
          }
          Part part;
          for (auto p = static_cast<Index>(begin); p < end; ++p) {
            Found found;
            if (result_.id[p] != no_index)
              found = {{Location::Kind::node, result_.id[p]}, reached_[p], 0};
            else if (reached_[p] != no_index)
              walk(p, reached_[p], first_budget, found);
            part.visited += found.visited;
            settle(p, found, found ? at_once : unsettled);
            if (!found) part.waiting.push_back(p);
          }
          return part;
        },
        [](Part& total, const Part& part) {
          total.waiting.insert(total.waiting.end(), part.waiting.begin(), part.waiting.end());
          total.visited += part.visited;
        });
    result_.visited = all.visited;
    return std::move(all.waiting);
  }

  // Where a waiting node p with an interface edge pq is to be looked for: in the triangle at q in the direction of p.
  // All nodes p of one q in one turn around it, in T and in the mesh alike, so that a node of high degree is turned
  // around twice and not once for every p.
  void aim(const Array<Index>& waiting) {
    for (const Index p : waiting) reached_[p] = no_index;
    for (const Index p : waiting) {
      const Index q = partner(p);
      if (q == no_index || reached_[p] != no_index) continue;
      HalfEdge e = at_node_[q];
      const HalfEdge first = t_.twin(leaving_[place_[p]]);
      HalfEdge h = first;
      do {
        const Index turned = own_at(t_.target(h));
        if (turned != no_index && level_of_[turned] == unsettled && partner(turned) == q) {
          for (; !leads_to(e, g_.xy[place_[turned]]); e = mesh_.next_leaving(e)) ++result_.visited;
          reached_[turned] = triangle_of(e);
        }
        h = t_.next_leaving(h);
      } while (h != first);
    }
  }

  // Whether the wedge that the half-edge's triangle has at its origin holds the direction of p; of a ghost: whether p
  // is not strictly inside its hull edge.
  [[nodiscard]] bool leads_to(HalfEdge e, const Point2& p) const {
    const auto& v = mesh_.triangles[triangle_of(e)].v;
    if (mesh_.is_ghost(triangle_of(e))) return orientation(xy_[v[1]], xy_[v[0]], p) <= 0;
    const Point2& q = xy_[v[side_of(e)]];
    return orientation(q, xy_[v[next_side(side_of(e))]], p) >= 0 &&
           orientation(q, xy_[v[previous_side(side_of(e))]], p) < 0;
  }

  // Settles what walks within the budget can reach along the edges of T: first all that waits next to what is settled,
  // then, level by level, all that waits next to what has just settled.
  void spread(const Array<Index>& waiting, std::uint64_t budget) {
    Array<Attempt> attempts = first_attempts(waiting);
    for (bool first = true; !attempts.empty(); first = false) {
      Array<Found> found(attempts.size());
      for_blocks(attempts.size(), block_size / 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) found[i] = attempt(attempts[i], first, budget);
      });
      ++level_;
      Array<Index> settled;
      for (std::size_t i = 0; i < attempts.size(); ++i) {
        result_.visited += found[i].visited;
        level_of_[attempts[i].node] = unsettled;
        if (!found[i]) continue;
        settle(attempts[i].node, found[i], level_);
        settled.push_back(attempts[i].node);
      }
      attempts.clear();
      propose_neighbours(settled, attempts);
    }
  }

  struct Attempt {
    Index node, from;  // from: triangle of the mesh, or no_index to ask the neighbours at once
  };

  // All that waits, or, if that is most nodes, those of them that are next to a settled one.
  Array<Attempt> first_attempts(const Array<Index>& waiting) {
    Array<Attempt> attempts;
    const bool few = waiting.size() < place_.size() / 2;
    for (const Index p : waiting)
      if (few || reached_[p] != no_index) {
        attempts.push_back({p, reached_[p]});
        level_of_[p] = attempted;
      }
    if (few) return attempts;
    Array<Index> settled;
    for (Index p = 0; p < place_.size(); ++p)
      if (is_settled(level_of_[p])) settled.push_back(p);
    propose_neighbours(settled, attempts);
    return attempts;
  }

  void propose_neighbours(const Array<Index>& settled, Array<Attempt>& attempts) {
    for (const Index p : settled)
      for_neighbours(p, [&](Index neighbour) {
        if (level_of_[neighbour] != unsettled) return;
        attempts.push_back({neighbour, reached_[p]});
        level_of_[neighbour] = attempted;
      });
  }

  // Where the proposed walk is too long, those from all the other neighbours, or all that settled in the last level.
  [[nodiscard]] Found attempt(const Attempt& proposed, bool everyone, std::uint64_t budget) const {
    Found found;
    if (proposed.from != no_index) walk(proposed.node, proposed.from, budget, found);
    if (found) return found;
    for_neighbours(proposed.node, [&](Index neighbour) {
      const Index level = level_of_[neighbour], from = reached_[neighbour];
      if (!found && is_settled(level) && (everyone || level == level_) && from != proposed.from)
        walk(proposed.node, from, budget, found);
    });
    return found;
  }

  const UnitedNodes& g_;
  const Triangulation& t_;
  const Array<HalfEdge>& leaving_;      // of T, by place
  std::span<const Index> own_, other_;  // by place
  const Triangulation& mesh_;
  std::span<const Point2> xy_;  // nodes of the mesh
  Array<HalfEdge> at_node_;     // of the mesh, from each of its nodes
  Array<Index> place_;          // of each own node
  Array<Index> reached_;        // triangle of the mesh where a node was found; until then: where to look for it
  Array<Index> level_of_;       // in which a node was found
  Index level_ = at_once;
  Locations result_;
};

}  // namespace

MutualLocations localise_by_interface(const UnitedNodes& g, const Triangulation& t, const Triangulation& t1,
                                      std::span<const Point2> xy1, const Triangulation& t2, std::span<const Point2> xy2,
                                      const Context& context) {
  context.check();
  Array<HalfEdge> leaving;
  if (t.real > 0) leaving = interface_edges(g, t);
  context.check();
  MutualLocations found;
  // A mesh without triangles is no place to walk in.
  both(
      [&] {
        found.of_1_in_2 = t2.real == 0 ? localise_in_order(xy1, t2, xy2, context)
                                       : Search(g, t, leaving, g.of_1, g.of_2, xy1.size(), t2, xy2).run(context);
      },
      [&] {
        found.of_2_in_1 = t1.real == 0 ? localise_in_order(xy2, t1, xy1, context)
                                       : Search(g, t, leaving, g.of_2, g.of_1, xy2.size(), t1, xy1).run(context);
      });
  return found;
}

}  // namespace isopach
