// T from the survivors of T1 and T2 and the interface triangles, in the order of the curve: node after node of the
// union, of each mesh the two triangles numbered by it, and in place of a dead one the interface triangles that lean on
// its sides. So the numbering depends on no thread and no contour.
#include <numeric>
#include <stdexcept>

#include "isopach/base/parallel.hpp"
#include "isopach/overlay/seam.hpp"

namespace isopach::seam {

namespace {

constexpr std::size_t nodes_at_once = std::size_t{1} << 14;

// The half-edge k sides after h in its triangle.
constexpr HalfEdge turned_by(HalfEdge h, Index k) { return half_edge(triangle_of(h), (side_of(h) + k) % 3); }

class Sewing {
 public:
  explicit Sewing(const Seam& s) : s_(s) {
    for (const int c : {0, 1}) survivor_[c].resize(s.mesh[c].triangles.size());
    leaning_.resize(s.records.size());
  }

  Triangulation run(Index nodes) {
    const Array<Index> start = number_all();
    if (hull_.size() + result_.real != 2 * static_cast<std::size_t>(nodes) - 2)
      throw std::logic_error("merge: not as many triangles as a triangulation has");
    result_.nodes = nodes;
    result_.triangles.resize(2 * static_cast<std::size_t>(nodes) - 2);
    for_blocks(nodes, nodes_at_once, [&](std::size_t begin, std::size_t end) {
      for_each_numbered(begin, end, [&](const Item& item) { write(item); });
    });
    for (const Item& item : outside_) write(item);
    for (const Item& item : hull_) write(item);
    return std::move(result_);
  }

 private:
  // A triangle of T: a survivor (`tag` is no_index), or the interface triangle that leans on half-edge `h` of mesh c.
  struct Item {
    int c;
    HalfEdge h;
    Index tag;
  };

  [[nodiscard]] bool survives(int c, Index t) const { return !s_.is_dead(c, t); }

  template <class F>
  void for_each_at(int c, Index t, F&& f) const {
    if (survives(c, t)) {
      if (c == 0 || s_.state(c, t) != State::twice) f(Item{c, half_edge(t, 0), no_index});
      return;
    }
    for (Index k = 0; k < 3; ++k) {
      const HalfEdge h = half_edge(t, k);
      const Index link = s_.mesh[c].triangles[t].n[k];
      if (is_tag(link) && !s_.is_proxy(link)) f(Item{c, h, link});
    }
  }

  template <class F>
  void for_each_numbered(std::size_t begin, std::size_t end, F&& f) const {
    for (std::size_t u = begin; u < end; ++u)
      for (const int c : {0, 1}) {
        const Index node = s_.mesh[c].own[u];
        if (node == no_index) continue;
        for (Index t = 2 * node; t < 2 * node + 2 && t < s_.mesh[c].real; ++t) for_each_at(c, t, f);
      }
  }

  void number(const Item& item, HalfEdge place) {
    if (item.tag != no_index) {
      const Record& record = s_.records[record_of(item.tag)];
      leaning_[record_of(item.tag)] = place;
      if (is_tag(record.across[1])) leaning_[record_of(record.across[1])] = turned_by(place, 2);
      return;
    }
    const Index t = triangle_of(item.h);
    survivor_[item.c][t] = place;
    if (s_.state(item.c, t) != State::twice) return;
    const HalfEdge copy = s_.find(1, s_.united(0, s_.origin(0, item.h)), s_.united(0, s_.target(0, item.h)));
    survivor_[1][triangle_of(copy)] = turned_by(place, 3 - side_of(copy));
  }

  // Gives every triangle of T its number.
  Array<Index> number_all() {
    const std::size_t nodes = s_.mesh[0].own.size(), blocks = (nodes + nodes_at_once - 1) / nodes_at_once;
    Array<Index> start(blocks + 1);
    start[0] = 0;
    for_blocks(nodes, nodes_at_once, [&](std::size_t begin, std::size_t end) {
      Index count = 0;
      for_each_numbered(begin, end, [&](const Item&) { ++count; });
      start[begin / nodes_at_once + 1] = count;
    });
    std::partial_sum(start.begin(), start.end(), start.begin());
    for (const int c : {0, 1})
      for_each_index(s_.mesh[c].triangles.size(), [&](std::size_t t) {
        if (!survives(c, static_cast<Index>(t))) survivor_[c][t] = no_index;
      });
    for_blocks(nodes, nodes_at_once, [&](std::size_t begin, std::size_t end) {
      Index next = start[begin / nodes_at_once];
      for_each_numbered(begin, end, [&](const Item& item) { number(item, half_edge(next++, 0)); });
    });
    gather_outside();
    Index next = start.back();
    for (const Item& item : outside_) number(item, half_edge(next++, 0));
    result_.real = next;
    // A ghost's infinite node is its third: an interface ghost leans on the half-edge that starts there.
    for (const Item& item : hull_) number(item, half_edge(next++, item.tag == no_index ? 0 : 2));
    return start;
  }

  // Ghosts, and real interface triangles that lean on sides of dead ghosts.
  void gather_outside() {
    for (const int c : {0, 1})
      for (Index g = s_.mesh[c].real; g < s_.mesh[c].triangles.size(); ++g)
        for_each_at(c, g, [&](const Item& item) {
          (item.tag == no_index || side_of(item.h) == 2 ? hull_ : outside_).push_back(item);
        });
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

  void write(const Item& item) {
    const int c = item.c;
    const Triangle& from = s_.mesh[c].triangles[triangle_of(item.h)];
    if (item.tag == no_index) {
      Triangle& to = result_.triangles[triangle_of(survivor_[c][triangle_of(item.h)])];
      for (Index k = 0; k < 3; ++k) {
        to.v[k] = s_.united(c, from.v[k]);
        to.n[k] = place_of(c, from.n[k]);
      }
      return;
    }
    const Record& record = s_.records[record_of(item.tag)];
    const HalfEdge place = leaning_[record_of(item.tag)];
    Triangle& to = result_.triangles[triangle_of(place)];
    const Index first = side_of(place), second = next_side(first), third = previous_side(first);
    to.v[first] = s_.united(c, s_.origin(c, item.h));
    to.v[second] = s_.united(c, s_.target(c, item.h));
    to.v[third] = s_.united(1 - c, record.apex);
    to.n[first] = place_of(c, record.twin);
    to.n[second] = place_of_side(record.across[0]);
    to.n[third] = is_tag(record.across[1]) ? place_of(1 - c, s_.records[record_of(record.across[1])].twin)
                                           : place_of_side(record.across[1]);
  }

  const Seam& s_;
  std::array<Array<HalfEdge>, 2> survivor_;  // by triangle of a mesh: its side 0 in T; no_index for a dead one
  Array<HalfEdge> leaning_;                  // by record: its leaning side in T
  std::vector<Item> outside_, hull_;
  Triangulation result_;
};

}  // namespace

Triangulation sew(const Seam& s, Index nodes) { return Sewing(s).run(nodes); }

}  // namespace isopach::seam
