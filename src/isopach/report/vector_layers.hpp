// Vector layers: lines and outlines as GeoJSON, cells for ParaView.
#pragma once
#include <string>

#include "isopach/report/report.hpp"

namespace isopach {

/// contours.geojson: the lines d = k · step in input coordinates, each a feature with its d. Errors: as contour_lines
/// of compare/contour_lines.hpp.
[[nodiscard]] std::string contours_geojson(const Comparison& c, double step, const Context& context);

/// outlines.geojson: what was compared (`domain`), and what each scan covers (`footprint_a`, `footprint_b`), each a
/// feature with its area. Footprints are of whole triangles of T.
[[nodiscard]] std::string outlines_geojson(const Comparison& c, const Context& context);

/// cells.vtu: the measured cells as an unstructured grid of VTK, on surface B in input coordinates, with d, z_a, z_b
/// and lod at their corners; binary, appended raw. Oracle: tests/cli/layers_test.py.
void write_vtu(const std::string& path, const Comparison& c, const Context& context);

}  // namespace isopach
