// Two meshes in one curve order, and the stages that are timed, each in one function: where the library replaces one,
// it is replaced here.
#pragma once
#include <string>
#include <utility>

#include "bench/support/inputs.hpp"
#include "isopach/delaunay/spanning_tree.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/geom/curve.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach::bench {

struct Mesh {
  Points xy;  ///< in curve order, no two equal
  Triangulation t;
  SpanningTree tree;
};

struct Pair {
  CurveBox box;
  Mesh a, b;
  [[nodiscard]] std::size_t nodes() const { return a.xy.size() + b.xy.size(); }
};

/// From points in any order.
[[nodiscard]] Pair make_pair_of(const Points& a, const Points& b);

/// From two clouds as a comparison sees them; `keep` of 1: all nodes, of 2, 4, …: every second, fourth, … by chance.
[[nodiscard]] Pair make_pair_of(const Cloud& a, const Cloud& b, std::uint64_t keep);

struct Located {
  Locations a_in_b, b_in_a;
};
/// Mutual localisation along the spanning trees.
[[nodiscard]] Located localise_both(const Pair& pair);
/// … along the curve, without trees.
[[nodiscard]] Located localise_in_order_both(const Pair& pair);

/// The common triangulation with its nodes.
struct Union {
  UnitedNodes g;
  Triangulation t;
};
[[nodiscard]] Union united(const Pair& pair);
/// … by the common triangulation.
[[nodiscard]] Located localise_by_interface_both(const Pair& pair, const Union& common);

/// What linear merging takes and uses up.
struct ToMerge {
  Triangulation a, b;
  Located where;
};
[[nodiscard]] ToMerge ready_to_merge(const Pair& pair);

/// The common triangulation of both meshes, by linear merging, and the list of its interface triangles.
struct Merged {
  Triangulation t;
  Array<Index> interface;
};
[[nodiscard]] Merged merge(const Pair& pair, ToMerge parts);

/// The same from scratch: node lists united along the curve, triangulated, interface triangles listed.
[[nodiscard]] Merged merge_from_scratch(const Pair& pair);

/// "right" if `merged` is the Delaunay triangulation of the union, by the exact validator, else what is wrong.
[[nodiscard]] std::string verdict_on_merge(const Pair& pair, const Triangulation& merged);

}  // namespace isopach::bench
