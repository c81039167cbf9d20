// The octree of a COPC file (copc.io, specification 1.0): which chunks of its points may lie in a box.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/io/laz.hpp"
#include "isopach/io/point_blocks.hpp"

namespace isopach {

/// Is it a COPC file: layered chunks, and a record "copc" of information?
[[nodiscard]] bool is_copc(const LasFile& file);

/// The chunks, in the order of the file, of all nodes whose cube meets the box in x and y. The cubes are those of the
/// octree, not the bounds in the header, and are grown by a step of the scale and the rounding of doubles: a point is
/// sorted in before it is rounded to the scale. Nothing if the index does not name exactly the chunks that the file
/// has, one behind the other and with all its points: then nobody knows what is where, and all have to be read. Cost:
/// the whole index is read, 32 bytes a node. Oracle: CopcTest.*
[[nodiscard]] std::optional<std::vector<LazChunk>> copc_chunks(const LasFile& file, const PlanBox& box);

}  // namespace isopach
