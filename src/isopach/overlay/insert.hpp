// insert: the common triangulation T by inserting the nodes of one mesh into the triangulation of the other, where each
// lies being known (docs/method/localisation.md, section 4).
//
// Words. A node is in conflict with a triangle whose circle holds it, and with a ghost if it lies beyond the hull edge,
// or on it; the triangles in conflict are its cavity, and what surrounds them its rim. [Bowyer1981], [Watson1981]: the
// triangles of the cavity give way to those that join the rim to the node. That is always two more.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach {

/// The mesh that is inserted into: `node[u]` is its node that node u of the union is, or no_index.
struct MeshToExtend {
  const Triangulation& triangulation;
  std::span<const Index> node;
};

/// The nodes that are inserted, those of another mesh: `node` likewise, and where each lies in the first.
struct NodesToInsert {
  std::span<const Index> node;
  const Locations& in_mesh;
};

struct InsertOptions {
  std::size_t nodes_at_once = std::size_t{1}
                              << 15;       ///< of the union, a task for one thread; the numbering depends on it
  std::uint64_t most_tests = 40;           ///< triangles looked at, on average for a node inserted
  std::uint64_t most_tests_of_union = 10;  ///< … for a node of the union
};

/// The Delaunay triangulation of the united nodes `xy` (ids of these), equal to triangulate(xy) triangle by triangle;
/// real triangles first, numbered along the curve: triangle 2i + j of the mesh keeps to the place 2u + j if its node i
/// is node u of the union, and node u, when inserted, brings the places 2u and 2u + 1. So nothing is allocated for a
/// node, and triangles lie in memory as their nodes lie on the curve. The numbering is another than that of
/// triangulate. The same bits for any number of threads.
/// Nothing is returned where more triangles are looked at than the options allow (uniform nodes: 11 a node inserted):
/// it is quicker then to triangulate. Cost: O(n) for the copy and O(1) expected for a node of two meshes of the same
/// ground; O(n) for a node at worst. Memory: the result and 8 bytes per node inserted. Degenerate: the mesh needs a
/// real triangle; of the nodes to be inserted nothing is asked. Oracle: triangulate, tests/overlay/insert_test.cpp.
[[nodiscard]] std::optional<Triangulation> insert(const MeshToExtend& mesh, const NodesToInsert& nodes,
                                                  std::span<const Point2> xy, const Context& context,
                                                  const InsertOptions& options = {});

}  // namespace isopach
