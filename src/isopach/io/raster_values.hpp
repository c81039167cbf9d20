// RasterValues: the cells of a raster by column and row, for rasters that say something of places: standard deviations,
// weights.
#pragma once
#include <optional>
#include <string>

#include "isopach/io/read.hpp"

namespace isopach {

class RasterValues {
 public:
  /// Reads band 1. Throws InputError: not readable, or not a raster; the message names `option`.
  RasterValues(const std::string& path, const std::string& option, const Context& context);
  /// From a cloud that has a grid.
  explicit RasterValues(const Cloud& cloud);

  [[nodiscard]] const RasterGrid& grid() const { return grid_; }
  [[nodiscard]] const std::string& crs() const { return crs_; }
  /// NaN where the raster has no data. No check of the range.
  [[nodiscard]] double value(std::size_t column, std::size_t row) const { return value_[row * grid_.columns + column]; }
  /// Of the cell that holds (p.x, p.y); NaN outside.
  [[nodiscard]] double at(const Point3& p) const;

 private:
  [[nodiscard]] std::optional<std::size_t> place(const Point3& p) const;

  RasterGrid grid_;
  std::string crs_;
  Array<double> value_;
};

}  // namespace isopach
