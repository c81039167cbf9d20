#include "isopach/compare/displacement.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "isopach/base/fixed_sum.hpp"
#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"

namespace isopach {

namespace {

constexpr std::size_t looked_at = 40000, most_places = 5000, least_places = 30;
constexpr int rounds = 12;
constexpr double least_gain = 5;  // times that the median of |d| must fall
constexpr int terms = 5;          // 1, x, y, slope along x, slope along y

struct Place {
  double area = 0, d = 0;
  std::array<double, terms> term{};
};

/// Some nodes of the domain in their order, with the area round each and the slopes of A there. x and y are relative to
/// their middle and divided by their reach, so that all terms are of one size.
struct Places {
  std::vector<Place> all;
  double reach = 1;
};

struct AtNode {
  double area = 0, slope_x = 0, slope_y = 0;
};

/// Sums over the triangles round a node, exact: the same however T was made.
struct SumsAtNode {
  FixedSum area, slope_x, slope_y;
};

SumsAtNode none_at_node(const CellView& cells) {
  Box2 box;
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const Point2& p : cells.xy) box.add(p);
  for (const double z : cells.z1) low = std::min(low, z), high = std::max(high, z);
  if (box.empty() || !(low <= high)) return {};
  const double width = box.max.x - box.min.x, height = box.max.y - box.min.y;
  constexpr double most_triangles = 0x1p40;
  const FixedScale slopes{most_triangles, high - low, width + height};
  return {FixedSum(FixedScale{width, height}), FixedSum(slopes), FixedSum(slopes)};
}

/// What a whole cell adds at one of its corners.
struct AtCorner {
  std::size_t place;  // number of the node, divided by the step
  AtNode sums;        // slope · area, so that no sliver counts for more than it is
};

void add_corners(const CellView& cells, std::size_t triangle, std::size_t step, std::vector<AtCorner>& corners) {
  const std::array<Index, 3> v = cells.corners(triangle);
  const Point2 &p = cells.xy[v[0]], &q = cells.xy[v[1]], &r = cells.xy[v[2]];
  const double ax = q.x - p.x, ay = q.y - p.y, bx = r.x - p.x, by = r.y - p.y, twice = ax * by - ay * bx;
  if (!(twice > 0)) return;
  const double u = cells.z1[v[1]] - cells.z1[v[0]], w = cells.z1[v[2]] - cells.z1[v[0]];
  for (const Index node : v)
    if (node % step == 0) corners.push_back({node / step, {twice / 6, (u * by - w * ay) / 6, (ax * w - bx * u) / 6}});
}

/// Of every step-th node. By the order of the nodes, which is the same however T was made.
std::vector<AtNode> at_nodes(const CellView& cells, std::size_t step) {
  std::vector<unsigned char> wanted(cells.xy.size(), 0);  // asked three times a cell: a division each would take longer
  for (std::size_t i = 0; i < wanted.size(); i += step) wanted[i] = 1;
  using Corners = std::vector<AtCorner>;
  const Corners corners = gather_blocks<Corners>(cells.t.real, default_block, [&](std::size_t begin, std::size_t end) {
    Corners some;
    for (std::size_t i = begin; i < end; ++i) {
      const auto& v = cells.t.triangles[i].v;
      if (cells.in_domain[i] != 0 && (wanted[v[0]] | wanted[v[1]] | wanted[v[2]]) != 0)
        add_corners(cells, i, step, some);
    }
    return some;
  });
  std::vector<SumsAtNode> sums((cells.xy.size() + step - 1) / step, none_at_node(cells));
  for (const AtCorner& c : corners) {
    SumsAtNode& at = sums[c.place];
    at.area.add(c.sums.area);
    at.slope_x.add(c.sums.slope_x);
    at.slope_y.add(c.sums.slope_y);
  }
  std::vector<AtNode> nodes;
  nodes.reserve(sums.size());
  for (const SumsAtNode& s : sums) nodes.push_back({s.area.value(), s.slope_x.value(), s.slope_y.value()});
  return nodes;
}

Places places_of(const CellView& cells) {
  const std::size_t coarse = cells.xy.size() / looked_at + 1;
  const std::vector<AtNode> nodes = at_nodes(cells, coarse);
  const auto used = static_cast<std::size_t>(
      std::count_if(nodes.begin(), nodes.end(), [](const AtNode& node) { return node.area > 0; }));
  const std::size_t step = used / most_places + 1;
  Places places;
  std::size_t seen = 0;
  double area = 0, x = 0, y = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const AtNode& node = nodes[i];
    if (!(node.area > 0) || seen++ % step != 0) continue;
    const std::size_t of_t = i * coarse;
    const Point2& at = cells.xy[of_t];
    places.all.push_back({node.area,
                          cells.z2[of_t] - cells.z1[of_t],
                          {1, at.x, at.y, node.slope_x / node.area, node.slope_y / node.area}});
    area += node.area, x += node.area * at.x, y += node.area * at.y;
  }
  double reach = 0;
  for (Place& p : places.all) {
    p.term[1] -= x / area, p.term[2] -= y / area;
    reach = std::max({reach, std::fabs(p.term[1]), std::fabs(p.term[2])});
  }
  if (!(reach > 0)) return {};
  for (Place& p : places.all) p.term[1] /= reach, p.term[2] /= reach;
  places.reach = reach;
  return places;
}

/// Median of |residual| by area, 0 of none; reorders. Cost O(n).
double median_of(std::vector<std::pair<double, double>>& residual_and_area) {
  if (residual_and_area.empty()) return 0;
  const auto add = [](double sum, const std::pair<double, double>& r) { return sum + r.second; };
  const double half = std::accumulate(residual_and_area.begin(), residual_and_area.end(), 0.0, add) / 2;
  auto first = residual_and_area.begin(), last = residual_and_area.end();
  for (double before = 0; last - first > 1;) {  // the median lies in between; those before it have this area
    const auto middle = first + (last - first) / 2;
    std::nth_element(first, middle, last);
    const double lower = std::accumulate(first, middle, before, add);
    if (lower >= half)
      last = middle;
    else
      before = lower, first = middle;
  }
  return first->first;
}

using Motion = std::array<double, terms>;

double median_residual(const Places& places, const Motion& motion) {
  std::vector<std::pair<double, double>> residuals;
  residuals.reserve(places.all.size());
  for (const Place& p : places.all) {
    double r = p.d;
    for (int k = 0; k < terms; ++k) r -= motion[k] * p.term[k];
    residuals.emplace_back(std::fabs(r), p.area);
  }
  return median_of(residuals);
}

/// Least absolute deviations of the first `n` terms.
Motion fitted(const Places& places, int n) {
  Motion motion{};
  double scale = 0;  // residuals below it count alike: none at first, so that the first round is of least squares
  for (int round = 0; round < rounds; ++round) {
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (const Place& p : places.all) {
      double r = p.d;
      for (int k = 0; k < n; ++k) r -= motion[k] * p.term[k];
      const double weight = p.area / (round == 0 || scale == 0 ? 1 : std::max(std::fabs(r), scale));
      for (int i = 0; i < n; ++i) {
        right[i] += weight * p.term[i] * p.d;
        for (int j = 0; j < n; ++j) normal(i, j) += weight * p.term[i] * p.term[j];
      }
    }
    // Slopes that are the same everywhere (a plane) leave the shift open: it stays 0 then.
    const Eigen::VectorXd found = least_norm(normal, right);
    for (int k = 0; k < n; ++k) motion[k] = found[k];
    scale = median_residual(places, motion) / 10;
    if (scale == 0) break;
  }
  return motion;
}

}  // namespace

std::optional<Displacement> plain_displacement(const Comparison& c, const Context& context) {
  Places places;
  run_with_threads(context, [&] { places = places_of(c.cells.view()); });
  if (places.all.size() < least_places) return std::nullopt;
  Displacement found;
  found.before = median_residual(places, {});
  if (!(found.before > 0)) return std::nullopt;
  using Kind = Displacement::Kind;
  for (const auto& [kind, n] : {std::pair{Kind::offset, 1}, std::pair{Kind::tilt, 3}, std::pair{Kind::shift, 5}}) {
    const Motion motion = fitted(places, n);
    const double after = median_residual(places, motion);
    if (!(least_gain * after <= found.before)) continue;
    found.kind = kind;
    found.after = after;
    found.offset = motion[0];
    found.tilt = std::atan(std::hypot(motion[1], motion[2]) / places.reach);
    found.shift = std::hypot(motion[3], motion[4]);
    return found;
  }
  return std::nullopt;
}

}  // namespace isopach
