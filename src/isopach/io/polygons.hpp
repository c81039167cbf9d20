// Polygons from files: GeoJSON, GeoPackage, Shapefile, KML, FlatGeobuf, MapInfo, none of which opens another file or
// the network; masks from rasters. In the coordinates of the file: nothing is projected.
#pragma once
#include <optional>
#include <string>

#include "isopach/base/context.hpp"
#include "isopach/geom/polygons.hpp"

namespace isopach {

/// Features that hold no polygon are passed over with a note, open rings are closed with a note, heights are dropped,
/// arcs become chains. Throws InputError: no such file, not a vector file, no polygon in it, a coordinate that is no
/// number, a ring of fewer than three points. Oracle: tests/io/polygons_test.cpp.
[[nodiscard]] PolygonSet read_polygons(const std::string& path);

/// The same area, if its rings cross: by the rule of GEOS' MakeValid. Nothing if there is no area left.
[[nodiscard]] std::optional<Polygon> mended(const Polygon& polygon);

/// `mended`, `same_crs` and `short_name` of io/crs.hpp: what read_polygons and read_mask give along, for sets that a
/// program makes itself.
[[nodiscard]] GeoFunctions geo_functions();

/// The outline of the pixels of band 1 that are not 0. Cells without data count as 0. Edges run along the borders of
/// pixels, as long as they are straight if the raster is not turned. Throws InputError as read_raster, and where no
/// pixel is left. Memory: that of read_raster and one byte a pixel.
[[nodiscard]] Mask read_mask(const std::string& path, const Context& context);

}  // namespace isopach
