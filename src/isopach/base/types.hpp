// Index types. Arrays are indexed by 32-bit integers unless the library is built with ISOPACH_INDEX_BITS=64;
// counts of bytes and points read from files are always std::size_t or std::uint64_t.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>

namespace isopach {

#if defined(ISOPACH_INDEX_BITS) && ISOPACH_INDEX_BITS == 64
using Index = std::uint64_t;
#else
using Index = std::uint32_t;
#endif

/// "None": no node, no triangle, no point.
inline constexpr Index no_index = std::numeric_limits<Index>::max();

/// Most nodes one triangulation can hold: half-edges are coded 4·triangle + side and there are 2 triangles a node.
inline constexpr std::size_t max_nodes = static_cast<std::size_t>(no_index / 8);

}  // namespace isopach
