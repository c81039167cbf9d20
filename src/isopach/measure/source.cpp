#include "isopach/measure/source.hpp"

#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/overlay/rim.hpp"

namespace isopach {

namespace {

// Rounding may carry an interpolated height this far beyond those at the nodes, and that is generous.
constexpr double slack = 0x1p-40;

struct Heights {
  double low = HUGE_VAL, high = -HUGE_VAL;
  void add(double z) {  // one that is no number is neither below nor above
    if (z < low) low = z;
    if (z > high) high = z;
  }
  void add(const Heights& h) { add(h.low), add(h.high); }
  [[nodiscard]] double largest() const { return std::max(std::fabs(low), std::fabs(high)); }
};

}  // namespace

SumBounds bounds_of(const Frame& frame) {
  const Box3& box = frame.box;
  if (box.empty()) return {};
  const double height = box.max.z - box.min.z, largest = std::max(std::fabs(box.min.z), std::fabs(box.max.z));
  return {(box.max.x - box.min.x) * (box.max.y - box.min.y), height + slack * largest};
}

SumBounds bounds_of(const CellView& cells) {
  if (cells.bounds) return *cells.bounds;
  struct Part {
    Box2 box;
    Heights z1, z2;
  };
  const Part all = reduce_blocks<Part>(
      cells.xy.size(), std::size_t{1} << 16,
      [&](std::size_t begin, std::size_t end) {
        Part part;
        for (std::size_t i = begin; i < end; ++i)
          part.box.add(cells.xy[i]), part.z1.add(cells.z1[i]), part.z2.add(cells.z2[i]);
        return part;
      },
      [](Part& total, const Part& part) { total.box.add(part.box), total.z1.add(part.z1), total.z2.add(part.z2); });
  if (all.box.empty() || !(all.z1.low <= all.z1.high) || !(all.z2.low <= all.z2.high)) return {};
  return {(all.box.max.x - all.box.min.x) * (all.box.max.y - all.box.min.y),
          std::max(all.z2.high - all.z1.low, all.z1.high - all.z2.low) +
              slack * std::max(all.z1.largest(), all.z2.largest())};
}

SumBounds bounds_of(const OverlayCells& cells) {
  const Box2 box = cells.overlay.box();
  if (box.empty()) return {};
  return {(box.max.x - box.min.x) * (box.max.y - box.min.y), cells.overlay.bound_of_difference()};
}

ConvexCell convex(const CellView& cells, std::size_t triangle) {
  ConvexCell c;
  for (const Index v : cells.corners(triangle)) c.add({cells.xy[v].x, cells.xy[v].y, cells.z1[v], cells.z2[v]});
  return c;
}

ConvexCell convex(const CellPiece& piece) {
  ConvexCell c;
  for (const Corner& corner : piece.at) c.add(corner);
  return c;
}

ConvexCell convex(const OverlayCell& cell) {
  ConvexCell c;
  for (unsigned k = 0; k < cell.corners; ++k)
    c.add({cell.origin.x + cell.x[k], cell.origin.y + cell.y[k], cell.z1[k], cell.z2[k]});
  return c;
}

std::array<double, 3> CommonCell::shares_of_nodes(std::size_t k) const {
  const std::array<Index, 3> v = cells.corners(triangle);
  const Point2 p{piece->at[k].x, piece->at[k].y};
  const Point2 &a = cells.xy[v[0]], &b = cells.xy[v[1]], &c = cells.xy[v[2]];
  std::array<double, 3> shares{triangle_area(p, b, c), triangle_area(a, p, c), triangle_area(a, b, p)};
  double sum = 0;
  for (double& share : shares) sum += share = std::max(share, 0.0);  // rounding, on a side
  for (double& share : shares) share = sum > 0 ? share / sum : 1.0 / 3;
  return shares;
}

double CommonCell::share_of_side(const SideEnds& ends, const Corner& at) const {
  return std::clamp(share_along(cells.xy[ends[0]], cells.xy[ends[1]], at), 0.0, 1.0);
}

std::array<double, 3> CommonCell::at_corners(std::span<const double> of_node) const {
  const std::array<Index, 3> v = cells.corners(triangle);
  if (piece == nullptr) return {of_node[v[0]], of_node[v[1]], of_node[v[2]]};
  std::array<double, 3> values{};
  for (std::size_t k = 0; k < 3; ++k)
    for_nodes(k, [&](Index node, double share) { values[k] += share * of_node[node]; });
  return values;
}

std::vector<std::size_t> items_in_order(const CellView& cells) {
  std::vector<std::size_t> end(cells.xy.size() + 1, 0), order;  // end: of those that begin with a node
  for (std::size_t i = 0; i < cells.t.real; ++i)
    if (cells.in_domain[i] != 0) ++end[cells.corners(i)[0] + 1];
  for (std::size_t node = 0; node + 1 < end.size(); ++node) end[node + 1] += end[node];
  order.resize(end.back());
  for (std::size_t i = 0; i < cells.t.real; ++i)
    if (cells.in_domain[i] != 0) order[end[cells.corners(i)[0]]++] = i;
  const auto at = [&](std::size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
  for (std::size_t node = 0, begin = 0; node + 1 < end.size(); begin = end[node++])
    std::sort(at(begin), at(end[node]),
              [&](std::size_t i, std::size_t j) { return cells.corners(i)[1] < cells.corners(j)[1]; });
  const std::size_t whole = order.size();
  for (std::size_t i = 0; i < cells.pieces.size(); ++i) order.push_back(cells.t.real + i);
  std::stable_sort(at(whole), order.end(), [&](std::size_t i, std::size_t j) {
    const auto corners = [&](std::size_t item) { return cells.corners(cells.pieces[item - cells.t.real].cell); };
    return corners(i) < corners(j);
  });
  return order;
}

std::vector<CellPiece> cut_cells(const CellView& cells, std::span<unsigned char> in_domain, const Domain& domain,
                                 const Context& context) {
  context.check();
  using Pieces = std::vector<CellPiece>;
  const std::size_t whole = cells.t.real;
  return gather_blocks<Pieces>(items_of(cells), default_block, [&](std::size_t begin, std::size_t end) {
    Pieces pieces;
    Domain::Scratch scratch;
    const auto add_parts = [&](Index cell) {
      for (const ConvexCell& part : scratch.pieces)
        for_triangles(part, [&](double, const Corner& a, const Corner& b, const Corner& c) {
          pieces.push_back({cell, {a, b, c}});
        });
    };
    for (std::size_t i = begin; i < std::min(end, whole); ++i) {
      if (in_domain[i] == 0) continue;
      const Regions::Answer answer = domain.split(convex(cells, i), scratch);
      if (answer == Regions::Answer::all) continue;
      in_domain[i] = 0;
      if (answer == Regions::Answer::some) add_parts(static_cast<Index>(i));
    }
    for (std::size_t i = std::max(begin, whole); i < end; ++i) {
      const CellPiece& piece = cells.pieces[i - whole];
      const Regions::Answer answer = domain.split(convex(piece), scratch);
      if (answer == Regions::Answer::all) pieces.push_back(piece);
      if (answer == Regions::Answer::some) add_parts(piece.cell);
    }
    return pieces;
  });
}

OverlaySurface surface_of(const OverlayCells& cells, const Context& context) {
  if (cells.domain.is_everything()) return cells.overlay.surface(context);
  context.check();
  using Cells = std::vector<ConvexCell>;
  const Cells all = gather_blocks<Cells>(items_of(cells), default_block, [&](std::size_t begin, std::size_t end) {
    Cells part;
    for_convex(cells, begin, end, [&](const ConvexCell& c) { part.push_back(c); });
    return part;
  });
  OverlaySurface s;
  for (const ConvexCell& c : all) {
    const Index first = static_cast<Index>(s.xy.size());
    for (unsigned k = 0; k < c.corners; ++k) {
      s.xy.push_back({c.at[k].x, c.at[k].y});
      s.z1.push_back(c.at[k].z1);
      s.z2.push_back(c.at[k].z2);
      if (k >= 2) s.triangles.push_back({first, first + k - 1, first + k});
    }
  }
  return s;
}

}  // namespace isopach
