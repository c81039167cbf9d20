#include "isopach/io/polygons.hpp"

#include <cpl_conv.h>
#include <cpl_http.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_geometry.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>

#include "isopach/base/error.hpp"
#include "isopach/io/crs.hpp"
#include "isopach/io/gdal_memory_file.hpp"
#include "isopach/io/input_file.hpp"
#include "isopach/io/raster.hpp"

namespace isopach {
namespace {

struct CloseDataset {
  void operator()(GDALDataset* data) const { GDALClose(data); }
};
using Dataset = std::unique_ptr<GDALDataset, CloseDataset>;
using Geometry = std::unique_ptr<OGRGeometry>;

[[noreturn]] void fail(const std::string& path, const std::string& cause) {
  throw InputError(fmt::format("{}: {}", path, cause));
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string name_of(const OGRFeature& feature, std::size_t number) {
  for (const char* wanted : {"name", "id", "label", "title"})
    for (int i = 0; i < feature.GetFieldCount(); ++i)
      if (lower(feature.GetFieldDefnRef(i)->GetNameRef()) == wanted && feature.IsFieldSetAndNotNull(i))
        return feature.GetFieldAsString(i);
  return std::to_string(number);
}

// Drivers of files that hold all there is to them (a Shapefile with its parts). Not among them: those that open other
// files or addresses which a file names (VRT, GML and its schemas, services of the web).
constexpr std::array<const char*, 9> polygon_drivers{"CSV", "GeoJSON",    "GeoJSONSeq",   "GPKG", "ESRI Shapefile",
                                                     "KML", "FlatGeobuf", "MapInfo File", nullptr};

CPLHTTPResult* no_answer(const char*, CSLConstList, GDALProgressFunc, void*, CPLHTTPFetchWriteFunc, void*, void*) {
  auto* const result = static_cast<CPLHTTPResult*>(CPLCalloc(1, sizeof(CPLHTTPResult)));
  result->nStatus = 1;
  result->pszErrBuf = CPLStrdup("the network is not used");
  return result;
}

// A CRS of GeoJSON may be a link, which GDAL would follow.
void refuse_network() {
  static const bool done = (CPLHTTPSetFetchCallback(no_answer, nullptr), true);
  (void)done;
}

// A file or folder of polygons, opened once: what GDAL opens by its path, because parts may stand beside it, or bytes.
class Source {
 public:
  explicit Source(const std::string& path) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) fail(path, "no such file: check the path");
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
bool names_its_crs(const Source& source, GDALDataset& data) {
  if (lower(data.GetDriverName()) != "geojson") return true;
  return source.text().find("\"crs\"") != std::string_view::npos;
}

class Reader {
 public:
  explicit Reader(PolygonFile& file) : file_(file) {}

  void add(OGRFeature& feature) {
    const std::size_t number = ++features_;
    const OGRGeometry* const read = feature.GetGeometryRef();
    Polygon polygon{name_of(feature, number), {}};
    if (read != nullptr) {
      const Geometry linear(read->getLinearGeometry());
      if (linear) add(*linear, polygon);
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
  void add(const OGRGeometry& geometry, Polygon& to) {
    if (const auto* polygon = dynamic_cast<const OGRPolygon*>(&geometry)) {
      if (const OGRLinearRing* shell = polygon->getExteriorRing()) add_ring(*shell, to);
      for (int i = 0; i < polygon->getNumInteriorRings(); ++i) add_ring(*polygon->getInteriorRing(i), to);
    } else if (const auto* all = dynamic_cast<const OGRGeometryCollection*>(&geometry)) {
      for (int i = 0; i < all->getNumGeometries(); ++i) add(*all->getGeometryRef(i), to);
    }
  }

  void add_ring(const OGRLinearRing& ring, Polygon& to) {
    std::vector<Point2> points;
    for (int i = 0; i < ring.getNumPoints(); ++i) {
      const Point2 p{ring.getX(i), ring.getY(i)};
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

  PolygonFile& file_;
  std::size_t features_ = 0, without_ = 0, open_ = 0;
};

OGRPolygon ring_as_polygon(const std::vector<Point2>& points) {
  OGRLinearRing ring;
  for (const Point2& p : points) ring.addPoint(p.x, p.y);
  ring.closeRings();
  OGRPolygon polygon;
  polygon.addRing(&ring);
  return polygon;
}

void collect(const OGRGeometry& geometry, Polygon& to) {
  if (const auto* polygon = dynamic_cast<const OGRPolygon*>(&geometry)) {
    const auto add = [&](const OGRLinearRing& ring) {
      std::vector<Point2> points;
      for (int i = 0; i + 1 < ring.getNumPoints(); ++i) points.push_back({ring.getX(i), ring.getY(i)});
      if (points.size() >= 3) to.rings.push_back(std::move(points));
    };
    if (const OGRLinearRing* shell = polygon->getExteriorRing()) add(*shell);
    for (int i = 0; i < polygon->getNumInteriorRings(); ++i) add(*polygon->getInteriorRing(i));
  } else if (const auto* all = dynamic_cast<const OGRGeometryCollection*>(&geometry)) {
    for (int i = 0; i < all->getNumGeometries(); ++i) collect(*all->getGeometryRef(i), to);
  }
}

}  // namespace

PolygonFile read_polygons(const std::string& path) {
  const Source source(path);
  const GdalMessages messages;
  GDALAllRegister();
  refuse_network();
  const Dataset data(
      GDALDataset::Open(source.opened().c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, polygon_drivers.data()));
  if (!data) {
    const std::string why = messages.failure().empty() ? "" : " (" + messages.failure() + ")";
    fail(path, "this is no file of polygons that can be read" + why +
                   ": use GeoJSON, GeoPackage, Shapefile, KML or FlatGeobuf");
  }
  PolygonFile file;
  file.path = path;
  Reader reader(file);
  for (int i = 0; i < data->GetLayerCount(); ++i) {
    OGRLayer& layer = *data->GetLayer(i);
    if (const OGRSpatialReference* reference = layer.GetSpatialRef())
      if (file.crs.empty()) file.crs = describe_crs(*reference).name;
    layer.ResetReading();
    while (const std::unique_ptr<OGRFeature> feature{layer.GetNextFeature()}) reader.add(*feature);
    if (!messages.failure().empty()) fail(path, "it cannot be read (" + messages.failure() + "): mend the file");
  }
  reader.finish();
  if (!file.crs.empty() && !names_its_crs(source, *data)) file.crs.clear();
  return file;
}

std::optional<Polygon> mended(const Polygon& polygon) {
  const GdalMessages messages;
  // Rings count even-odd whatever they are called in the file: so does their symmetric difference.
  Geometry sum;
  for (const auto& points : polygon.rings) {
    const OGRPolygon raw = ring_as_polygon(points);
    Geometry ring(raw.MakeValid());
    if (!ring) return std::nullopt;
    sum = sum ? Geometry(sum->SymDifference(ring.get())) : std::move(ring);
    if (!sum) return std::nullopt;
  }
  Polygon result{polygon.name, {}};
  if (sum) collect(*sum, result);
  if (result.rings.empty()) return std::nullopt;
  return result;
}

std::vector<Edge> edges_of(const Polygon& polygon) {
  std::vector<Edge> edges;
  for (const auto& ring : polygon.rings)
    for (std::size_t i = 0; i < ring.size(); ++i) edges.push_back({ring[i], ring[i + 1 == ring.size() ? 0 : i + 1]});
  return edges;
}

namespace {

class Outline {
 public:
  Outline(const RasterGrid& grid, const std::vector<unsigned char>& in) : grid_(grid), in_(in) {}

  [[nodiscard]] std::vector<Edge> edges() {
    const auto& g = grid_.geotransform;
    joins_ = g[2] == 0 && g[4] == 0;  // a turned raster's corners are rounded: no three of them are in line
    for (std::size_t row = 0; row <= grid_.rows; ++row)
      along(
          grid_.columns,
          [&](std::size_t c) {
            return std::pair{pixel(c, row), row > 0 && pixel(c, row - 1)};
          },
          [&](std::size_t c) { return corner(c, row); });
    for (std::size_t column = 0; column <= grid_.columns; ++column)
      along(
          grid_.rows,
          [&](std::size_t r) {
            return std::pair{pixel(column, r), column > 0 && pixel(column - 1, r)};
          },
          [&](std::size_t r) { return corner(column, r); });
    return std::move(edges_);
  }

 private:
  [[nodiscard]] bool pixel(std::size_t column, std::size_t row) const {
    return column < grid_.columns && row < grid_.rows && in_[row * grid_.columns + column] != 0;
  }
  [[nodiscard]] Point2 corner(std::size_t column, std::size_t row) const {
    const auto& g = grid_.geotransform;
    const double c = static_cast<double>(column), r = static_cast<double>(row);
    return {g[0] + c * g[1] + r * g[2], g[3] + c * g[4] + r * g[5]};
  }
  // The edges of one line of pixel sides. Where the mask changes sides an edge ends: at corners where four meet.
  template <class Sides, class At>
  void along(std::size_t n, const Sides& sides, const At& at) {
    std::size_t from = 0;
    std::pair<bool, bool> now{false, false};
    for (std::size_t i = 0; i <= n; ++i) {
      const std::pair<bool, bool> next = i < n ? sides(i) : std::pair{false, false};
      const bool is_edge = now.first != now.second;
      if (next == now && (joins_ || !is_edge)) continue;
      if (is_edge) edges_.push_back({at(from), at(i)});
      from = i;
      now = next;
    }
  }

  const RasterGrid& grid_;
  const std::vector<unsigned char>& in_;
  bool joins_ = true;
  std::vector<Edge> edges_;
};

}  // namespace

Mask read_mask(const std::string& path, const Context& context) {
  Cloud raster = read_raster(path, {}, context);
  const RasterGrid& grid = *raster.grid;
  const auto& g = grid.geotransform;
  const double determinant = g[1] * g[5] - g[2] * g[4];
  std::vector<unsigned char> in(grid.columns * grid.rows, 0);
  bool any = false;
  for (const Point3& p : raster.points) {
    if (p.z == 0) continue;
    const double dx = p.x - g[0], dy = p.y - g[3];
    const double column = std::floor((dx * g[5] - dy * g[2]) / determinant);
    const double row = std::floor((dy * g[1] - dx * g[4]) / determinant);
    if (!(column >= 0 && row >= 0 && column < static_cast<double>(grid.columns) &&
          row < static_cast<double>(grid.rows)))
      fail(path, "its pixels are too small for its coordinates: use a raster with larger pixels");
    in[static_cast<std::size_t>(row) * grid.columns + static_cast<std::size_t>(column)] = 1;
    any = true;
  }
  if (!any) fail(path, "every pixel of the mask is 0, so nothing would be left: choose another");
  Mask mask;
  mask.path = path;
  mask.crs = raster.crs;
  mask.notes = std::move(raster.notes);
  mask.edges = Outline(grid, in).edges();
  return mask;
}

}  // namespace isopach
