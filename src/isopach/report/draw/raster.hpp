// raster: cells drawn into pixels by the pixel-centre rule. A pixel belongs to the one triangle that holds its centre
// (half-open sides: a centre on a shared side belongs to one of the two), so there are no gaps and no seams.
#pragma once
#include "isopach/base/array.hpp"
#include "isopach/compare/comparison.hpp"

namespace isopach {

/// Pixel (column, row) has its centre at x = left + (column + ½) / scale, y = top − (row + ½) / scale: north is up.
struct MapView {
  double left = 0, top = 0;  ///< frame coordinates of the upper left corner
  double scale = 1;          ///< pixels per unit of length
  int columns = 0, rows = 0;
};

struct CellRaster {
  /// footprint: a scan is there up to its border, but not in the domain; none also where T bridges a place without
  /// points, and where a border cuts a cell, beyond it.
  enum class Cover : unsigned char { none, footprint, domain };
  MapView view;
  Array<Cover> cover;  ///< rows × columns, row by row from the top
  Array<float> d;      ///< difference; set where cover is domain
  Array<float> z;      ///< height of surface A above z_origin; set where cover is domain
  Array<float> lod;    ///< level of detection, likewise; empty if the cells have none
  double z_origin = 0;
};

/// The same pixels for any number of threads: image bands are drawn apart, each by triangles in ascending order.
/// Cost: O(triangles + pixels). Oracle: tests/report/raster_test.cpp (point in triangle, pixel by pixel).
[[nodiscard]] CellRaster rasterise(const Cells& cells, const MapView& view);

}  // namespace isopach
