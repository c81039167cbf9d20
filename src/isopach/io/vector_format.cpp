#include "isopach/io/vector_format.hpp"

#include "isopach/io/gdal_vectors.hpp"
#include "isopach/io/output_file.hpp"

namespace isopach {

const char* ending_of(VectorFormat format) {
  switch (format) {
    case VectorFormat::geojson:
      return "geojson";
    case VectorFormat::gpkg:
      return "gpkg";
    case VectorFormat::fgb:
      return "fgb";
  }
  return "geojson";
}

void need_vector_writer(VectorFormat format, const std::string& path) {
  if (format != VectorFormat::geojson) gdal_need_vectors(path);
}

void write_vectors(const std::string& path, const std::string& geojson, VectorFormat format, const std::string& crs) {
  if (format == VectorFormat::geojson) return write_text_atomically(path, geojson);
  const char* const driver = format == VectorFormat::gpkg ? "GPKG" : "FlatGeobuf";
  write_text_atomically(path, gdal_vectors(geojson, driver, ending_of(format), crs, path));
}

}  // namespace isopach
