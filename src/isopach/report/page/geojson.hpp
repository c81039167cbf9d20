// What GeoJSON files have in common. Internal to report/: the header needs nlohmann-json.
#pragma once
#include <string>
#include <vector>

#include "isopach/measure/changes/outlines.hpp"
#include "isopach/report/page/values.hpp"

namespace isopach::values {

/// A collection with a name and a CRS, as GDAL and QGIS read it, where that has an EPSG number; a feature a line, so
/// that large files can be looked through.
[[nodiscard]] std::string feature_collection(const std::string& crs, const std::string& name,
                                             const std::vector<Json>& features);
/// With the CRS of the scans.
[[nodiscard]] std::string feature_collection(const Comparison& c, const std::string& name,
                                             const std::vector<Json>& features);

/// In input coordinates.
[[nodiscard]] Json place_json(const Frame& frame, const Point2& p);
[[nodiscard]] Json place_json(const Comparison& c, const Point2& p);
/// "Polygon", "MultiPolygon"; null where there is none.
[[nodiscard]] Json polygons_json(const Comparison& c, const std::vector<PolygonWithHoles>& polygons);

}  // namespace isopach::values
