// GeoTIFF and other rasters that GDAL reads: the centre of every pixel with data is a point.
#pragma once
#include <span>
#include <string>

#include "isopach/io/read.hpp"

namespace isopach {

[[nodiscard]] bool is_raster(const std::string& path, std::span<const char> head);
[[nodiscard]] Cloud read_raster(const std::string& path, const ReadOptions& options, const Context& context);
void write_raster(const std::string& path, const Cloud& cloud, const Context& context);

}  // namespace isopach
