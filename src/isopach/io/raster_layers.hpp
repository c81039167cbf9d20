// Several bands of one raster as a GeoTIFF.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"

namespace isopach {

struct RasterBand {
  std::string name, unit;  ///< unit: empty if it has none, or it is unknown
  Array<double> values;    ///< row by row from the top; NaN where there is none
};

struct RasterLayers {
  std::size_t columns = 0, rows = 0;
  std::array<double, 6> geotransform{0, 1, 0, 0, 0, -1};
  std::string crs;  ///< as Cloud::crs
  std::vector<RasterBand> bands;
};

/// Throws InputError where rasters cannot be written, for `path`: before work is done for them.
void need_raster_writer(const std::string& path);

/// Bands of doubles in tiles with overviews: a cloud-optimised GeoTIFF where GDAL has its driver, else a tiled one.
/// Whole or not at all. Errors: as need_raster_writer; Error (exit 1) where it cannot be written. Oracle:
/// tests/io/gdal_test.cpp (read again by GDAL).
void write_raster_layers(const std::string& path, const RasterLayers& layers, const Context& context);

}  // namespace isopach
