// What the nodes of T are to objects: which object each lies in, and what its height counts in the object's volume.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/measure/changes/changes.hpp"
#include "isopach/measure/uncertainty/registration.hpp"

namespace isopach {

/// By node of T the place in changes.list of the object that it lies in, or no_index. A node at which objects touch is
/// counted to the first of them. Cost O(cells).
[[nodiscard]] Array<Index> object_of_nodes(const CellView& cells, const ChangeLevel& level, const FoundChanges& found);

/// |∂volume/∂z| by a node of T, the outline taken as it is: the integral of its hat function over the object.
struct ChangeWeight {
  Index object, node;
  double weight;
};
/// For the heights of one scan alone (see weights_at_borders), ordered by object, then by node; several of one node
/// follow one another in an order that depends on the places of the nodes alone. Objects of the list alone.
/// Cost O(n log n) in the corners of their cells. Oracle: tests/compare/changes_test.cpp (derivatives by differences).
[[nodiscard]] std::vector<ChangeWeight> weights_in_changes(const CellView& cells, const ChangeLevel& level,
                                                           const FoundChanges& found, std::size_t scan);

/// By object of the list the change of its volume by a motion of B (see registration.hpp), the outline taken as it is.
[[nodiscard]] std::vector<MotionGradient> motions_of_changes(const CellView& cells, const ChangeLevel& level,
                                                             const FoundChanges& found, const Point3& centre);

}  // namespace isopach
