#include "isopach/measure/changes/change_nodes.hpp"

#include <algorithm>

#include "isopach/base/sum.hpp"

namespace isopach {
namespace {

std::array<double, 3> excess_of(const CommonCell& c, const ChangeLevel& level, int sign) {
  const auto lod = level.at_corners(c);
  const auto d = c.cell().d;
  return {sign * d[0] - lod[0], sign * d[1] - lod[1], sign * d[2] - lod[2]};
}

/// The node of T that corner k of a cell is, or no_index.
Index node_at(const CommonCell& c, std::size_t k) {
  const std::array<Index, 3> v = c.cells.corners(c.triangle);
  if (c.piece == nullptr) return v[k];
  const Corner& at = c.piece->at[k];
  for (const Index node : v)
    if (c.cells.xy[node].x == at.x && c.cells.xy[node].y == at.y) return node;
  return no_index;
}

/// f(cell, object, sign) for the cells of the objects of the list, in an order that depends on their places alone.
template <class F>
void for_cells_of(const CellView& cells, const FoundChanges& found, F&& f) {
  for (const std::size_t item : items_in_order(cells))
    for (std::size_t sign = 0; sign < 2; ++sign)
      if (const Index object = found.object_of[sign][item]; object != no_index)
        f(of_item(cells, item), object, sign == 0 ? 1 : -1);
}

}  // namespace

Array<Index> object_of_nodes(const CellView& cells, const ChangeLevel& level, const FoundChanges& found) {
  Array<Index> object_of(cells.xy.size(), no_index);
  for_cells_of(cells, found, [&](const CommonCell& c, Index object, int sign) {
    const auto s = excess_of(c, level, sign);
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(s[k] > 0)) continue;
      if (const Index node = node_at(c, k); node != no_index) object_of[node] = std::min(object_of[node], object);
    }
  });
  return object_of;
}

std::vector<ChangeWeight> weights_in_changes(const CellView& cells, const ChangeLevel& level, const FoundChanges& found,
                                             std::size_t scan) {
  std::vector<ChangeWeight> weights;
  for_cells_of(cells, found, [&](const CommonCell& c, Index object, int sign) {
    const auto shares = positive_shares(excess_of(c, level, sign));
    const double area = c.cell().area;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto add = [&](Index node, double share) {
        if (const double w = area * shares[k] * share; w > 0) weights.push_back({object, node, w});
      };
      if (c.on_border(scan, k))
        c.for_border_nodes(scan, k, add);
      else
        c.for_nodes(k, add);
    }
  });
  std::stable_sort(weights.begin(), weights.end(), [](const ChangeWeight& a, const ChangeWeight& b) {
    return a.object != b.object ? a.object < b.object : a.node < b.node;
  });
  return weights;
}

std::vector<MotionGradient> motions_of_changes(const CellView& cells, const ChangeLevel& level,
                                               const FoundChanges& found, const Point3& centre) {
  std::vector<std::array<Sum, 6>> sums(found.changes.list.size());
  for_cells_of(cells, found, [&](const CommonCell& c, Index object, int sign) {
    const auto shares = positive_shares(excess_of(c, level, sign));
    const double area = c.cell().area;
    if (!(area > 0)) return;
    const Corner o = c.corner(0), p = c.corner(1), q = c.corner(2);
    const double x1 = p.x - o.x, y1 = p.y - o.y, z1 = p.z2 - o.z2, x2 = q.x - o.x, y2 = q.y - o.y, z2 = q.z2 - o.z2;
    const Point2 slope{(z1 * y2 - z2 * y1) / (2 * area), (x1 * z2 - x2 * z1) / (2 * area)};
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner at = c.corner(k);
      const MotionGradient g = motion_gradient({at.x, at.y, at.z2}, slope, centre);
      for (std::size_t i = 0; i < 6; ++i) sums[object][i].add(sign * area * shares[k] * g[i]);
    }
  });
  std::vector<MotionGradient> gradients;
  for (const std::array<Sum, 6>& s : sums) {
    MotionGradient& g = gradients.emplace_back();
    for (std::size_t i = 0; i < 6; ++i) g[i] = s[i].value();
  }
  return gradients;
}

}  // namespace isopach
