#include "isopach/io/gdal_raster.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

#include "isopach/io/gdal.hpp"
#include "isopach/io/gdal_memory_file.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/write.hpp"

namespace isopach {
namespace {

// Deflate packs at most 1032 bytes into one. What promises more cells than that is empty or constant nearly everywhere;
// it is read up to a number of cells that every machine can hold.
constexpr double most_cells_per_byte = 1032, always_read = 1e7;
constexpr std::size_t cells_at_once = std::size_t{1} << 22;

[[noreturn]] void fail(const std::string& path, const std::string& cause, const char* remedy = "get the file again") {
  throw InputError(fmt::format("{}: {}: {}", path, cause, remedy));
}

void check_size(const std::string& path, GDALDatasetH data, double size) {
  int width = 0, height = 0;
  gdal().GDALGetBlockSize(gdal().GDALGetRasterBand(data, 1), &width, &height);
  const int columns = gdal().GDALGetRasterXSize(data), rows = gdal().GDALGetRasterYSize(data);
  const double cells = static_cast<double>(columns) * rows;
  const double block = static_cast<double>(width) * height;
  if (std::max(cells, block) > std::max(most_cells_per_byte * size, always_read))
    fail(path,
         fmt::format("the header promises {} by {} cells in blocks of {} by {}, the file has {:.0f} bytes", columns,
                     rows, width, height, size),
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

RasterGrid grid_of(GDALDatasetH data, Cloud& cloud) {
  RasterGrid grid;
  grid.columns = static_cast<std::size_t>(gdal().GDALGetRasterXSize(data));
  grid.rows = static_cast<std::size_t>(gdal().GDALGetRasterYSize(data));
  if (gdal().GDALGetGeoTransform(data, grid.geotransform.data()) != CE_None) {
    grid.geotransform = {0, 1, 0, 0, 0, -1};
    cloud.notes.emplace_back("the raster has no georeference: its cells are taken as 1 by 1, the first row on top");
  }
  if (!has_places(grid)) fail(cloud.path, "the georeference of the raster is degenerate");
  return grid;
}

void read_cells(GDALRasterBandH band, const GdalMessages& messages, Cloud& cloud, const Context& context) {
  const RasterGrid& grid = *cloud.grid;
  int has_scale = 0, has_offset = 0;
  const double scale_read = gdal().GDALGetRasterScale(band, &has_scale);
  const double offset_read = gdal().GDALGetRasterOffset(band, &has_offset);
  const double scale = has_scale != 0 ? scale_read : 1, offset = has_offset != 0 ? offset_read : 0;
  const bool scaled = scale != 1 || offset != 0;
  const bool all_valid = (gdal().GDALGetMaskFlags(band) & GMF_ALL_VALID) != 0;
  const GDALRasterBandH mask = all_valid ? nullptr : gdal().GDALGetMaskBand(band);
  const std::size_t rows_at_once = std::clamp<std::size_t>(cells_at_once / grid.columns, 1, grid.rows);
  Array<double> heights(rows_at_once * grid.columns);
  Array<unsigned char> valid(mask != nullptr ? heights.size() : 0);
  const int width = static_cast<int>(grid.columns);
  for (std::size_t first = 0; first < grid.rows; first += rows_at_once) {
    context.step("read", static_cast<double>(first) / static_cast<double>(grid.rows));
    const std::size_t rows = std::min(rows_at_once, grid.rows - first);
    const int at = static_cast<int>(first), height = static_cast<int>(rows);
    const auto read = [&](GDALRasterBandH from, void* to, GDALDataType type) {
      return gdal().GDALRasterIO(from, GF_Read, 0, at, width, height, to, width, height, type, 0, 0) == CE_None;
    };
    if (!read(band, heights.data(), GDT_Float64) || (mask != nullptr && !read(mask, valid.data(), GDT_Byte)))
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

// `opened`: where GDAL finds it; `size`: its bytes.
Cloud read(const std::string& path, const std::string& opened, double size, const char* driver,
           const Context& context) {
  const GdalMessages messages;
  const ReportVerticalCrs vertical;
  gdal().GDALAllRegister();
  const char* const drivers[] = {driver, nullptr};
  const GdalDataset data(
      gdal().GDALOpenEx(opened.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers, nullptr, nullptr));
  if (!data) fail(path, fmt::format("the raster cannot be opened ({})", messages.failure()));
  const int bands = gdal().GDALGetRasterCount(data.get());
  if (bands < 1) fail(path, "the raster has no bands", "choose a file that has heights");
  const GDALRasterBandH band = gdal().GDALGetRasterBand(data.get(), 1);
  if (gdal().GDALDataTypeIsComplex(gdal().GDALGetRasterDataType(band)) != 0)
    fail(path, "the raster holds complex numbers", "choose a file that has heights");
  check_size(path, data.get(), size);

  Cloud cloud;
  cloud.path = path;
  cloud.format = "raster";
  cloud.grid = grid_of(data.get(), cloud);
  if (bands > 1) cloud.notes.push_back(fmt::format("the raster has {} bands: the first is taken as height", bands));
  if (const auto reference = gdal().GDALGetSpatialRef(data.get()); reference != nullptr)
    set_crs(cloud, describe_crs(reference));
  if (const std::string unit = unit_of_name(gdal().GDALGetRasterUnitType(band)); unit != "unknown")
    cloud.vertical_unit = unit;
  read_cells(band, messages, cloud, context);
  return cloud;
}

GdalDataset create_tiff(const std::string& file, const RasterGrid& grid) {
  gdal().GDALRegister_GTiff();
  const char* const options[] = {"TILED=YES", "COMPRESS=DEFLATE", "PREDICTOR=3", "BIGTIFF=IF_SAFER", nullptr};
  const GDALDriverH driver = gdal().GDALGetDriverByName("GTiff");
  return GdalDataset(gdal().GDALCreate(driver, file.c_str(), static_cast<int>(grid.columns),
                                       static_cast<int>(grid.rows), 1, GDT_Float64, options));
}

}  // namespace

Cloud gdal_read_raster(const std::string& path, double size, const char* driver, const Context& context) {
  need_gdal(path + ": reading a raster");
  return read(path, path, size, driver, context);
}

Cloud gdal_read_raster(std::span<const char> bytes, const std::string& path, const char* driver,
                       const Context& context) {
  need_gdal(path + ": reading a raster");
  const GdalMemoryFile file(bytes);
  return read(path, file.path(), static_cast<double>(bytes.size()), driver, context);
}

void gdal_write_raster(const std::string& path, const Cloud& cloud, Array<double> heights, const Context& context) {
  need_gdal(path + ": writing a raster");
  const RasterGrid& grid = *cloud.grid;
  context.step("write", 0);
  write_atomically(path, [&](const std::string& temporary) {
    const GdalMessages messages;
    GdalDataset data = create_tiff(temporary, grid);
    const auto check = [&](bool good) {
      if (!good) fail_to_write(path, messages.failure());
    };
    check(data != nullptr);
    std::array<double, 6> geotransform = grid.geotransform;
    check(gdal().GDALSetGeoTransform(data.get(), geotransform.data()) == CE_None);
    if (const std::string wkt = wkt_of_crs(cloud.crs, path); !wkt.empty())
      check(gdal().GDALSetProjection(data.get(), wkt.c_str()) == CE_None);
    const GDALRasterBandH band = gdal().GDALGetRasterBand(data.get(), 1);
    check(gdal().GDALSetRasterNoDataValue(band, std::numeric_limits<double>::quiet_NaN()) == CE_None);
    if (cloud.vertical_unit != "unknown")
      check(gdal().GDALSetRasterUnitType(band, cloud.vertical_unit.c_str()) == CE_None);
    const int columns = static_cast<int>(grid.columns), rows = static_cast<int>(grid.rows);
    check(gdal().GDALRasterIO(band, GF_Write, 0, 0, columns, rows, heights.data(), columns, rows, GDT_Float64, 0, 0) ==
          CE_None);
    data.reset();
    check(messages.failure().empty());
  });
}

}  // namespace isopach
