// Height rasters: GeoTIFF, Erdas Imagine and Surfer grids, read by GDAL; ESRI ASCII grids. Band 1 holds the heights.
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "isopach/io/read.hpp"

namespace isopach {

/// Do the first bytes of a file say that it is one of these? GDAL is never asked to guess: it takes lists of points for
/// rasters.
[[nodiscard]] bool is_raster(std::string_view head);

/// One point at the centre of each cell that has data, row by row from the first: z = raw * scale + offset of the band.
/// Cells without data (no-data value, mask, not finite) are dropped and counted in `nodata`. Sets `grid`, unit and CRS;
/// vertical unit from the band, else from the CRS, else "unknown". A raster without georeference gets cells of 1 by 1,
/// the first row on top, and a note. Memory: the points, and one strip of cells.
/// Throws InputError: not such a file, damaged, larger than its bytes can say, no cell with data.
/// Oracle: RasterTest.RoundTripsThroughGeoTiff.
[[nodiscard]] Cloud read_raster(const std::string& path, const ReadOptions& options, const Context& context);
/// The same of a file that is in memory; `path` is its name. What may stand beside a file (.tfw, .aux.xml) is not seen.
[[nodiscard]] Cloud read_raster(std::span<const char> bytes, const std::string& path, const Context& context);

/// Has every cell a place of its own: are coordinates finite and is the centre of each corner cell found in that cell
/// again? False where cells are smaller than what doubles resolve there, or where their size overflows.
[[nodiscard]] bool has_places(const RasterGrid& grid);

/// Centre of a cell at height z.
[[nodiscard]] Point3 cell_centre(const RasterGrid& grid, std::size_t column, std::size_t row, double z);

/// Writes a cloud that was read from a raster as GeoTIFF (Float64, one band, no data = NaN): z of each point in the
/// cell of cloud.grid it lies in. Throws UsageError if the cloud has no grid, InputError if a point lies outside it or
/// two lie in one cell.
void write_raster(const std::string& path, const Cloud& cloud, const Context& context);

}  // namespace isopach
