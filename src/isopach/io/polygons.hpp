// Polygons from files: GeoJSON, GeoPackage, Shapefile, KML, FlatGeobuf, MapInfo, none of which opens another file or
// the network; masks from rasters. In the coordinates of the file: nothing is projected.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/geom/trapezoids.hpp"

namespace isopach {

/// One feature: shells and holes of all its parts, each ring without its first point repeated.
struct Polygon {
  std::string name;  ///< its property "name", "id", "label" or "title", else its feature id, else its number from 1
  std::vector<std::vector<Point2>> rings;
};

struct PolygonFile {
  std::string path;
  std::string crs;  ///< as Cloud::crs; empty if the file is silent (a GeoJSON without the member "crs" is)
  std::vector<Polygon> polygons;
  std::vector<std::string> notes;  ///< one-line remarks, for the user
};

/// Features that hold no polygon are passed over with a note, open rings are closed with a note, heights are dropped,
/// arcs become chains. Throws InputError: no such file, not a vector file, no polygon in it, a coordinate that is no
/// number, a ring of fewer than three points. Oracle: tests/io/polygons_test.cpp.
[[nodiscard]] PolygonFile read_polygons(const std::string& path);

/// The same area, if its rings cross: by the rule of GEOS' MakeValid. Nothing if there is no area left.
[[nodiscard]] std::optional<Polygon> mended(const Polygon& polygon);

[[nodiscard]] std::vector<Edge> edges_of(const Polygon& polygon);

struct Mask {
  std::string path;
  std::string crs;
  std::vector<Edge> edges;  ///< round the pixels that are not 0 and have data: closed, even-odd
  std::vector<std::string> notes;
};

/// The outline of the pixels of band 1 that are not 0. Cells without data count as 0. Edges run along the borders of
/// pixels, as long as they are straight if the raster is not turned. Throws InputError as read_raster, and where no
/// pixel is left. Memory: that of read_raster and one byte a pixel.
[[nodiscard]] Mask read_mask(const std::string& path, const Context& context);

}  // namespace isopach
