// In place of the files gdal*.cpp where isopach is built without GDAL: what needs it is refused.
#include "isopach/base/error.hpp"
#include "isopach/io/crs.hpp"
#include "isopach/io/gdal_raster.hpp"
#include "isopach/io/gdal_vectors.hpp"
#include "isopach/io/polygons.hpp"
#include "isopach/io/raster_layers.hpp"

namespace isopach {
namespace {

[[noreturn]] void refuse(const std::string& what, const std::string& otherwise = "use another format") {
  throw InputError(what + " needs GDAL, and this isopach was built without it: build it with -DISOPACH_GDAL=ON, or " +
                   otherwise);
}

[[noreturn]] void refuse_crs(const std::string& path) {
  refuse(path + ": reading its coordinate reference system", "name a file that has none");
}

}  // namespace

Crs crs_from_wkt(const std::string&, const std::string& path) { refuse_crs(path); }
Crs crs_from_esri(const std::string&, const std::string& path) { refuse_crs(path); }
Crs crs_from_geokeys(std::span<const char>, std::span<const char>, std::span<const char>, const std::string& path) {
  refuse_crs(path);
}

std::string wkt_of_crs(const std::string& crs, const std::string& path) {
  if (crs.empty()) return {};
  refuse(path + ": writing the coordinate reference system", "write another format");
}

bool same_crs(const std::string& one, const std::string& other) {
  if (one == other || one.empty() || other.empty()) return true;
  refuse("comparing two coordinate reference systems", "name files that have none");
}

std::string short_name(const std::string& crs) {
  if (crs.size() < 40) return crs;
  refuse("naming a coordinate reference system", "name files that have none");
}

Cloud gdal_read_raster(const std::string& path, double, const char*, const Context&) {
  refuse(path + ": reading a raster");
}
Cloud gdal_read_raster(std::span<const char>, const std::string& path, const char*, const Context&) {
  refuse(path + ": reading a raster");
}
void gdal_write_raster(const std::string& path, const Cloud&, Array<double>, const Context&) {
  refuse(path + ": writing a raster", "write another format");
}

void need_raster_writer(const std::string& path) { refuse(path + ": writing a raster", "leave it out"); }
void write_raster_layers(const std::string& path, const RasterLayers&, const Context&) { need_raster_writer(path); }

void gdal_need_vectors(const std::string& path) { refuse(path + ": writing this format", "write GeoJSON"); }
std::string gdal_vectors(const std::string&, const std::string&, const std::string&, const std::string&,
                         const std::string& path) {
  refuse(path + ": writing this format", "write GeoJSON");
}

PolygonSet read_polygons(const std::string& path) { refuse(path + ": reading polygons"); }

std::optional<Polygon> mended(const Polygon& polygon) {
  refuse("mending the polygon '" + polygon.name + "'", "draw it without crossings");
}

}  // namespace isopach
