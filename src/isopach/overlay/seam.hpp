// Seam: the state of a merge, shared by its two halves: contours.cpp (make the interface triangles) and sew.cpp (write
// T). Internal to overlay/merge.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach::seam {

// What a half-edge of a dead triangle leads to is its twin until an interface triangle leans on it; then it is a tag,
// the id of that triangle's record with the side 3 that no half-edge has. So the tag is where a contour looks anyway,
// and a side is a side of T exactly if it is tagged.
[[nodiscard]] constexpr bool is_tag(Index link) { return side_of(link) == 3; }
[[nodiscard]] constexpr Index tag(Index record) { return half_edge(record, 3); }
[[nodiscard]] constexpr Index record_of(Index link) { return triangle_of(link); }

// An interface triangle (o, d, apex) that leans on the half-edge o→d of a dead triangle. Side 0 is the leaning one.
struct Record {
  HalfEdge twin;  // what the tag replaced: the half-edge on the other side of the leaning one
  Index apex;     // node of the other colour
  // Across sides 1 (d→apex) and 2 (apex→o): 4·record + side. Where a contour ends, o is shared and side 2 leans on
  // the other triangulation: then across[1] is the tag of a second record, a proxy that holds that twin alone.
  std::array<Index, 2> across;
};

// A contour that turns through a corner of a triangle sets this bit of the node there: the triangle is dead then.
// (Half- edges leave it free: there are at most max_nodes nodes. The infinite node never has it: nothing turns around
// it.)
inline constexpr Index turned_bit = ~(no_index >> 1);
[[nodiscard]] constexpr Index node_at(Index v) { return v == no_index ? no_index : v & ~turned_bit; }
[[nodiscard]] constexpr bool is_turned(Index v) { return v != no_index && (v & turned_bit) != 0; }

// Triangles without a pure corner: no contour turns through them.
enum class State : std::uint8_t { unknown, dead, twice };  // twice: in T1 and in T2, so in T

struct Mesh {
  Array<Triangle> triangles;
  Index real = 0;
  std::span<const Point2> xy;
  const Locations* in_other = nullptr;
  Array<Index> united;         // ids in the union
  std::span<const Index> own;  // of the united nodes: the node of this mesh, or no_index
  // Only if there are shared nodes:
  Array<State> state;       // by triangle
  Array<HalfEdge> leaving;  // by node: a half-edge that starts there
};

struct Seam {
  std::array<Mesh, 2> mesh;
  Array<Record> records;  // of interface triangles up to first_proxy, of proxies up to `proxies`
  Index first_proxy = 0, proxies = 0;
  bool any_shared = false;

  [[nodiscard]] bool is_pure(int c, Index node) const {
    if (node == no_index) return false;
    return !any_shared || mesh[1 - c].own[mesh[c].united[node]] == no_index;
  }
  [[nodiscard]] bool is_proxy(Index link) const { return record_of(link) >= first_proxy; }
  // Union id; the infinite node keeps no_index.
  [[nodiscard]] Index united(int c, Index node) const { return node == no_index ? no_index : mesh[c].united[node]; }
  // Whether two nodes, one of each mesh, are one.
  [[nodiscard]] bool is_same(int c, Index node, Index other) const {
    if (node == no_index || other == no_index) return node == other;
    return any_shared && mesh[c].united[node] == mesh[1 - c].united[other];
  }
  [[nodiscard]] Index at(int c, Index t, Index k) const { return node_at(read_shared(mesh[c].triangles[t].v[k])); }
  [[nodiscard]] Index origin(int c, HalfEdge h) const { return at(c, triangle_of(h), side_of(h)); }
  [[nodiscard]] Index target(int c, HalfEdge h) const { return at(c, triangle_of(h), next_side(side_of(h))); }
  [[nodiscard]] Index apex(int c, HalfEdge h) const { return at(c, triangle_of(h), previous_side(side_of(h))); }
  [[nodiscard]] Index link(int c, HalfEdge h) const {  // twin or tag
    return read_shared(mesh[c].triangles[triangle_of(h)].n[side_of(h)]);
  }
  [[nodiscard]] HalfEdge twin(int c, HalfEdge h) const {
    const Index l = link(c, h);
    return is_tag(l) ? records[record_of(l)].twin : l;
  }
  [[nodiscard]] HalfEdge next_leaving(int c, HalfEdge h) const {
    return twin(c, half_edge(triangle_of(h), previous_side(side_of(h))));
  }
  [[nodiscard]] bool turned(int c, Index t, Index k) const { return is_turned(read_shared(mesh[c].triangles[t].v[k])); }
  [[nodiscard]] State state(int c, Index t) const { return any_shared ? mesh[c].state[t] : State::unknown; }
  [[nodiscard]] bool is_dead(int c, Index t) const {
    return turned(c, t, 0) || turned(c, t, 1) || turned(c, t, 2) || state(c, t) == State::dead;
  }

  // The half-edge between the nodes of mesh `c` that are the united nodes a and b (at most one of them infinite), or
  // no_index. Cost: the degree of the finite one.
  [[nodiscard]] HalfEdge find(int c, Index a, Index b) const;
};

/// Makes every interface triangle.
void trace_contours(Seam& s);

/// T from the survivors and the interface triangles.
[[nodiscard]] Triangulation sew(const Seam& s, Index nodes);

}  // namespace isopach::seam
