// What of a tile lies beyond the hull of the other scan. Internal to tiles/.
#pragma once
#include <cstdint>
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// By node, as bits, sides of the hull that it lies strictly beyond: a triangle whose corners share a bit has no place
/// in common with the hull. `hull` as of TileScan. A node beyond it may have no bit, as 64 sides at most are asked
/// about. Exact. Cost O(h + nodes log h). Oracle: all sides, tests/tiles/beyond_test.cpp.
[[nodiscard]] Array<std::uint64_t> sides_beyond(std::span<const Point2> hull, std::span<const Point2> xy);

}  // namespace isopach
