// The part of io/vector_format that is GDAL's. Throws InputError where GDAL cannot be loaded, or was left out of the
// build.
#pragma once
#include <string>

namespace isopach {

void gdal_need_vectors(const std::string& path);

/// The bytes of a file of this driver with the features of a GeoJSON text.
[[nodiscard]] std::string gdal_vectors(const std::string& geojson, const std::string& driver, const std::string& ending,
                                       const std::string& crs, const std::string& path);

}  // namespace isopach
