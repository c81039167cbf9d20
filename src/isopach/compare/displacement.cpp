#include "isopach/compare/displacement.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "isopach/base/fixed_sum.hpp"
#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/measure/source.hpp"

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

/// Sums over the triangles round a node, exact: the same however T was made.
struct SumsAtNode {
  FixedSum area, slope_x, slope_y;
  Point2 at{0, 0};
  double d = 0;
};

SumsAtNode none_at_node(const Frame& frame) {
  const Box3& box = frame.box;
  const double width = box.max.x - box.min.x, height = box.max.y - box.min.y;
  constexpr double most_triangles = 0x1p40;
  const FixedScale slopes{most_triangles, box.max.z - box.min.z, width + height};
  return {FixedSum(FixedScale{width, height}), FixedSum(slopes), FixedSum(slopes)};
}

Places places_of(std::vector<DisplacementCorner> corners, const Frame& frame) {
  std::sort(corners.begin(), corners.end(),
            [](const DisplacementCorner& a, const DisplacementCorner& b) { return a.place < b.place; });
  std::vector<SumsAtNode> nodes;
  const SumsAtNode none = none_at_node(frame);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const DisplacementCorner& c = corners[i];
    if (i == 0 || c.place != corners[i - 1].place) {
      nodes.push_back(none);
      nodes.back().at = c.at, nodes.back().d = c.d;
    }
    nodes.back().area.add(c.area), nodes.back().slope_x.add(c.slope_x), nodes.back().slope_y.add(c.slope_y);
  }
  std::erase_if(nodes, [](const SumsAtNode& node) { return !(node.area.value() > 0); });
  const std::size_t step = nodes.size() / most_places + 1;
  Places places;
  double area = 0, x = 0, y = 0;
  for (std::size_t i = 0; i < nodes.size(); i += step) {
    const SumsAtNode& node = nodes[i];
    const double of_node = node.area.value();
    places.all.push_back(
        {of_node, node.d, {1, node.at.x, node.at.y, node.slope_x.value() / of_node, node.slope_y.value() / of_node}});
    area += of_node, x += of_node * node.at.x, y += of_node * node.at.y;
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

std::size_t displacement_step(std::size_t nodes) { return nodes / looked_at + 1; }

void add_corners(const std::array<Corner, 3>& cell, const std::array<std::size_t, 3>& numbers, std::size_t step,
                 std::vector<DisplacementCorner>& corners) {
  const auto& [p, q, r] = cell;
  const double ax = q.x - p.x, ay = q.y - p.y, bx = r.x - p.x, by = r.y - p.y, twice = ax * by - ay * bx;
  if (!(twice > 0)) return;
  const double u = q.z1 - p.z1, w = r.z1 - p.z1;
  for (std::size_t k = 0; k < 3; ++k)
    if (numbers[k] % step == 0)
      corners.push_back({numbers[k] / step,
                         {cell[k].x, cell[k].y},
                         cell[k].d(),
                         twice / 6,
                         (u * by - w * ay) / 6,
                         (ax * w - bx * u) / 6});
}

std::optional<Displacement> plain_displacement(std::vector<DisplacementCorner> corners, const Frame& frame) {
  if (corners.empty() || frame.box.empty()) return std::nullopt;
  const Places places = places_of(std::move(corners), frame);
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

std::optional<Displacement> plain_displacement(const Comparison& c, const Context& context) {
  using Corners = std::vector<DisplacementCorner>;
  const CellView cells = c.cells.view();
  const std::size_t step = displacement_step(cells.xy.size());
  std::vector<unsigned char> wanted(cells.xy.size(), 0);  // asked three times a cell: a division each would take longer
  for (std::size_t i = 0; i < wanted.size(); i += step) wanted[i] = 1;
  Corners corners;
  run_with_threads(context, [&] {
    corners = gather_blocks<Corners>(cells.t.real, default_block, [&](std::size_t begin, std::size_t end) {
      Corners some;
      for (std::size_t i = begin; i < end; ++i) {
        const auto& v = cells.t.triangles[i].v;
        if (cells.in_domain[i] == 0 || (wanted[v[0]] | wanted[v[1]] | wanted[v[2]]) == 0) continue;
        const CommonCell cell{cells, static_cast<Index>(i), nullptr};
        const std::array<Index, 3> n = cells.corners(i);
        add_corners({cell.corner(0), cell.corner(1), cell.corner(2)}, {n[0], n[1], n[2]}, step, some);
      }
      return some;
    });
  });
  return plain_displacement(std::move(corners), c.frame);
}

}  // namespace isopach
