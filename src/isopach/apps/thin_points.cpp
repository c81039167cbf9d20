#include "isopach/apps/thin_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "isopach/base/linear.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t normal_block = 128;
constexpr std::size_t grid_block = 1024;
constexpr double close_enough = 0.05;  // of the wanted number of means
constexpr int most_sides = 14;         // of a cube that are tried; three or four are usual

struct Place {
  std::uint64_t cube;
  Index point;
};

/// Sides come in steps of a sixteenth of a power of two: two scans that differ by rounding or by a slight turn get the
/// same cubes.
double stepped(double side) {
  int power = 0;
  const double part = std::frexp(side, &power);
  return std::ldexp(std::round(32 * part) / 32, power);
}

/// Cubes with a corner at the origin.
Array<Place> in_cubes(std::span<const Point3> points, const Box3& box, double side) {
  Array<Place> places(points.size());
  const auto below = [&](double v) { return side * std::floor(v / side); };
  const Point3 corner{below(box.min.x), below(box.min.y), below(box.min.z)};
  for_each_index(points.size(), [&](std::size_t i) {
    const auto along = [&](double d) { return static_cast<std::uint64_t>(d / side); };
    const Point3 d = points[i] - corner;
    places[i] = {along(d.x) << 42 | along(d.y) << 21 | along(d.z), static_cast<Index>(i)};
  });
  std::sort(places.begin(), places.end(),
            [](const Place& a, const Place& b) { return a.cube != b.cube ? a.cube < b.cube : a.point < b.point; });
  return places;
}

std::size_t count_cubes(const Array<Place>& places) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < places.size(); ++i) count += i == 0 || places[i].cube != places[i - 1].cube ? 1 : 0;
  return count;
}

/// The sums run over the points in their order, which is that of the set.
Array<Point3> means(std::span<const Point3> points, const Array<Place>& places) {
  Array<Point3> found;
  for (std::size_t begin = 0; begin < places.size();) {
    std::size_t end = begin;
    Point3 sum{0, 0, 0};
    for (; end < places.size() && places[end].cube == places[begin].cube; ++end)
      sum = sum + (points[places[end].point] - points[places[begin].point]);
    found.push_back(points[places[begin].point] + 1.0 / static_cast<double>(end - begin) * sum);
    begin = end;
  }
  return found;
}

Array<Point3> thinned(std::span<const Point3> points, std::size_t wanted) {
  Array<Point3> all(points.begin(), points.end());
  if (points.size() <= wanted) return all;
  Box3 box;
  for (const Point3& p : points) box.add(p);
  const double diagonal = length(box.max - box.min);
  const auto target = static_cast<double>(wanted);
  double low = diagonal / 0x1p20, high = diagonal, side = diagonal / std::sqrt(target);
  if (!(diagonal > 0)) return all;
  Array<Place> places;
  double before = 0;
  for (int k = 0; k < most_sides; ++k) {
    side = stepped(side);
    if (side == before) break;
    before = side;
    places = in_cubes(points, box, side);
    const auto count = static_cast<double>(count_cubes(places));
    if (std::fabs(count - target) < close_enough * target) break;
    (count > target ? low : high) = side;
    const double guess = side * std::sqrt(count / target);  // a surface has as many cubes as their faces cover it
    side = guess > low && guess < high ? guess : std::sqrt(low * high);
  }
  return means(points, places);
}

Point3 normal_of(const ThinPoints& thin, const std::vector<Index>& around) {
  Point3 mean{0, 0, 0};
  for (const Index i : around) mean = mean + thin.points[i];
  mean = 1.0 / static_cast<double>(around.size()) * mean;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Index i : around) {
    const Point3 d = thin.points[i] - mean;
    const Eigen::Vector3d v(d.x, d.y, d.z);
    scatter += v * v.transpose();
  }
  const Eigen::Vector3d n = spectrum(scatter).vectors.col(0);
  return {n[0], n[1], n[2]};
}

}  // namespace

ThinPoints thin_points(std::span<const Point3> points, std::size_t wanted, std::size_t neighbours) {
  ThinPoints thin;
  thin.points = thinned(points, wanted);
  thin.tree = std::make_unique<PointTree>(thin.points);
  const std::size_t n = thin.points.size();
  thin.normals.resize(n);
  Array<double> nearest(n);
  for_blocks(n, normal_block, [&](std::size_t begin, std::size_t end) {
    std::vector<Index> around;
    for (std::size_t i = begin; i < end; ++i) {
      thin.tree->nearest(thin.points[i], neighbours + 1, around);
      nearest[i] = around.size() > 1 ? length(thin.points[around[1]] - thin.points[i]) : 0;
      thin.normals[i] = normal_of(thin, around);
    }
  });
  thin.spacing = median(nearest);
  return thin;
}

NearestGrid::NearestGrid(const ThinPoints& points, std::size_t cells) {
  Box3 box;
  for (const Point3& p : points.points) box.add(p);
  const Point3 extent = box.max - box.min;
  const double longest = std::max({extent.x, extent.y, extent.z}), rim = longest / 8;
  lowest_ = box.min - Point3{rim, rim, rim};
  step_ = longest > 0 ? (longest + 2 * rim) / static_cast<double>(cells) : 1;
  const double sides[3] = {extent.x, extent.y, extent.z};
  for (int k = 0; k < 3; ++k)
    sides_[k] = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil((sides[k] + 2 * rim) / step_)));
  nearest_.resize(sides_[0] * sides_[1] * sides_[2]);
  for_blocks(nearest_.size(), grid_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const auto middle = [&](std::size_t k) { return (static_cast<double>(k) + 0.5) * step_; };
      const std::size_t x = c / (sides_[1] * sides_[2]), y = c / sides_[2] % sides_[1], z = c % sides_[2];
      nearest_[c] = points.tree->nearest_two(lowest_ + Point3{middle(x), middle(y), middle(z)}).first;
    }
  });
}

}  // namespace isopach
