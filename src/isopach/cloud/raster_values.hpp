// RasterValues: the cells of a raster by column and row, for rasters that say something of places: standard deviations,
// weights. io/raster_values.hpp reads them from files.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "isopach/cloud/cloud.hpp"

namespace isopach {

/// A value: copies share the cells, which never change.
class RasterValues {
 public:
  /// From a cloud that has a grid: z of each point in its cell, NaN in cells without a point. Throws InputError naming
  /// the path of the cloud: a point outside the grid.
  explicit RasterValues(const Cloud& cloud);

  [[nodiscard]] const RasterGrid& grid() const { return grid_; }
  [[nodiscard]] const std::string& crs() const { return crs_; }
  /// NaN where the raster has no data. No check of the range.
  [[nodiscard]] double value(std::size_t column, std::size_t row) const {
    return value_.get()[row * grid_.columns + column];
  }
  /// Of the cell that holds (p.x, p.y); NaN outside.
  [[nodiscard]] double at(const Point3& p) const;

 private:
  [[nodiscard]] std::optional<std::size_t> place(const Point3& p) const;

  RasterGrid grid_;
  std::string crs_;
  std::shared_ptr<const double[]> value_;  // row by row
};

}  // namespace isopach
