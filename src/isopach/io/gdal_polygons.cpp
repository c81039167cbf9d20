// read_polygons and mended of io/polygons.hpp, by GDAL.
#include "isopach/io/polygons.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <new>

#include "isopach/base/error.hpp"
#include "isopach/io/gdal.hpp"
#include "isopach/io/gdal_memory_file.hpp"
#include "isopach/io/input_file.hpp"

namespace isopach {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& cause) {
  throw InputError(fmt::format("{}: {}", path, cause));
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string name_of(OGRFeatureH feature, std::size_t number) {
  const int fields = gdal().OGR_F_GetFieldCount(feature);
  for (const char* wanted : {"name", "id", "label", "title"})
    for (int i = 0; i < fields; ++i)
      if (lower(gdal().OGR_Fld_GetNameRef(gdal().OGR_F_GetFieldDefnRef(feature, i))) == wanted &&
          gdal().OGR_F_IsFieldSetAndNotNull(feature, i) != 0)
        return gdal().OGR_F_GetFieldAsString(feature, i);
  return std::to_string(number);
}

// Drivers of files that hold all there is to them (a Shapefile with its parts). Not among them: those that open other
// files or addresses which a file names (VRT, GML and its schemas, services of the web).
constexpr std::array<const char*, 9> polygon_drivers{"CSV", "GeoJSON",    "GeoJSONSeq",   "GPKG", "ESRI Shapefile",
                                                     "KML", "FlatGeobuf", "MapInfo File", nullptr};

// A file or folder of polygons, opened once: what GDAL opens by its path, because parts may stand beside it, or bytes.
class Source {
 public:
  explicit Source(const std::string& path) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) fail(path, "no such file: check the path");
    need_gdal(path + ": reading polygons");
    // Not to be taken for an address or for polygons as text, which GDAL accepts in place of names.
    opened_ = std::filesystem::absolute(path, error).string();
    if (std::filesystem::is_directory(path, error)) return;
    if (std::filesystem::is_regular_file(path, error) && std::filesystem::file_size(path, error) == 0)
      fail(path, "the file is empty: choose one with polygons");
    file_.emplace(path, context_);
    if (file_->is_regular()) return;
    memory_.emplace(file_->bytes());
    opened_ = memory_->path();
  }
  [[nodiscard]] const std::string& opened() const { return opened_; }
  [[nodiscard]] std::string_view text() const {
    const std::span<const char> bytes = file_ ? file_->bytes() : std::span<const char>{};
    return {bytes.data(), bytes.size()};
  }

 private:
  Context context_;
  std::string opened_;
  mutable std::optional<InputFile> file_;  // reads its bytes when they are asked for
  std::optional<GdalMemoryFile> memory_;
};

// GeoJSON says WGS 84 of everything that names no CRS, and so does GDAL: of coordinates in metres, too.
bool names_its_crs(const Source& source, GDALDatasetH data) {
  if (lower(gdal().GDALGetDriverShortName(gdal().GDALGetDatasetDriver(data))) != "geojson") return true;
  return source.text().find("\"crs\"") != std::string_view::npos;
}

bool is_polygon(OGRGeometryH geometry) {
  const OGRwkbGeometryType type = gdal().OGR_GT_Flatten(gdal().OGR_G_GetGeometryType(geometry));
  return type == wkbPolygon || type == wkbTriangle;
}

bool is_collection(OGRGeometryH geometry) {
  const OGRwkbGeometryType type = gdal().OGR_GT_Flatten(gdal().OGR_G_GetGeometryType(geometry));
  return type == wkbMultiPolygon || type == wkbMultiSurface || type == wkbGeometryCollection;
}

std::vector<Point2> points_of(OGRGeometryH ring) {
  std::vector<Point2> points(static_cast<std::size_t>(gdal().OGR_G_GetPointCount(ring)));
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {gdal().OGR_G_GetX(ring, static_cast<int>(i)), gdal().OGR_G_GetY(ring, static_cast<int>(i))};
  return points;
}

// Calls `visit` for every ring of every polygon in a geometry without arcs.
template <class Visit>
void for_each_ring(OGRGeometryH geometry, const Visit& visit) {
  const bool polygon = is_polygon(geometry);
  if (!polygon && !is_collection(geometry)) return;
  const int parts = gdal().OGR_G_GetGeometryCount(geometry);
  for (int i = 0; i < parts; ++i) {
    const OGRGeometryH part = gdal().OGR_G_GetGeometryRef(geometry, i);
    if (polygon)
      visit(points_of(part));
    else
      for_each_ring(part, visit);
  }
}

class Reader {
 public:
  explicit Reader(PolygonSet& file) : file_(file) {}

  void add(OGRFeatureH feature) {
    const std::size_t number = ++features_;
    const OGRGeometryH read = gdal().OGR_F_GetGeometryRef(feature);
    Polygon polygon{name_of(feature, number), {}};
    if (read != nullptr) {
      const GdalGeometry linear(gdal().OGR_G_GetLinearGeometry(read, 0, nullptr));
      if (linear) for_each_ring(linear.get(), [&](const std::vector<Point2>& ring) { add_ring(ring, polygon); });
    }
    if (polygon.rings.empty()) {
      ++without_;
      return;
    }
    file_.polygons.push_back(std::move(polygon));
  }

  void finish() {
    if (file_.polygons.empty())
      fail(file_.path, features_ == 0 ? "there is no feature in it: choose a file with polygons"
                                      : "there is no polygon in it: lines and points bound no area");
    if (without_ > 0)
      file_.notes.push_back(
          fmt::format("{}: {} of {} features are no polygons and were passed over", file_.path, without_, features_));
    if (open_ > 0)
      file_.notes.push_back(
          fmt::format("{}: {} rings did not end where they began and were closed", file_.path, open_));
  }

 private:
  void add_ring(const std::vector<Point2>& ring, Polygon& to) {
    std::vector<Point2> points;
    for (const Point2& p : ring) {
      if (!std::isfinite(p.x) || !std::isfinite(p.y))
        fail(file_.path, fmt::format("polygon '{}' has a coordinate that is no number: mend the file", to.name));
      if (points.empty() || !(points.back() == p)) points.push_back(p);
    }
    if (points.size() > 1 && points.front() == points.back())
      points.pop_back();
    else
      ++open_;
    if (points.size() < 3)
      fail(file_.path,
           fmt::format("polygon '{}' has a ring of fewer than three different points: mend the file", to.name));
    to.rings.push_back(std::move(points));
  }

  PolygonSet& file_;
  std::size_t features_ = 0, without_ = 0, open_ = 0;
};

GdalGeometry ring_as_polygon(const std::vector<Point2>& points) {
  GdalGeometry ring(gdal().OGR_G_CreateGeometry(wkbLinearRing));
  for (const Point2& p : points) gdal().OGR_G_AddPoint_2D(ring.get(), p.x, p.y);
  gdal().OGR_G_CloseRings(ring.get());
  GdalGeometry polygon(gdal().OGR_G_CreateGeometry(wkbPolygon));
  if (gdal().OGR_G_AddGeometryDirectly(polygon.get(), ring.get()) == OGRERR_NONE) (void)ring.release();
  return polygon;
}

}  // namespace

PolygonSet read_polygons(const std::string& path) {
  const Source source(path);
  const GdalMessages messages;
  const NoNetwork alone;
  gdal().GDALAllRegister();
  const GdalDataset data(gdal().GDALOpenEx(source.opened().c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY,
                                           polygon_drivers.data(), nullptr, nullptr));
  if (!data) {
    const std::string why = messages.failure().empty() ? "" : " (" + messages.failure() + ")";
    fail(path, "this is no file of polygons that can be read" + why +
                   ": use GeoJSON, GeoPackage, Shapefile, KML or FlatGeobuf");
  }
  PolygonSet file;
  file.path = path;
  file.geo = geo_functions();
  Reader reader(file);
  const int layers = gdal().GDALDatasetGetLayerCount(data.get());
  for (int i = 0; i < layers; ++i) {
    const OGRLayerH layer = gdal().GDALDatasetGetLayer(data.get(), i);
    if (file.crs.empty()) file.crs = describe_crs(gdal().OGR_L_GetSpatialRef(layer)).name;
    gdal().OGR_L_ResetReading(layer);
    while (const GdalFeature feature{gdal().OGR_L_GetNextFeature(layer)}) reader.add(feature.get());
    if (!messages.failure().empty()) fail(path, "it cannot be read (" + messages.failure() + "): mend the file");
  }
  reader.finish();
  if (!file.crs.empty() && !names_its_crs(source, data.get())) file.crs.clear();
  return file;
}

std::optional<Polygon> mended(const Polygon& polygon) {
  need_gdal("mending the polygon '" + polygon.name + "'");
  const GdalMessages messages;
  // Rings count even-odd whatever they are called in the file: so does their symmetric difference.
  GdalGeometry sum;
  for (const auto& points : polygon.rings) {
    const GdalGeometry raw = ring_as_polygon(points);
    GdalGeometry ring(gdal().OGR_G_MakeValid(raw.get()));
    if (!ring) return std::nullopt;
    sum = sum ? GdalGeometry(gdal().OGR_G_SymDifference(sum.get(), ring.get())) : std::move(ring);
    if (!sum) return std::nullopt;
  }
  Polygon result{polygon.name, {}};
  const auto add = [&](std::vector<Point2> ring) {
    if (!ring.empty()) ring.pop_back();  // the first again
    if (ring.size() >= 3) result.rings.push_back(std::move(ring));
  };
  if (sum) for_each_ring(sum.get(), add);
  if (result.rings.empty()) return std::nullopt;
  return result;
}

}  // namespace isopach
