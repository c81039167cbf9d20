#include "isopach/io/polygons.hpp"

#include <fmt/format.h>

#include <cmath>

#include "isopach/base/error.hpp"
#include "isopach/io/crs.hpp"
#include "isopach/io/raster.hpp"

namespace isopach {

GeoFunctions geo_functions() { return {mended, same_crs, short_name}; }

namespace {

[[noreturn]] void fail(const std::string& path, const std::string& cause) {
  throw InputError(fmt::format("{}: {}", path, cause));
}

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
  mask.geo = geo_functions();
  return mask;
}

}  // namespace isopach
