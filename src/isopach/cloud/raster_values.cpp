#include "isopach/cloud/raster_values.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/error.hpp"

namespace isopach {

RasterValues::RasterValues(const Cloud& cloud) : grid_(*cloud.grid), crs_(cloud.crs) {
  const std::shared_ptr<double[]> cells(new double[grid_.columns * grid_.rows]);
  std::fill_n(cells.get(), grid_.columns * grid_.rows, std::nan(""));
  for (const Point3& p : cloud.points) {
    const auto where = place(p);
    if (!where) throw InputError(cloud.path + ": a cell of the raster lies outside it: its georeference is damaged");
    cells.get()[*where] = p.z;
  }
  value_ = cells;
}

double RasterValues::at(const Point3& p) const {
  const auto where = place(p);
  return where ? value_.get()[*where] : std::nan("");
}

std::optional<std::size_t> RasterValues::place(const Point3& p) const {
  const auto& g = grid_.geotransform;
  const double dx = p.x - g[0], dy = p.y - g[3], det = g[1] * g[5] - g[2] * g[4];
  const double column = std::floor((dx * g[5] - dy * g[2]) / det), row = std::floor((dy * g[1] - dx * g[4]) / det);
  // A point on the far rim belongs to the last cell.
  const auto clipped = [](double v, std::size_t n) { return v == static_cast<double>(n) ? v - 1 : v; };
  const double c = clipped(column, grid_.columns), r = clipped(row, grid_.rows);
  if (!(c >= 0 && r >= 0 && c < static_cast<double>(grid_.columns) && r < static_cast<double>(grid_.rows)))
    return std::nullopt;
  return static_cast<std::size_t>(r) * grid_.columns + static_cast<std::size_t>(c);
}

}  // namespace isopach
