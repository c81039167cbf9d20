// Border slivers (compare/slivers.hpp) of cells in parts. Internal to tiles/.
#pragma once
#include <span>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/measure/parted_cells.hpp"

namespace isopach {

/// What is known of the cells that are in no part.
struct RestOfCells {
  const Array<unsigned char>& counted;  ///< by triangle: whether it is a cell of T
  std::vector<std::size_t> number;      ///< by node: on the curve, among all nodes of T
};

/// Sets what stages::describe_slivers does of T as a whole. Cells with long edges are kept by their nodes for it, 40 bytes
/// each. Oracle: that function.
void describe_slivers(const PartedCells& cells, const RestOfCells& rest, Comparison& c, const Context& context);

}  // namespace isopach
