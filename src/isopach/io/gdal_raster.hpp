// The part of io/raster that is GDAL's. Throws InputError where GDAL cannot be loaded, or was left out of the build.
#pragma once
#include <span>
#include <string>

#include "isopach/io/raster.hpp"

namespace isopach {

/// As read_raster, by the driver of this name alone; cells without data may be all there are. `size`: bytes of the
/// file.
[[nodiscard]] Cloud gdal_read_raster(const std::string& path, double size, const char* driver, const Context& context);
/// The same of bytes in memory; `path` is their name.
[[nodiscard]] Cloud gdal_read_raster(std::span<const char> bytes, const std::string& path, const char* driver,
                                     const Context& context);

/// As write_raster, once every cell has its height: `heights` row by row, NaN where there is none.
void gdal_write_raster(const std::string& path, const Cloud& cloud, Array<double> heights, const Context& context);

}  // namespace isopach
