// Vector layers in other formats than GeoJSON.
#pragma once
#include <string>

namespace isopach {

enum class VectorFormat { geojson, gpkg, fgb };

/// The ending of its files, without a dot.
[[nodiscard]] const char* ending_of(VectorFormat format);

/// Throws InputError where `format` cannot be written, for `path`: before work is done for it.
void need_vector_writer(VectorFormat format, const std::string& path);

/// Writes the text of a GeoJSON file, of polygons and multipolygons or of lines, in a format: GeoJSON as it is,
/// GeoPackage and FlatGeobuf by GDAL, with the names, numbers and CRS that it has. `crs`, as Cloud::crs, for the latter
/// where the text names none. Whole or not at all; the same bytes for the same text. Errors: as need_vector_writer;
/// Error (exit 1) where it cannot be written. Oracle: tests/io/vector_format_test.cpp (read again by GDAL).
void write_vectors(const std::string& path, const std::string& geojson, VectorFormat format, const std::string& crs);

}  // namespace isopach
