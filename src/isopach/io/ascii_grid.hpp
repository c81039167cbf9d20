// ESRI ASCII grid: a header of names and numbers, then the heights, row by row from the north. Read here and not by
// GDAL, whose older versions refuse a grid that starts with "nan" and take memory for as many rows as the header
// promises.
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"

namespace isopach {

/// Does the file start with "ncols" or "nrows", and a number?
[[nodiscard]] bool is_ascii_grid(std::string_view head);

/// One point at the centre of each cell with data; no-data cells and cells that are not finite are counted. CRS and
/// unit from a .prj file beside it, if there is one. Throws InputError: header incomplete, fewer or more numbers than
/// cells.
[[nodiscard]] Cloud read_ascii_grid(std::span<const char> bytes, const std::string& path, const Context& context);

}  // namespace isopach
