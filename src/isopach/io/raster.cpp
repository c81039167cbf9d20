#include "isopach/io/raster.hpp"

#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include "isopach/io/ascii_grid.hpp"
#include "isopach/io/crs.hpp"
#include "isopach/io/gdal_memory_file.hpp"
#include "isopach/io/input_file.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/write.hpp"

namespace isopach {
namespace {

// Deflate packs at most 1032 bytes into one. What promises more cells than that is empty or constant nearly everywhere;
// it is read up to a number of cells that every machine can hold.
constexpr double most_cells_per_byte = 1032, always_read = 1e7;
constexpr std::size_t cells_at_once = std::size_t{1} << 22;

struct CloseDataset {
  void operator()(GDALDataset* data) const { GDALClose(data); }
};
using Dataset = std::unique_ptr<GDALDataset, CloseDataset>;

[[noreturn]] void fail(const std::string& path, const std::string& cause, const char* remedy = "get the file again") {
  throw InputError(fmt::format("{}: {}: {}", path, cause, remedy));
}

// Name of the one GDAL driver that reads a file starting so; nullptr if it is none of ours.
const char* driver_of(std::string_view head) {
  const auto starts = [&](std::string_view magic) { return head.substr(0, magic.size()) == magic; };
  using std::string_view_literals::operator""sv;
  if (starts("II*\0"sv) || starts("MM\0*"sv) || starts("II+\0\x08\0"sv) || starts("MM\0+\0\x08"sv)) return "GTiff";
  if (starts("EHFA_HEADER_TAG"sv)) return "HFA";
  if (starts("DSBB"sv)) return "GSBG";
  if (starts("DSRB"sv)) return "GS7BG";
  if (starts("DSAA"sv)) return "GSAG";
  return nullptr;
}

void check_size(const std::string& path, GDALDataset& data, double size) {
  int width = 0, height = 0;
  data.GetRasterBand(1)->GetBlockSize(&width, &height);
  const double cells = static_cast<double>(data.GetRasterXSize()) * data.GetRasterYSize();
  const double block = static_cast<double>(width) * height;
  if (std::max(cells, block) > std::max(most_cells_per_byte * size, always_read))
    fail(path,
         fmt::format("the header promises {} by {} cells in blocks of {} by {}, the file has {:.0f} bytes",
                     data.GetRasterXSize(), data.GetRasterYSize(), width, height, size),
         "get the file again, or crop it to where it has data, e.g. with gdal_translate -srcwin");
}

std::string unit_of_name(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (name == "m" || name == "metre" || name == "meter" || name == "metres" || name == "meters") return "m";
  if (name == "mm" || name == "millimetre" || name == "millimeter") return "mm";
  if (name == "ft" || name == "foot" || name == "feet" || name == "international foot") return "ft";
  if (name == "us-ft" || name == "us survey foot" || name == "ftus" || name == "sfoot") return "us-ft";
  return "unknown";
}

RasterGrid grid_of(GDALDataset& data, Cloud& cloud) {
  RasterGrid grid;
  grid.columns = static_cast<std::size_t>(data.GetRasterXSize());
  grid.rows = static_cast<std::size_t>(data.GetRasterYSize());
  if (data.GetGeoTransform(grid.geotransform.data()) != CE_None) {
    grid.geotransform = {0, 1, 0, 0, 0, -1};
    cloud.notes.emplace_back("the raster has no georeference: its cells are taken as 1 by 1, the first row on top");
  }
  if (!has_places(grid)) fail(cloud.path, "the georeference of the raster is degenerate");
  return grid;
}

void read_cells(GDALRasterBand& band, const GdalMessages& messages, Cloud& cloud, const Context& context) {
  const RasterGrid& grid = *cloud.grid;
  int has_scale = 0, has_offset = 0;
  const double scale_read = band.GetScale(&has_scale), offset_read = band.GetOffset(&has_offset);
  const double scale = has_scale != 0 ? scale_read : 1, offset = has_offset != 0 ? offset_read : 0;
  const bool scaled = scale != 1 || offset != 0;
  GDALRasterBand* const mask = (band.GetMaskFlags() & GMF_ALL_VALID) != 0 ? nullptr : band.GetMaskBand();
  const std::size_t rows_at_once = std::clamp<std::size_t>(cells_at_once / grid.columns, 1, grid.rows);
  Array<double> heights(rows_at_once * grid.columns);
  Array<unsigned char> valid(mask != nullptr ? heights.size() : 0);
  const int width = static_cast<int>(grid.columns);
  for (std::size_t first = 0; first < grid.rows; first += rows_at_once) {
    context.step("read", static_cast<double>(first) / static_cast<double>(grid.rows));
    const std::size_t rows = std::min(rows_at_once, grid.rows - first);
    const int at = static_cast<int>(first), height = static_cast<int>(rows);
    const auto read = [&](GDALRasterBand& from, void* to, GDALDataType type) {
      return from.RasterIO(GF_Read, 0, at, width, height, to, width, height, type, 0, 0, nullptr) == CE_None;
    };
    if (!read(band, heights.data(), GDT_Float64) || (mask != nullptr && !read(*mask, valid.data(), GDT_Byte)))
      fail(cloud.path,
           fmt::format("row {} of {} or after it cannot be read ({})", first, grid.rows, messages.failure()));
    for (std::size_t i = 0; i < rows * grid.columns; ++i) {
      if (!std::isfinite(heights[i]) || (mask != nullptr && valid[i] == 0)) {
        ++cloud.nodata;
        continue;
      }
      const double z = scaled ? heights[i] * scale + offset : heights[i];
      cloud.points.push_back(cell_centre(grid, i % grid.columns, first + i / grid.columns, z));
    }
  }
}

Array<double> heights_of(const Cloud& cloud, const std::string& path) {
  const RasterGrid& grid = *cloud.grid;
  const auto& g = grid.geotransform;
  const double determinant = g[1] * g[5] - g[2] * g[4];
  Array<double> heights(grid.columns * grid.rows, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Point3& p = cloud.points[i];
    const double dx = p.x - g[0], dy = p.y - g[3];
    const double column = std::floor((dx * g[5] - dy * g[2]) / determinant);
    const double row = std::floor((dy * g[1] - dx * g[4]) / determinant);
    if (!(column >= 0 && row >= 0 && column < static_cast<double>(grid.columns) &&
          row < static_cast<double>(grid.rows)))
      fail(path, fmt::format("point {} lies outside the grid", i), "write another format");
    double& cell = heights[static_cast<std::size_t>(row) * grid.columns + static_cast<std::size_t>(column)];
    if (!std::isnan(cell))
      fail(path, fmt::format("point {} lies in a cell that has a point", i), "write another format");
    cell = p.z;
  }
  return heights;
}

Dataset create_tiff(const std::string& file, const RasterGrid& grid) {
  GDALRegister_GTiff();
  CPLStringList options;
  for (const char* option : {"TILED=YES", "COMPRESS=DEFLATE", "PREDICTOR=3", "BIGTIFF=IF_SAFER"})
    options.AddString(option);
  GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  return Dataset(driver->Create(file.c_str(), static_cast<int>(grid.columns), static_cast<int>(grid.rows), 1,
                                GDT_Float64, options.List()));
}

// `opened`: where GDAL finds it; `size`: its bytes.
Cloud read_by_gdal(const std::string& path, const std::string& opened, double size, const char* driver,
                   const Context& context) {
  const GdalMessages messages;
  const ReportVerticalCrs vertical;
  GDALAllRegister();
  const char* const drivers[] = {driver, nullptr};
  const Dataset data(GDALDataset::Open(opened.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers));
  if (!data) fail(path, fmt::format("the raster cannot be opened ({})", messages.failure()));
  if (data->GetRasterCount() < 1) fail(path, "the raster has no bands", "choose a file that has heights");
  GDALRasterBand& band = *data->GetRasterBand(1);
  if (GDALDataTypeIsComplex(band.GetRasterDataType()) != 0)
    fail(path, "the raster holds complex numbers", "choose a file that has heights");
  check_size(path, *data, size);

  Cloud cloud;
  cloud.path = path;
  cloud.format = "raster";
  cloud.grid = grid_of(*data, cloud);
  if (data->GetRasterCount() > 1)
    cloud.notes.push_back(fmt::format("the raster has {} bands: the first is taken as height", data->GetRasterCount()));
  if (const OGRSpatialReference* reference = data->GetSpatialRef()) set_crs(cloud, describe_crs(*reference));
  if (const std::string unit = unit_of_name(band.GetUnitType()); unit != "unknown") cloud.vertical_unit = unit;
  read_cells(band, messages, cloud, context);
  return cloud;
}

Cloud not_empty(Cloud cloud) {
  if (cloud.points.empty()) fail(cloud.path, "the raster holds no cells with data", "choose one that does");
  return cloud;
}

}  // namespace

bool has_places(const RasterGrid& grid) {
  const auto& g = grid.geotransform;
  const double determinant = g[1] * g[5] - g[2] * g[4];
  if (!std::isfinite(determinant) || determinant == 0) return false;
  for (const std::size_t column : {std::size_t{0}, grid.columns - 1})
    for (const std::size_t row : {std::size_t{0}, grid.rows - 1}) {
      const Point3 p = cell_centre(grid, column, row, 0);
      const double dx = p.x - g[0], dy = p.y - g[3];
      if (std::floor((dx * g[5] - dy * g[2]) / determinant) != static_cast<double>(column) ||
          std::floor((dy * g[1] - dx * g[4]) / determinant) != static_cast<double>(row))
        return false;
    }
  return true;
}

bool is_raster(std::string_view head) { return driver_of(head) != nullptr || is_ascii_grid(head); }

Point3 cell_centre(const RasterGrid& grid, std::size_t column, std::size_t row, double z) {
  const auto& g = grid.geotransform;
  const double c = static_cast<double>(column) + 0.5, r = static_cast<double>(row) + 0.5;
  return {g[0] + c * g[1] + r * g[2], g[3] + c * g[4] + r * g[5], z};
}

Cloud read_raster(const std::string& path, const ReadOptions&, const Context& context) {
  InputFile file(path, context);
  const std::span<const char> head = file.head();
  const char* const driver = driver_of({head.data(), head.size()});
  if (driver == nullptr || !file.is_regular()) return read_raster(file.bytes(), path, context);
  std::error_code error;
  const auto size = static_cast<double>(std::filesystem::file_size(path, error));
  if (error) fail(path, fmt::format("cannot be opened ({})", error.message()), "check the path");
  return not_empty(read_by_gdal(path, path, size, driver, context));
}

Cloud read_raster(std::span<const char> bytes, const std::string& path, const Context& context) {
  const std::string_view text(bytes.data(), bytes.size());
  const char* const driver = driver_of(text);
  if (driver == nullptr && !is_ascii_grid(text))
    fail(path, "this is not a raster that can be read", "use GeoTIFF or an ESRI ASCII grid");
  if (driver == nullptr) return not_empty(read_ascii_grid(bytes, path, context));
  const GdalMemoryFile file(bytes);
  return not_empty(read_by_gdal(path, file.path(), static_cast<double>(bytes.size()), driver, context));
}

void write_raster(const std::string& path, const Cloud& cloud, const Context& context) {
  if (!cloud.grid) throw UsageError(fmt::format("{}: only what was read from a raster can be written as one", path));
  const RasterGrid& grid = *cloud.grid;
  constexpr std::size_t most = std::numeric_limits<int>::max();
  if (grid.columns == 0 || grid.rows == 0 || grid.columns > most || grid.rows > most)
    throw UsageError(fmt::format("{}: a raster of {} by {} cells cannot be written", path, grid.columns, grid.rows));
  Array<double> heights = heights_of(cloud, path);
  context.step("write", 0);
  write_atomically(path, [&](const std::string& temporary) {
    const GdalMessages messages;
    Dataset data = create_tiff(temporary, grid);
    const auto check = [&](bool good) {
      if (!good) fail_to_write(path, messages.failure());
    };
    check(data != nullptr);
    std::array<double, 6> geotransform = grid.geotransform;
    check(data->SetGeoTransform(geotransform.data()) == CE_None);
    if (const std::string wkt = wkt_of_crs(cloud.crs); !wkt.empty()) check(data->SetProjection(wkt.c_str()) == CE_None);
    GDALRasterBand& band = *data->GetRasterBand(1);
    check(band.SetNoDataValue(std::numeric_limits<double>::quiet_NaN()) == CE_None);
    if (cloud.vertical_unit != "unknown") check(band.SetUnitType(cloud.vertical_unit.c_str()) == CE_None);
    const int columns = static_cast<int>(grid.columns), rows = static_cast<int>(grid.rows);
    check(band.RasterIO(GF_Write, 0, 0, columns, rows, heights.data(), columns, rows, GDT_Float64, 0, 0, nullptr) ==
          CE_None);
    data.reset();
    check(messages.failure().empty());
  });
}

}  // namespace isopach
