#include "isopach/measure/uncertainty/uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/measure/uncertainty/detection.hpp"

namespace isopach {

namespace {

struct TripleSum {
  Sum net, above, below;
  void add(const VolumeTriple& t) { net.add(t.net), above.add(t.above), below.add(t.below); }
  void add(const TripleSum& t) { net.add(t.net), above.add(t.above), below.add(t.below); }
  [[nodiscard]] VolumeTriple value() const { return {net.value(), above.value(), below.value()}; }
};

void add_to(VolumeTriple& to, double factor, const VolumeTriple& part) {
  to.net += factor * part.net;
  to.above += factor * part.above;
  to.below += factor * part.below;
}

NodeWeights zeros(std::size_t nodes) {
  NodeWeights w(nodes);
  for_each_index(nodes, [&](std::size_t i) { w[i] = {}; });
  return w;
}

// What the three corners of a cell count.
std::array<VolumeTriple, 3> corner_weights(const Cell& cell) {
  const auto& d = cell.d;
  const auto above = positive_shares(d), below = positive_shares({-d[0], -d[1], -d[2]});
  std::array<VolumeTriple, 3> w;
  for (std::size_t k = 0; k < 3; ++k) w[k] = {cell.area / 3, cell.area * above[k], cell.area * below[k]};
  return w;
}

// A node of a scan and what it counts in one cell of the overlay.
struct Share {
  Index node;
  VolumeTriple weight;
};

// The three barycentric coordinates of a point in a triangle.
class Barycentric {
 public:
  Barycentric(const OverlayMesh& mesh, Index triangle) : node_(from_first_corner(mesh.t.triangles[triangle].v)) {
    for (std::size_t k = 0; k < 3; ++k) p_[k] = mesh.xy[node_[k]];
    area_ = triangle_area(p_[0], p_[1], p_[2]);
  }
  [[nodiscard]] const std::array<Index, 3>& nodes() const { return node_; }
  [[nodiscard]] std::array<double, 3> at(const Point2& q) const {
    std::array<double, 3> l{triangle_area(q, p_[1], p_[2]) / area_, triangle_area(q, p_[2], p_[0]) / area_, 0};
    for (double& x : l) x = std::isfinite(x) ? std::clamp(x, 0.0, 1.0) : 0;  // a corner may lie outside by rounding
    l[1] = std::min(l[1], 1 - l[0]);
    l[2] = 1 - l[0] - l[1];
    return l;
  }

 private:
  std::array<Index, 3> node_;
  std::array<Point2, 3> p_;
  double area_;
};

void share_out(const OverlayCell& c, const OverlayMesh& mesh, Index triangle,
               const std::array<VolumeTriple, 6>& of_corner, std::vector<Share>& shares) {
  const Barycentric in(mesh, triangle);
  std::array<VolumeTriple, 3> sum{};
  for (unsigned i = 0; i < c.corners; ++i) {
    const auto l = in.at({c.origin.x + c.x[i], c.origin.y + c.y[i]});
    for (std::size_t k = 0; k < 3; ++k) add_to(sum[k], l[k], of_corner[i]);
  }
  for (std::size_t k = 0; k < 3; ++k) shares.push_back({in.nodes()[k], sum[k]});
}

std::array<VolumeTriple, 6> corner_weights(const OverlayCell& c) {
  std::array<VolumeTriple, 6> of_corner{};
  for (unsigned k = 2; k < c.corners; ++k) {
    const std::array<unsigned, 3> fan{0, k - 1, k};
    const double area = 0.5 * ((c.x[k - 1] - c.x[0]) * (c.y[k] - c.y[0]) - (c.y[k - 1] - c.y[0]) * (c.x[k] - c.x[0]));
    if (!(area > 0)) continue;
    const auto w = corner_weights(Cell{area, {c.d(0), c.d(k - 1), c.d(k)}});
    for (std::size_t i = 0; i < 3; ++i) add_to(of_corner[fan[i]], 1, w[i]);
  }
  return of_corner;
}

constexpr std::size_t sum_block = 1 << 13;

// --- correlated
// -------------------------------------------------------------------------------------------------------

// Squares are an eighth of the range wide, and at least so many reach across the nodes.
constexpr double squares_per_range = 8, least_squares_across = 32;

double reach_in_ranges(CorrelationShape shape) {
  switch (shape) {
    case CorrelationShape::spherical:
      return 1;
    case CorrelationShape::exponential:
      return 2.5;
    case CorrelationShape::gaussian:
      return 1.6;
  }
  return 1;
}

// Mean of c over all pairs of points of a square of side h: the density of their distance along one axis is
// 2 (1 − u) for u in [0, 1], integrated by the midpoint rule.
double mean_in_square(CorrelationShape shape, double range, double h) {
  constexpr int steps = 64;
  Sum sum;
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < steps; ++j) {
      const double u = (i + 0.5) / steps, v = (j + 0.5) / steps;
      sum.add(4 * (1 - u) * (1 - v) * correlation(shape, range, h * std::hypot(u, v)));
    }
  return sum.value() / (steps * steps);
}

// The errors of the nodes in one square, taken together. One mass for each volume, and their common centre.
struct Mass {
  double row, column;  // of the square
  Point2 centre;
  VolumeTriple sum, squares;
};

std::vector<Mass> gather(const NodeWeights& weights, std::span<const double> sigma, std::span<const Point2> xy,
                         double h) {
  struct Placed {
    double row, column;
    Index node;
  };
  std::vector<Placed> placed;
  for (Index q = 0; q < weights.size(); ++q)
    if (weights[q].net > 0 && sigma[q] > 0) placed.push_back({std::floor(xy[q].y / h), std::floor(xy[q].x / h), q});
  std::sort(placed.begin(), placed.end(), [](const Placed& p, const Placed& q) {
    return p.row != q.row ? p.row < q.row : p.column != q.column ? p.column < q.column : p.node < q.node;
  });
  std::vector<Mass> masses;
  for (std::size_t i = 0; i < placed.size();) {
    Mass m{placed[i].row, placed[i].column, {0, 0}, {}, {}};
    const Point2 first = xy[placed[i].node];
    double x = 0, y = 0;
    for (; i < placed.size() && placed[i].row == m.row && placed[i].column == m.column; ++i) {
      const Index q = placed[i].node;
      const double s = sigma[q];
      const VolumeTriple& w = weights[q];
      const VolumeTriple e{w.net * s, w.above * s, w.below * s};
      add_to(m.sum, 1, e);
      add_to(m.squares, 1, {e.net * e.net, e.above * e.above, e.below * e.below});
      x += e.net * (xy[q].x - first.x);
      y += e.net * (xy[q].y - first.y);
    }
    m.centre = {first.x + x / m.sum.net, first.y + y / m.sum.net};
    masses.push_back(m);
  }
  return masses;
}

// Of the nodes, in the longer direction.
double extent(std::span<const Point2> xy) {
  const Box2 box = reduce_blocks<Box2>(
      xy.size(), sum_block,
      [&](std::size_t begin, std::size_t end) {
        Box2 part;
        for (std::size_t i = begin; i < end; ++i) part.add(xy[i]);
        return part;
      },
      [](Box2& total, const Box2& part) { total.add(part); });
  return std::max(box.max.x - box.min.x, box.max.y - box.min.y);
}

bool before(const Mass& m, double row, double column) { return m.row != row ? m.row < row : m.column < column; }

}  // namespace

double correlation(CorrelationShape shape, double range, double r) {
  const double u = r / range;
  switch (shape) {
    case CorrelationShape::spherical:
      return u < 1 ? 1 - u * (1.5 - 0.5 * u * u) : 0;
    case CorrelationShape::exponential:
      return std::exp(-3 * u);
    case CorrelationShape::gaussian:
      return std::exp(-3 * u * u);
  }
  return 0;
}

NodeWeights weights_of_cells(const CellView& cells, const Context& context) {
  context.check();
  NodeWeights w = zeros(cells.xy.size());
  for (const std::size_t item : items_in_order(cells)) {
    const CommonCell c = of_item(cells, item);
    const auto parts = corner_weights(c.cell());
    for (std::size_t k = 0; k < 3; ++k)
      c.for_nodes(k, [&](Index node, double share) { add_to(w[node], share, parts[k]); });
  }
  return w;
}

NodeWeights weights_at_borders(NodeWeights of_cells, const CellView& cells, std::size_t scan) {
  for (const std::size_t item : items_in_order(cells)) {
    if (item < cells.t.real) continue;
    const CommonCell c = of_item(cells, item);
    const auto parts = corner_weights(c.cell());
    for (std::size_t k = 0; k < 3; ++k) {
      if (!c.on_border(scan, k)) continue;
      c.for_nodes(k, [&](Index node, double share) { add_to(of_cells[node], -share, parts[k]); });
      c.for_border_nodes(scan, k, [&](Index node, double share) { add_to(of_cells[node], share, parts[k]); });
    }
  }
  return of_cells;
}

NodeWeights weights_of_scan(const NodeWeights& of_cells, std::span<const Index> own, std::span<const Index> other,
                            std::span<const Stencil> stencil, std::size_t nodes) {
  NodeWeights w = zeros(nodes);
  for (std::size_t i = 0; i < of_cells.size(); ++i) {
    if (of_cells[i].net == 0) continue;
    if (own[i] != no_index) {
      add_to(w[own[i]], 1, of_cells[i]);
      continue;
    }
    const Stencil& s = stencil[other[i]];
    for (std::size_t k = 0; k < 3; ++k) add_to(w[s.node[k]], s.weight[k], of_cells[i]);
  }
  return w;
}

std::array<NodeWeights, 2> weights_of_overlay(const OverlayCells& cells, const OverlayMesh& m1, const OverlayMesh& m2,
                                              const Context& context) {
  std::array<NodeWeights, 2> w{zeros(m1.xy.size()), zeros(m2.xy.size())};
  constexpr std::size_t part = 1 << 11, parts_at_a_time = 64;  // bounds the memory of shares not yet added
  struct Shares {
    std::vector<Share> of_1, of_2;
  };
  for (std::size_t from = 0; from < items_of(cells); from += part * parts_at_a_time) {
    context.check();
    const std::size_t n = std::min(items_of(cells) - from, part * parts_at_a_time);
    std::vector<Shares> made((n + part - 1) / part);
    for_blocks(n, part, [&](std::size_t begin, std::size_t end) {
      Shares& shares = made[begin / part];
      for_overlay(cells, from + begin, from + end, [&](const OverlayCell& c, std::size_t) {
        const auto of_corner = corner_weights(c);
        share_out(c, m1, c.t1, of_corner, shares.of_1);
        share_out(c, m2, c.t2, of_corner, shares.of_2);
      });
    });
    both(
        [&] {
          for (const Shares& s : made)
            for (const Share& x : s.of_1) add_to(w[0][x.node], 1, x.weight);
        },
        [&] {
          for (const Shares& s : made)
            for (const Share& x : s.of_2) add_to(w[1][x.node], 1, x.weight);
        });
  }
  return w;
}

VolumeTriple independent_variance(const NodeWeights& weights, std::span<const double> sigma) {
  return reduce_blocks<TripleSum>(
             weights.size(), sum_block,
             [&](std::size_t begin, std::size_t end) {
               TripleSum part;
               for (std::size_t q = begin; q < end; ++q) {
                 const double s = sigma[q];
                 const VolumeTriple& w = weights[q];
                 part.add({w.net * s * w.net * s, w.above * s * w.above * s, w.below * s * w.below * s});
               }
               return part;
             },
             [](TripleSum& total, const TripleSum& part) { total.add(part); })
      .value();
}

VolumeTriple correlated_variance(const NodeWeights& weights, std::span<const double> sigma, std::span<const Point2> xy,
                                 CorrelationShape shape, double range, const Context& context) {
  context.check();
  const double h = std::min(range / squares_per_range, extent(xy) / least_squares_across),
               reach = reach_in_ranges(shape) * range;
  const std::vector<Mass> masses = gather(weights, sigma, xy, h);
  const double inside = mean_in_square(shape, range, h);
  const double steps = std::min(std::ceil(reach / h), least_squares_across + 1);  // no two are further apart
  const auto pair = [&](const Mass& m, const Mass& other, TripleSum& sum) {
    const double r = std::hypot(m.centre.x - other.centre.x, m.centre.y - other.centre.y);
    if (r >= reach) return;
    const double c = 2 * correlation(shape, range, r);
    sum.add({c * m.sum.net * other.sum.net, c * m.sum.above * other.sum.above, c * m.sum.below * other.sum.below});
  };
  return reduce_blocks<TripleSum>(
             masses.size(), 256,
             [&](std::size_t begin, std::size_t end) {
               TripleSum part;
               for (std::size_t i = begin; i < end; ++i) {
                 const Mass& m = masses[i];
                 const VolumeTriple &s = m.sum, &q = m.squares;
                 const auto own = [&](double sum, double squares) {
                   return squares + inside * std::max(0.0, sum * sum - squares);
                 };
                 part.add({own(s.net, q.net), own(s.above, q.above), own(s.below, q.below)});
                 for (double row = m.row; row <= m.row + steps; ++row) {  // each pair once
                   const double first = row == m.row ? m.column + 1 : m.column - steps;
                   auto other = std::lower_bound(masses.begin() + static_cast<std::ptrdiff_t>(i), masses.end(), 0,
                                                 [&](const Mass& x, int) { return before(x, row, first); });
                   for (; other != masses.end() && other->row == row && other->column <= m.column + steps; ++other)
                     pair(m, *other, part);
                 }
               }
               return part;
             },
             [](TripleSum& total, const TripleSum& part) { total.add(part); })
      .value();
}

}  // namespace isopach
