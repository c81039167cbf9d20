// T from the survivors of T1 and T2 and the interface triangles, in the order of the curve: node after node of the
// union, of each mesh the two triangles numbered by it, and in place of a dead one the interface triangles that lean on
// its sides. So the numbering depends on no thread and no contour.
#include <numeric>
#include <stdexcept>

#include "isopach/base/parallel.hpp"
#include "isopach/overlay/seam.hpp"

namespace isopach::seam {

namespace {

constexpr std::size_t nodes_at_once = std::size_t{1} << 12;

// The half-edge k sides after h in its triangle.
constexpr HalfEdge turned_by(HalfEdge h, Index k) {
  const Index side = side_of(h) + k;
  return half_edge(triangle_of(h), side >= 3 ? side - 3 : side);
}

class Sewing {
 public:
  Sewing(const Seam& s, Index nodes) : s_(s) {
    for (const int c : {0, 1}) survivor_[c].resize(s.mesh[c].triangles.size());
    leaning_.resize(s.records.size());
    result_.nodes = nodes;
    result_.triangles.resize(2 * static_cast<std::size_t>(nodes) - 2);
  }

  Triangulation run() {
    const Array<Index> start = count();
    for_blocks(result_.nodes, nodes_at_once, [&](std::size_t begin, std::size_t end) {
      const std::size_t block = begin / nodes_at_once;
      number_block(begin, end, start[block], start[block + 1]);
    });
    number_outside(start.back());
    for_blocks(result_.triangles.size(), 2 * nodes_at_once, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) write(result_.triangles[i]);
    });
    return std::move(result_);
  }

 private:
  // A triangle of T before it is written: what it is made of, kept in its own place. v[0] is the mesh, v[1] a half-edge
  // of it, v[2] the tag of the interface triangle that leans there, or no_index for a survivor; n[0] is side v[1] in T.
  static Triangle item(int c, HalfEdge h, Index tag) {
    return {{static_cast<Index>(c), h, tag}, {no_index, no_index, no_index}};
  }
  static constexpr Index survivor_tag = no_index;

  [[nodiscard]] bool is_dead(int c, Index t) const {
    const auto& v = s_.mesh[c].triangles[t].v;
    const bool turned = ((v[0] | v[1] | (v[2] == no_index ? 0 : v[2])) & turned_bit) != 0;
    return turned || s_.state(c, t) == State::dead;
  }
  [[nodiscard]] bool is_copy(int c, Index t) const { return c == 1 && s_.state(c, t) == State::twice; }
  [[nodiscard]] bool has_lean(Index link) const { return is_tag(link) && !s_.is_proxy(link); }

  template <class F>
  void for_each_numbered(std::size_t begin, std::size_t end, F&& f) const {
    for (std::size_t u = begin; u < end; ++u)
      for (const int c : {0, 1}) {
        const Index node = s_.mesh[c].own[u];
        if (node == no_index) continue;
        for (Index t = 2 * node; t < 2 * node + 2 && t < s_.mesh[c].real; ++t) f(c, t);
      }
  }

  // Triangles of T that each block of nodes will number, as places where blocks start.
  Array<Index> count() const {
    const std::size_t nodes = result_.nodes, blocks = (nodes + nodes_at_once - 1) / nodes_at_once;
    Array<Index> start(blocks + 1);
    start[0] = 0;
    for_blocks(nodes, nodes_at_once, [&](std::size_t begin, std::size_t end) {
      Index sum = 0;
      for_each_numbered(begin, end, [&](int c, Index t) {
        const auto& n = s_.mesh[c].triangles[t].n;
        const Index leaning = (has_lean(n[0]) ? 1U : 0U) + (has_lean(n[1]) ? 1U : 0U) + (has_lean(n[2]) ? 1U : 0U);
        sum += is_dead(c, t) ? leaning : (is_copy(c, t) ? 0U : 1U);
      });
      start[begin / nodes_at_once + 1] = sum;
    });
    std::partial_sum(start.begin(), start.end(), start.begin());
    if (start.back() > result_.triangles.size()) throw std::logic_error(wrong_count);
    return start;
  }

  void number_block(std::size_t begin, std::size_t end, Index place, Index place_end) {
    // Every triangle is offered four places without asking and takes as many as it needs: a guess that the processor
    // would make wrong half the time costs more than a store.
    Triangle spare;
    Index next = place;
    const auto put = [&](int c, HalfEdge h, Index tag, bool take) {
      (next < place_end ? result_.triangles[next] : spare) = item(c, h, tag);
      next += take ? 1 : 0;
    };
    for_each_numbered(begin, end, [&](int c, Index t) {
      const auto& n = s_.mesh[c].triangles[t].n;
      const bool dead = is_dead(c, t), survives = !dead && !is_copy(c, t);
      if (!is_copy(c, t)) survivor_[c][t] = no_index;  // until a survivor is numbered
      put(c, half_edge(t, 0), survivor_tag, survives);
      for (Index k = 0; k < 3; ++k) put(c, half_edge(t, k), n[k], dead && has_lean(n[k]));
    });
    for (Index i = place; i < place_end; ++i) number(i, 0);
  }

  // Writes where the item at place i went; `side` is that of its half-edge in T.
  void number(Index i, Index side) {
    Triangle& it = result_.triangles[i];
    const int c = static_cast<int>(it.v[0]);
    const HalfEdge place = half_edge(i, side);
    it.n[0] = place;
    if (it.v[2] != survivor_tag) {
      const Index record = record_of(it.v[2]), next = s_.records[record].across[1];
      leaning_[record] = place;
      if (is_tag(next)) leaning_[record_of(next)] = turned_by(place, 2);
      return;
    }
    const Index t = triangle_of(it.v[1]);
    survivor_[c][t] = place;
    if (s_.state(c, t) != State::twice) return;
    const HalfEdge copy = s_.find(1, s_.united(0, s_.origin(0, it.v[1])), s_.united(0, s_.target(0, it.v[1])));
    survivor_[1][triangle_of(copy)] = turned_by(place, side_of(copy) == 0 ? 0 : 3 - side_of(copy));
  }

  // Real interface triangles that lean on sides of dead ghosts, then ghosts.
  void number_outside(Index next) {
    std::vector<Triangle> hull;
    const auto append = [&](const Triangle& it, Index side) {
      if (next == result_.triangles.size()) throw std::logic_error(wrong_count);
      result_.triangles[next] = it;
      number(next++, side);
    };
    for (const int c : {0, 1})
      for (Index g = s_.mesh[c].real; g < s_.mesh[c].triangles.size(); ++g) {
        if (!is_dead(c, g)) {
          if (!is_copy(c, g)) hull.push_back(item(c, half_edge(g, 0), survivor_tag));
          continue;
        }
        survivor_[c][g] = no_index;
        const auto& n = s_.mesh[c].triangles[g].n;
        if (has_lean(n[0])) append(item(c, half_edge(g, 0), n[0]), 0);
        // An interface ghost leans on the half-edge that starts at the infinite node, the third of every ghost.
        if (has_lean(n[2])) hull.push_back(item(c, half_edge(g, 2), n[2]));
      }
    result_.real = next;
    for (const Triangle& it : hull) append(it, it.v[2] == survivor_tag ? 0 : 2);
    if (next != result_.triangles.size()) throw std::logic_error(wrong_count);
  }

  // Where the half-edge h of mesh c went, seen from a triangle of T on its other side.
  [[nodiscard]] HalfEdge place_of(int c, HalfEdge h) const {
    if (const HalfEdge place = survivor_[c][triangle_of(h)]; place != no_index) return turned_by(place, side_of(h));
    const Index link = s_.mesh[c].triangles[triangle_of(h)].n[side_of(h)];
    if (is_tag(link)) return leaning_[record_of(link)];
    // Both its ends are shared, and the triangle of T is one of the other mesh.
    const HalfEdge other = s_.find(1 - c, s_.united(c, s_.origin(c, h)), s_.united(c, s_.target(c, h)));
    return turned_by(survivor_[1 - c][triangle_of(other)], side_of(other));
  }
  [[nodiscard]] HalfEdge place_of_side(HalfEdge code) const {
    return turned_by(leaning_[record_of(code)], side_of(code));
  }

  void write(Triangle& to) const {
    const int c = static_cast<int>(to.v[0]);
    const HalfEdge h = to.v[1];
    const Index tag = to.v[2];
    if (tag == survivor_tag) {
      const Triangle& from = s_.mesh[c].triangles[triangle_of(h)];
      for (Index k = 0; k < 3; ++k) {
        to.v[k] = s_.united(c, node_at(from.v[k]));
        to.n[k] = place_of(c, from.n[k]);
      }
      return;
    }
    const Record& record = s_.records[record_of(tag)];
    const Index first = side_of(to.n[0]), second = next_side(first), third = previous_side(first);
    to.v[first] = s_.united(c, s_.origin(c, h));
    to.v[second] = s_.united(c, s_.target(c, h));
    to.v[third] = s_.united(1 - c, record.apex);
    to.n[first] = place_of(c, record.twin);
    to.n[second] = place_of_side(record.across[0]);
    to.n[third] = is_tag(record.across[1]) ? place_of(1 - c, s_.records[record_of(record.across[1])].twin)
                                           : place_of_side(record.across[1]);
  }

  static constexpr const char* wrong_count = "merge: not as many triangles as a triangulation has";
  const Seam& s_;
  std::array<Array<HalfEdge>, 2> survivor_;  // by triangle of a mesh: its side 0 in T; no_index for a dead one
  Array<HalfEdge> leaning_;                  // by record: its leaning side in T
  Triangulation result_;
};

}  // namespace

Triangulation sew(const Seam& s, Index nodes) { return Sewing(s, nodes).run(); }

}  // namespace isopach::seam
