// Level of detection and changes (compare/changes.hpp) of cells in parts. Internal to tiles/.
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/measure/parted_cells.hpp"
#include "isopach/tiles/parted_slivers.hpp"

namespace isopach {

/// Sets what stages::Noise::describe does where options.uncertainty gives the level of detection and nothing else.
void describe_level(const PartedCells& cells, Comparison& c, const Context& context);

/// Sets what stages::describe_changes does of T as a whole, of c.compared_points among others. Cells in which |d|
/// exceeds the level somewhere are made one mesh, in which the sides that they share join them again: no other cell is
/// in an object, or beside a side of one. InputError where they need more memory than there is. Cost: two looks at the
/// cells of parts and one at their nodes; memory grows with the cells that changed. Oracle: compare(),
/// tests/tiles/join_test.cpp.
void describe_changes(const PartedCells& cells, const RestOfCells& rest, Comparison& c, const Context& context);

}  // namespace isopach
