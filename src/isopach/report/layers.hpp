// Layers for maps: rasters of what was compared, and how QGIS shows them.
#pragma once
#include <string>

#include "isopach/io/raster_layers.hpp"
#include "isopach/measure/parted_cells.hpp"
#include "isopach/report/report.hpp"

namespace isopach {

/// Layers are in x and y: UsageError naming `option` for another direction than z.
void require_map_direction(const ProjectOptions& options, const std::string& option);

/// Bands d, coverage, z_a, z_b and, with a level of detection, lod and significance (d ÷ lod). A pixel is the exact
/// integral over what was measured of it ÷ the area of that, NaN where there is nothing; coverage is that area ÷ the
/// pixel's, so Σ d · coverage · step² is the net volume, whatever the step. Sides of pixels lie at multiples of the
/// step. UsageError for more pixels than a raster can have. Cost O(cells + pixels they touch). Oracle:
/// tests/report/layers_test.cpp.
[[nodiscard]] RasterLayers difference_layers(const Comparison& c, double step, const Context& context);

/// The same of cells in parts, of which the comparison has those alone that are in no part: the same bits. Oracle: the
/// whole, tests/cli/tile_test.py.
[[nodiscard]] RasterLayers difference_layers(const PartedCells& cells, const Comparison& c, double step,
                                             const Context& context);
/// … of the pixels that cover a box, in frame coordinates: one look at the cells instead of two.
[[nodiscard]] RasterLayers difference_layers(const PartedCells& cells, const Comparison& c, double step,
                                             const Box2& within, const Context& context);

/// A style of QGIS for the first band of that: the colours of the map.
[[nodiscard]] std::string raster_style(const Comparison& c, const MapOptions& look);

}  // namespace isopach
