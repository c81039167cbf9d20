// PLY (Stanford polygon format): ascii and binary of either byte order; any order, number and type of properties; lists
// and unknown elements are stepped over. Faces ("vertex_indices" or "vertex_index") are kept on request, polygons
// fanned. "comment unit: mm", "comment vertical_unit: m" and "comment crs: EPSG:n" set the cloud's unit and CRS.
// InputError: no x, y or z, no vertices, counts beyond the size of the file, a face that names no vertex.
// Cost: rows of fixed size are read in parallel; rows with lists one after the other. Oracle test: PlyTest.RoundTrip*.
#pragma once
#include <span>
#include <string>

#include "isopach/io/read.hpp"

namespace isopach {

[[nodiscard]] Cloud parse_ply(std::span<const char> bytes, const std::string& name, const ReadOptions& options,
                              const Context& context);

}  // namespace isopach
