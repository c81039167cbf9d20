// localise_by_interface: every node of one mesh in the triangulation of the other, by the common triangulation T
// (theorem 3 of the paper, section 4).
//
// Words. A node of T has one of two colours, or both (a shared node). An interface edge of T joins a node of the own
// colour to one that has the other. If pq is one, then q is also a neighbour of p in the Delaunay triangulation of the
// other nodes and p alone, so the segment pq runs through triangles whose circles hold p: p is looked for from q. A
// node without interface edges is looked for from its neighbours in T, once one of them is located.
//
// Either walk may have to cross a bundle of thin triangles. So that it never does where a shorter walk leads to the
// same node, walks have a budget of visited triangles: whatever settles within 8 settles first, neighbours of
// neighbours included; what is left is looked for within 16, and so on.
#pragma once
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach {

struct MutualLocations {
  Locations of_1_in_2, of_2_in_1;
};

/// Locations of the nodes of g1 in `t2` and of those of g2 in `t1`, by `t`, the triangulation of `g`: the answers of
/// `localise`, the same for any number of threads. `visited` counts every triangle seen, walks that gave up included.
/// Cost: O(n) and the walks. These are O(n) where nodes can be reached within a fixed budget (uniform nodes, the
/// paper's worst case) and O(n²) at worst; nothing that compares coordinates can do with less than O(n log n) at worst:
/// docs/method/localisation.md. Memory while it runs: 21 bytes per node of T, 16 per shared node more. Degenerate: as
/// localise. Oracle: localise, tests/overlay/localise_by_interface_test.cpp.
[[nodiscard]] MutualLocations localise_by_interface(const UnitedNodes& g, const Triangulation& t,
                                                    const Triangulation& t1, std::span<const Point2> xy1,
                                                    const Triangulation& t2, std::span<const Point2> xy2,
                                                    const Context& context);

}  // namespace isopach
