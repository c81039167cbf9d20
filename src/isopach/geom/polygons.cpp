#include "isopach/geom/polygons.hpp"

namespace isopach {

std::vector<Edge> edges_of(const Polygon& polygon) {
  std::vector<Edge> edges;
  for (const auto& ring : polygon.rings)
    for (std::size_t i = 0; i < ring.size(); ++i) edges.push_back({ring[i], ring[i + 1 == ring.size() ? 0 : i + 1]});
  return edges;
}

}  // namespace isopach
