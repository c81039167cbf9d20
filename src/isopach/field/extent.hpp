// How far places may lie from one another.
#pragma once

namespace isopach {

/// The longest side of a scan, and of whatever is set beside one: squares of it are finite doubles.
inline constexpr double max_extent = 1e60;

}  // namespace isopach
