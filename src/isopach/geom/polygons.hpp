// Polygons and masks as values, in the coordinates of the input. io/polygons.hpp reads them from files; a program may
// as well make its own.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "isopach/geom/trapezoids.hpp"

namespace isopach {

/// One feature: shells and holes of all its parts, each ring without its first point repeated. Even-odd: the order of
/// the rings and their sense of rotation do not matter.
struct Polygon {
  std::string name;  ///< its property "name", "id", "label" or "title", else its feature id, else its number from 1
  std::vector<std::vector<Point2>> rings;
};

[[nodiscard]] std::vector<Edge> edges_of(const Polygon& polygon);

/// What only a library of geographic data can tell. io/polygons.hpp has them by GDAL; whoever leaves one out gets what
/// stands beside it.
struct GeoFunctions {
  /// The same area, of a polygon whose sides cross; nothing if there is none. Left out: such a polygon is refused.
  std::function<std::optional<Polygon>(const Polygon&)> mended;
  /// Do two texts name one horizontal coordinate system? Left out: where they are equal.
  std::function<bool(const std::string&, const std::string&)> same_crs;
  /// A coordinate system in a few words, for messages. Left out: the text itself.
  std::function<std::string(const std::string&)> short_name;
};

/// The polygons of one file.
struct PolygonSet {
  std::string path;  ///< names the set in messages and results: where it was read from
  std::string crs;   ///< as Cloud::crs; empty if it is not known (a GeoJSON without the member "crs" does not say)
  std::vector<Polygon> polygons;
  std::vector<std::string> notes;  ///< one-line remarks of the reader, shown as warnings
  GeoFunctions geo;
};

/// Part of the plane, e.g. the pixels of a raster that are not 0.
struct Mask {
  std::string path;  ///< as of PolygonSet, like the members below
  std::string crs;
  std::vector<Edge> edges;  ///< round that part: closed, even-odd, without crossings
  std::vector<std::string> notes;
  GeoFunctions geo;
};

}  // namespace isopach
