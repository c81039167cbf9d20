// What a map and a page say of themselves: coordinate system, date, author.
#pragma once
#include <string>

#include "isopach/report/report.hpp"

namespace isopach {

/// Whether y is north: x and y are those of the input, and it has a coordinate system or coordinates as large as those
/// of national grids, in metres or feet.
[[nodiscard]] bool is_map(const Comparison& c);

/// A coordinate system as people read it: its code, of well-known text its name. "" for none.
[[nodiscard]] std::string crs_name(const std::string& crs);

/// Coordinate system, author, date, with `separator` between: what is known of them. Of a map without a coordinate
/// system, that it has none.
[[nodiscard]] std::string signature(const Comparison& c, const MapOptions& look, const std::string& separator);

}  // namespace isopach
