#include "isopach/match/verdict/viewing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "isopach/base/linear.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t most_points = 4000;  // that layers are counted on
constexpr std::size_t most_queries = 600;
constexpr std::size_t beside = 4;      // neighbours in the projection
constexpr double apart = 4;            // in `reach`: a neighbour on a steep slope may lie so far, not more
constexpr double few_layers = 0.05;    // below it a direction is good enough
constexpr double clearly_fewer = 0.6;  // of the share in layers
constexpr int steps_to_mean = 3;

Point3 scaled_to_one(const Point3& v) {
  const double size = length(v);
  return size > 0 ? (1 / size) * v : Point3{0, 0, 1};
}

/// Any unit vector across `w`, the same for the same w.
Point3 across(const Point3& w) {
  const Point3 helper = std::fabs(w.x) < 0.8 ? Point3{1, 0, 0} : Point3{0, 1, 0};
  return scaled_to_one(cross(w, helper));
}

/// The three principal directions of the normals, whatever their signs.
std::array<Point3, 3> principal_directions(std::span<const Point3> normals) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  for (const Point3& n : normals) {
    const Eigen::Vector3d v(n.x, n.y, n.z);
    m += v * v.transpose();
  }
  const Spectrum<3> axes = spectrum(m);
  std::array<Point3, 3> result{};
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d v = axes.vectors.col(2 - k);
    result[static_cast<std::size_t>(k)] = {v(0), v(1), v(2)};
  }
  return result;
}

/// Of v and -v the one whose largest part is positive: which side was seen is not known, and is most often this.
Point3 upwards(const Point3& v) {
  const double most = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  const double part = std::fabs(v.z) == most ? v.z : std::fabs(v.y) == most ? v.y : v.x;
  return part < 0 ? -1.0 * v : v;
}

/// The mean of the normals, each turned to the side of the direction; again from there.
Point3 followed(Point3 axis, std::span<const Point3> normals) {
  for (int step = 0; step < steps_to_mean; ++step) {
    Point3 sum{0, 0, 0};
    for (const Point3& n : normals) sum = sum + (dot(n, axis) < 0 ? -1.0 : 1.0) * n;
    axis = scaled_to_one(sum);
  }
  return upwards(axis);
}

/// Share of the queries that have a neighbour in the projection far off in space.
double share_in_layers(const Viewing& viewing, std::span<const Point3> points, std::span<const Index> queries,
                       std::span<const double> reach) {
  const std::size_t stride = std::max<std::size_t>(1, (points.size() + most_points - 1) / most_points);
  Array<Point3> kept, places;
  for (std::size_t i = 0; i < points.size(); i += stride)
    kept.push_back(points[i]), places.push_back(viewing.place(points[i]));
  const PointTree tree(places);
  const double coarser = std::sqrt(static_cast<double>(stride));
  const std::size_t step = std::max<std::size_t>(1, queries.size() / most_queries);
  std::size_t asked = 0, layered = 0;
  std::vector<Index> found;
  for (std::size_t q = 0; q < queries.size(); q += step) {
    const Point3& p = points[queries[q]];
    tree.nearest(viewing.place(p), beside, found);
    // Sixteen points of all lie within `reach`; four of the thinned ones within about half of that, `coarser` times.
    const double limit = apart * 0.5 * coarser * reach[q];
    const bool far = std::any_of(found.begin(), found.end(), [&](Index k) { return length(kept[k] - p) > limit; });
    ++asked, layered += far ? 1u : 0u;
  }
  return asked > 0 ? static_cast<double>(layered) / static_cast<double>(asked) : 0;
}

struct Candidate {
  Viewing viewing;
  double layers = 1;
};

}  // namespace

Point3 Viewing::line_of_sight(const Point3& p) const {
  if (kind == Kind::direction) return axis;
  return scaled_to_one(kind == Kind::inside ? centre - p : p - centre);
}

double Viewing::nearness(const Point3& p) const {
  if (kind == Kind::direction) return dot(p, axis);
  return (kind == Kind::inside ? -1 : 1) * length(p - centre);
}

Point3 Viewing::place(const Point3& p) const {
  if (kind != Kind::direction) return scaled_to_one(p - centre);
  const Point3 u = across(axis), v = cross(axis, u);
  return {dot(p, u), dot(p, v), 0};
}

Viewing choose_viewing(std::span<const Point3> points, std::span<const Point3> normals, std::span<const Index> queries,
                       std::span<const double> reach, const Point3& origin) {
  const auto judged = [&](const Viewing& v) { return Candidate{v, share_in_layers(v, points, queries, reach)}; };
  Candidate best;
  best.layers = 2;
  for (const Point3& first : principal_directions(normals)) {
    const Candidate c = judged({Viewing::Kind::direction, followed(first, normals), {}});
    if (c.layers < best.layers) best = c;
    if (best.layers < few_layers) return best.viewing;
  }
  Box3 box;
  for (const Point3& p : points) box.add(p);
  const Point3 middle = 0.5 * (box.min + box.max);
  const Candidate all_round = judged({Viewing::Kind::around, {0, 0, 1}, middle});
  if (all_round.layers < clearly_fewer * best.layers) best = all_round;
  const bool among = origin.x > box.min.x && origin.x < box.max.x && origin.y > box.min.y && origin.y < box.max.y;
  if (among) {
    const Candidate scanner = judged({Viewing::Kind::inside, {0, 0, 1}, origin});
    if (scanner.layers < clearly_fewer * best.layers) best = scanner;
  }
  return best.viewing;
}

}  // namespace isopach
