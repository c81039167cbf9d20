#include "isopach/report/tile_states.hpp"

#include <vector>

#include "isopach/report/page/geojson.hpp"

namespace isopach {
namespace {

using namespace values;

Json ring_of(const Box2& box, const Frame& frame) {
  Json ring = Json::array();
  for (const Point2& p : {Point2{box.min.x, box.min.y}, Point2{box.max.x, box.min.y}, Point2{box.max.x, box.max.y},
                          Point2{box.min.x, box.max.y}, Point2{box.min.x, box.min.y}})
    ring.push_back(place_json(frame, p));
  return ring;
}

}  // namespace

std::string tile_states_geojson(std::span<const TileState> tiles, const Frame& frame, const std::string& crs) {
  std::vector<Json> features;
  for (const TileState& tile : tiles)
    features.push_back({{"type", "Feature"},
                        {"properties",
                         {{"index", tile.index},
                          {"state", tile.state},
                          {"points_a", tile.points_a},
                          {"points_b", tile.points_b},
                          {"seconds", tile.seconds ? real(*tile.seconds) : Json()},
                          {"peak_bytes", tile.peak_bytes ? Json(*tile.peak_bytes) : Json()},
                          {"why", tile.why.empty() ? Json() : message(tile.why)}}},
                        {"geometry", {{"type", "Polygon"}, {"coordinates", {ring_of(tile.square, frame)}}}}});
  return feature_collection(crs, "tiles", features);
}

}  // namespace isopach
