#include "isopach/tiles/node_heights.hpp"

#include <cmath>

namespace isopach {

Array<double> node_heights(std::size_t k, std::span<const Point2> nodes, const CellPart& cells, const ScanPart& part,
                           std::span<const double> joined) {
  const std::span<const double> known = k == 0 ? cells.z2 : cells.z1;
  Array<double> heights;
  if (part.in_t.size() != joined.size()) return heights;
  std::size_t up = 0;
  for (std::size_t i = 0; i < cells.xy.size() && heights.size() < nodes.size(); ++i) {  // both in curve order
    const bool is_up = up < joined.size() && part.in_t[up] == i;
    if (cells.xy[i] == nodes[heights.size()]) heights.push_back(is_up && std::isnan(known[i]) ? joined[up] : known[i]);
    if (is_up) ++up;
  }
  return heights;
}

}  // namespace isopach
