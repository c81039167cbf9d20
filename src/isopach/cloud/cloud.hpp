// Cloud: what a file holds. Points in the file's own coordinates and unit, attributes per point, faces if the file has
// them, unit and CRS if the file says so. Nothing is shifted, cleaned or rounded here; see field/ for that.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/types.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// One number per point, e.g. "classification", "intensity", "red". Names are lower case snake_case.
struct Attribute {
  std::string name;
  Array<double> values;
};

/// The grid a raster file was read from: pixel (column, row) centres are
/// x = g[0] + (column+.5) g[1] + (row+.5) g[2], y = g[3] + (column+.5) g[4] + (row+.5) g[5].
struct RasterGrid {
  std::size_t columns = 0, rows = 0;
  std::array<double, 6> geotransform{0, 1, 0, 0, 0, 1};
};

struct Cloud {
  Array<Point3> points;                   ///< as in the file, NaN and infinities included
  std::vector<Attribute> attributes;      ///< each as long as points
  Array<std::array<Index, 3>> faces;      ///< triangles (polygons are fanned); empty if none
  std::string path;                       ///< where it was read from; empty if made in memory
  std::string format;                     ///< "xyz", "ply", "las", "laz", "obj", "stl", "pcd", "raster"
  std::string unit = "unknown";           ///< of x and y: "m", "mm", "ft", "us-ft", "deg", "unknown"
  std::string vertical_unit = "unknown";  ///< of z
  std::string crs;                        ///< WKT or "EPSG:n"; empty if none
  std::optional<RasterGrid> grid;         ///< set when read from a raster
  std::size_t nodata = 0;                 ///< raster cells (or points) the file itself marks as no data
  std::vector<std::string> notes;         ///< one-line remarks of the reader, shown as warnings

  [[nodiscard]] const Attribute* find_attribute(const std::string& name) const {
    for (const Attribute& a : attributes)
      if (a.name == name) return &a;
    return nullptr;
  }
};

}  // namespace isopach
