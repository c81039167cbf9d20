#include "isopach/match/pairs/oriented.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/base/linear.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/field/filter.hpp"

namespace isopach {
namespace {

constexpr std::size_t normal_block = 256;
constexpr double open_side = 0.8 * std::numbers::pi;
constexpr std::size_t least_neighbours = 4;
constexpr std::size_t most_neighbours = 8 * normal_neighbours;
constexpr std::size_t most_neighbours_of_means = 2 * normal_neighbours;  // along a ring there is one in a brick
// Of squared distances, 15th over 4th neighbour: more is of points along lines. A surface has 15/4, a line its square.
constexpr double along_lines = 6;
constexpr double narrow = 0.1;       // variance across over that along: less is more of a line
constexpr double largest_area = 16;  // in medians: a lone point is not a large surface

/// 21 bits spread to every third place.
std::uint64_t spread(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

struct Placed {
  std::uint64_t key;
  Point3 p;
  Index id;
};

bool before(const Placed& a, const Placed& b) {
  if (a.key != b.key) return a.key < b.key;
  if (a.p.x != b.p.x) return a.p.x < b.p.x;
  if (a.p.y != b.p.y) return a.p.y < b.p.y;
  return a.p.z != b.p.z ? a.p.z < b.p.z : a.id < b.id;
}

/// Halves side by side, then merged: the order is total, so the result does not depend on how it was reached.
void sort_placed(Placed* begin, Placed* end, int depth) {
  if (depth == 0 || end - begin < 8192) return std::sort(begin, end, before);
  Placed* middle = begin + (end - begin) / 2;
  both([&] { sort_placed(begin, middle, depth - 1); }, [&] { sort_placed(middle, end, depth - 1); });
  std::inplace_merge(begin, middle, end, before);
}

Array<Placed> kept_points(const CloudView& cloud, const Pose& pose, const Frame& frame, const ProjectOptions& project) {
  const Filter filter(cloud, pose, project);
  check_size(cloud, filter.size(), max_nodes, "points");
  Array<Placed> placed;
  placed.reserve(filter.size());
  for (std::size_t i = 0; i < filter.size(); ++i) {
    const Point3 p = filter.posed(i);
    if (filter.fate(i, p) == Filter::Fate::kept) placed.push_back({0, frame.to_field(p), static_cast<Index>(i)});
  }
  if (placed.empty()) require_points(cloud, count_dropped(filter));
  return placed;
}

/// Places along the Morton curve of cubes of side `cube`, or of 2^21 of them along the longest side of the box.
class Curve {
 public:
  Curve(const Box3& box, double cube) : low_(box.min) {
    const double side = std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
    scale_ = side > 0 ? most / side : 0;
    if (cube > 0) scale_ = std::min(scale_, 1 / cube);
  }
  [[nodiscard]] std::uint64_t key(const Point3& p) const {
    const Point3 d = p - low_;
    return spread(cube_of(d.x)) | spread(cube_of(d.y)) << 1 | spread(cube_of(d.z)) << 2;
  }

 private:
  /// Extents of 1e-309 or 1e308 overflow on the way: such points are in the first cube.
  [[nodiscard]] std::uint64_t cube_of(double d) const {
    const double cube = d * scale_;
    return cube >= 0 && cube <= most ? static_cast<std::uint64_t>(cube) : 0;
  }

  static constexpr double most = 0x1p21 - 1;
  Point3 low_;
  double scale_;
};

void set_keys(Array<Placed>& placed, double cube) {
  Box3 box;
  for (const Placed& q : placed) box.add(q.p);
  const Curve curve(box, cube);
  for_each_index(placed.size(), [&](std::size_t i) { placed[i].key = curve.key(placed[i].p); });
}

/// How many bricks of 2^shift of the smallest cubes hold a point.
std::size_t count_bricks(const Array<std::uint64_t>& keys, unsigned shift) {
  std::size_t count = 1;
  for (std::size_t i = 1; i < keys.size(); ++i) count += keys[i] >> shift != keys[i - 1] >> shift ? 1 : 0;
  return count;
}

/// Of octants in the order +x, from x to y on: whether no two beside one another are empty, as in an open side some
/// are.
bool all_sides(unsigned octants) {
  const unsigned empty = ~octants & 0xffu;
  return (empty & (empty >> 1 | empty << 7)) == 0;
}

/// Fits planes; keeps its room from point to point.
class Fitter {
 public:
  Fitter(const OrientedCloud& cloud, bool boundary)
      : cloud_(cloud), boundary_(boundary), most_(cloud.of_means ? most_neighbours_of_means : most_neighbours) {}

  struct Plane {
    Point3 normal{0, 0, 0};
    double height = 0;
    bool boundary = true;
    double slope_noise = 0, roughness = 0;
    double area = 0;  ///< squared distance of the farthest of the first neighbours
  };
  Plane fit(std::size_t i) {
    Plane plane;
    constexpr std::size_t fourth = 4;  // the point itself is the first
    bool rings = false;
    for (std::size_t k = normal_neighbours; k <= most_; k *= 2) {
      find(i, k);
      if (k == normal_neighbours) plane.area = distance2(i, found_.back());
      if (found_.size() < least_neighbours) return plane;
      if (k == normal_neighbours)
        rings = plane.area > along_lines * distance2(i, found_[std::min(fourth, found_.size() - 1)]);
      scatter(i);
      if (axes_.values[1] > narrow * axes_.values[2] || found_.size() < k) break;
    }
    const Point3 centre = cloud_.points[i];
    const auto n = static_cast<double>(found_.size());
    const auto& sizes = axes_.values;
    constexpr double line = 1e-12;
    if (!(sizes[1] > line * sizes[2])) return plane;
    const Point3 across = axis(0), along = axis(2), beside = axis(1);
    plane.normal = across;
    plane.height = -dot(mean_, across);
    plane.boundary = boundary_ && is_open(centre, along, beside);
    for (std::size_t k = 2 * found_.size(); plane.boundary && rings && k <= most_; k *= 2) {
      find(i, k);  // what few of them close, all of them do
      plane.boundary = is_open(centre, along, beside);
    }
    const double noise2 = std::max(0.0, sizes[0]) / (n - 3);
    plane.slope_noise = noise2 / sizes[1];
    plane.roughness = std::sqrt(noise2);
    return plane;
  }

 private:
  void find(std::size_t i, std::size_t k) { cloud_.tree->nearest(cloud_.points[i], k, found_); }
  /// Mean (from point i) and second moments of the neighbours found, into mean_ and axes_.
  void scatter(std::size_t i) {
    const Point3 centre = cloud_.points[i];
    const auto n = static_cast<double>(found_.size());
    mean_ = {0, 0, 0};
    for (const Index k : found_) mean_ = mean_ + (cloud_.points[k] - centre);
    mean_ = (1 / n) * mean_;
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const Index k : found_) {
      const Point3 d = (cloud_.points[k] - centre) - mean_;
      moments(0, 0) += d.x * d.x, moments(1, 0) += d.x * d.y, moments(1, 1) += d.y * d.y;
      moments(2, 0) += d.x * d.z, moments(2, 1) += d.y * d.z, moments(2, 2) += d.z * d.z;
    }
    axes_ = spectrum(moments);
  }
  [[nodiscard]] Point3 axis(int k) const {
    const auto& v = axes_.vectors;
    return {v(0, k), v(1, k), v(2, k)};
  }
  [[nodiscard]] double distance2(std::size_t i, Index k) const {
    return squared_length(cloud_.points[k] - cloud_.points[i]);
  }
  bool is_open(const Point3& centre, const Point3& along, const Point3& beside) {
    seen_.clear();
    unsigned octants = 0;
    for (const Index k : found_) {
      const Point3 d = cloud_.points[k] - centre;
      const double x = dot(d, along), y = dot(d, beside);
      if (x == 0 && y == 0) continue;
      seen_.push_back({x, y});
      const bool steep = std::fabs(y) > std::fabs(x), second = (x < 0) != (y < 0);
      octants |= 1u << ((y < 0 ? 4u : 0u) + (second ? 2u : 0u) + (steep != second ? 1u : 0u));
    }
    if (all_sides(octants)) return false;
    angles_.clear();
    for (const Point2& d : seen_) angles_.push_back(std::atan2(d.y, d.x));
    if (angles_.empty()) return true;
    std::sort(angles_.begin(), angles_.end());
    double widest = angles_.front() + 2 * std::numbers::pi - angles_.back();
    for (std::size_t i = 1; i < angles_.size(); ++i) widest = std::max(widest, angles_[i] - angles_[i - 1]);
    return widest > open_side;
  }

  const OrientedCloud& cloud_;
  bool boundary_;
  std::size_t most_;
  std::vector<Index> found_;
  std::vector<Point2> seen_;
  std::vector<double> angles_;
  Spectrum<3> axes_;
  Point3 mean_{0, 0, 0};
};

/// Bounded, and with mean 1.
void even_out(Array<double>& areas) {
  Array<double> copy = areas;
  const double most = largest_area * median(copy);
  Sum sum;
  for (double& a : areas) a = std::min(a, most), sum.add(a);
  const double mean = sum.value() / static_cast<double>(areas.size());
  for (double& a : areas) a = mean > 0 ? a / mean : 1;
}

}  // namespace

OrientedCloud order_points(const CloudView& cloud, const Pose& pose, const Frame& frame, const ProjectOptions& project,
                           double thin, const Context& context) {
  context.check();
  Array<Placed> placed = kept_points(cloud, pose, frame, project);
  set_keys(placed, thin);
  sort_placed(placed.data(), placed.data() + placed.size(), 3);
  if (thin > 0)
    placed.erase(
        std::unique(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) { return a.key == b.key; }),
        placed.end());
  OrientedCloud result;
  result.points.resize(placed.size());
  result.ids.resize(placed.size());
  for_each_index(placed.size(), [&](std::size_t i) { result.points[i] = placed[i].p, result.ids[i] = placed[i].id; });
  return result;
}

Means means_of(const OrientedCloud& cloud, std::size_t most) {
  const std::size_t n = cloud.points.size();
  Box3 box;
  for (const Point3& p : cloud.points) box.add(p);
  const Curve curve(box, 0);
  Array<std::uint64_t> keys(n);
  for_each_index(n, [&](std::size_t i) { keys[i] = curve.key(cloud.points[i]); });
  unsigned shift = 0;
  constexpr unsigned all = 63;
  while (shift < all && count_bricks(keys, shift) > most) ++shift;
  Means means;
  means.of_point.resize(n);
  OrientedCloud& c = means.cloud;
  c.of_means = true;
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    Point3 sum{0, 0, 0};
    for (; end < n && keys[end] >> shift == keys[begin] >> shift; ++end) {
      sum = sum + (cloud.points[end] - cloud.points[begin]);
      means.of_point[end] = static_cast<Index>(c.points.size());
    }
    c.points.push_back(cloud.points[begin] + (1 / static_cast<double>(end - begin)) * sum);
    c.ids.push_back(cloud.ids[begin]);
  }
  return means;
}

Array<Point3> normals_at(OrientedCloud& cloud, const Array<Index>& which) {
  if (!cloud.tree) cloud.tree = std::make_unique<PointTree>(cloud.points);
  Array<Point3> normals(which.size());
  for_blocks(which.size(), normal_block, [&](std::size_t begin, std::size_t end) {
    Fitter fitter(cloud, false);
    for (std::size_t i = begin; i < end; ++i) normals[i] = fitter.fit(which[i]).normal;
  });
  return normals;
}

void orient(OrientedCloud& cloud, const Context& context, const Orient& wanted) {
  context.check();
  const std::size_t n = cloud.points.size();
  cloud.tree = std::make_unique<PointTree>(cloud.points);
  cloud.boxes = std::make_unique<BoxTree>(cloud.points);
  cloud.normals.resize(n);
  cloud.height.resize(n);
  cloud.boundary.resize(n);
  cloud.areas.resize(n);
  Array<double> slope_noise(n), roughness(n);
  for_blocks(n, normal_block, [&](std::size_t begin, std::size_t end) {
    Fitter fitter(cloud, wanted.boundary);
    Fitter::Plane plane;
    for (std::size_t i = begin; i < end; ++i) {
      if (i == begin || !(cloud.points[i] == cloud.points[i - 1])) plane = fitter.fit(i);  // where the last one is
      cloud.normals[i] = plane.normal;
      cloud.height[i] = plane.height;
      cloud.boundary[i] = plane.boundary ? 1 : 0;
      cloud.areas[i] = plane.area;
      slope_noise[i] = plane.slope_noise;
      roughness[i] = plane.roughness;
    }
  });
  cloud.slope_noise = median(slope_noise);
  cloud.roughness = median(roughness);
  even_out(cloud.areas);
}

}  // namespace isopach
