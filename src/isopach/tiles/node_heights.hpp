// The height of the other surface at the nodes of a tile: what the tile knows, and what the join found.
#pragma once
#include <cstddef>
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/measure/parted_cells.hpp"
#include "isopach/tiles/part.hpp"

namespace isopach {

/// Of scan k. `nodes`: all nodes of the scan in the tile, as project_part gives them; `joined`: heights of those that
/// were passed up (HeightsOfOther). NaN where there is no difference, else as interpolate() of the whole, to the last
/// bit. Shorter than `nodes` where part, cells and nodes are not of one tile. Cost O(nodes of T of the tile). Oracle:
/// compare(), tests/tiles/join_test.cpp.
[[nodiscard]] Array<double> node_heights(std::size_t k, std::span<const Point2> nodes, const CellPart& cells,
                                         const ScanPart& part, std::span<const double> joined);

}  // namespace isopach
