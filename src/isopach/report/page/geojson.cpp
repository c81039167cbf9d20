#include "isopach/report/page/geojson.hpp"

#include <algorithm>

namespace isopach::values {
namespace {

/// "EPSG:25832+7837" → "urn:ogc:def:crs:EPSG::25832"; empty for other names.
std::string urn_of(const std::string& crs) {
  if (crs.rfind("EPSG:", 0) != 0) return "";
  const std::size_t plus = crs.find('+');
  const std::string number = crs.substr(5, plus == std::string::npos ? std::string::npos : plus - 5);
  const bool digits =
      !number.empty() && std::all_of(number.begin(), number.end(), [](char l) { return '0' <= l && l <= '9'; });
  return digits ? "urn:ogc:def:crs:EPSG::" + number : "";
}

/// Rings as GeoJSON has them: closed.
Json rings_json(const Comparison& c, const PolygonWithHoles& polygon) {
  Json rings = Json::array();
  for (const auto& ring : polygon.rings) {
    Json corners = Json::array();
    for (std::size_t i = 0; i <= ring.size(); ++i) corners.push_back(place_json(c, ring[i % ring.size()]));
    rings.push_back(corners);
  }
  return rings;
}

}  // namespace

std::string feature_collection(const std::string& crs, const std::string& name, const std::vector<Json>& features) {
  std::string out = "{\"type\": \"FeatureCollection\", \"name\": \"" + name + "\",\n";
  if (const std::string urn = urn_of(crs); !urn.empty())
    out += "\"crs\": {\"type\": \"name\", \"properties\": {\"name\": \"" + urn + "\"}},\n";
  out += "\"features\": [";
  for (std::size_t i = 0; i < features.size(); ++i) out += (i == 0 ? "\n" : ",\n") + features[i].dump();
  return out + "\n]}\n";
}

std::string feature_collection(const Comparison& c, const std::string& name, const std::vector<Json>& features) {
  return feature_collection(c.a.crs.empty() ? c.b.crs : c.a.crs, name, features);
}

Json place_json(const Frame& frame, const Point2& p) {
  const Point3 at = frame.to_input({p.x, p.y, 0});
  return Json::array({real(at.x), real(at.y)});
}

Json place_json(const Comparison& c, const Point2& p) { return place_json(c.frame, p); }

Json polygons_json(const Comparison& c, const std::vector<PolygonWithHoles>& polygons) {
  if (polygons.empty()) return nullptr;
  if (polygons.size() == 1) return {{"type", "Polygon"}, {"coordinates", rings_json(c, polygons[0])}};
  Json all = Json::array();
  for (const PolygonWithHoles& polygon : polygons) all.push_back(rings_json(c, polygon));
  return {{"type", "MultiPolygon"}, {"coordinates", all}};
}

}  // namespace isopach::values
