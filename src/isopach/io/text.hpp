// Text files of points, one a line: XYZ, CSV, TXT, PTS and PTX.
//   separators   blanks, tab, comma or semicolon (with tab or semicolon also decimal commas), taken from the first data
//   line header       a line of names (any case, quoted or not) with x, y, z in any order, or e.g. easting, northing,
//   height;
//                CloudCompare's "//X Y Z ..." too. Without one the first three columns are x, y, z; others are
//                column_4, ...
//   comments     lines starting with # % ! or //, and blank lines
//   PTS          a first line with the number of points; columns 4.. are intensity, red, green, blue
//   PTX          scans one after the other, each with its own pose, which is applied; (0, 0, 0) marks "no return"
// A line that does not parse is an InputError with the number of the line; so is a file without points.
// Numbers are read to the nearest double. Cost: two parallel passes. Oracle test: TextTest.RoundTrip*.
#pragma once
#include <span>
#include <string>

#include "isopach/io/read.hpp"

namespace isopach {

[[nodiscard]] Cloud parse_text(std::span<const char> bytes, const std::string& name, const ReadOptions& options,
                               const Context& context);

/// True if the text starts as a PTX scan does: two counts, four rows of three numbers, four rows of four.
[[nodiscard]] bool is_ptx(std::span<const char> bytes);

}  // namespace isopach
