#include "isopach/io/raster.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "isopach/io/ascii_grid.hpp"
#include "isopach/io/gdal_raster.hpp"
#include "isopach/io/input_file.hpp"

namespace isopach {
namespace {

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
  return not_empty(gdal_read_raster(path, size, driver, context));
}

Cloud read_raster(std::span<const char> bytes, const std::string& path, const Context& context) {
  const std::string_view text(bytes.data(), bytes.size());
  const char* const driver = driver_of(text);
  if (driver == nullptr && !is_ascii_grid(text))
    fail(path, "this is not a raster that can be read", "use GeoTIFF or an ESRI ASCII grid");
  if (driver == nullptr) return not_empty(read_ascii_grid(bytes, path, context));
  return not_empty(gdal_read_raster(bytes, path, driver, context));
}

void write_raster(const std::string& path, const Cloud& cloud, const Context& context) {
  if (!cloud.grid) throw UsageError(fmt::format("{}: only what was read from a raster can be written as one", path));
  const RasterGrid& grid = *cloud.grid;
  constexpr std::size_t most = std::numeric_limits<int>::max();
  if (grid.columns == 0 || grid.rows == 0 || grid.columns > most || grid.rows > most)
    throw UsageError(fmt::format("{}: a raster of {} by {} cells cannot be written", path, grid.columns, grid.rows));
  gdal_write_raster(path, cloud, heights_of(cloud, path), context);
}

}  // namespace isopach
