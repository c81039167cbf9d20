#include "isopach/match/coarse/landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/types.hpp"
#include "isopach/distance/point_tree.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t landmark_block = 64;
constexpr std::size_t least_support = 6;    // neighbours of a plane
constexpr std::size_t tree_neighbours = 8;  // of the tree that turns the normals
constexpr float least_in_ring = 3;
constexpr double floors_rms = 2.5;  // the floors reach so many RMS heights up and down

struct Cube {
  std::array<std::int64_t, 3> place;
  Index id;
  bool operator<(const Cube& other) const { return place != other.place ? place < other.place : id < other.id; }
};

std::vector<Cube> cubes_of(std::span<const Point3> points, double side) {
  constexpr double most = 0x1p62;  // that an integer holds: points farther away share the last cube
  std::vector<Cube> cubes(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto index = [&](double x) {
      return static_cast<std::int64_t>(std::clamp(std::floor(x / side), -most, most));
    };
    cubes[i] = {{index(points[i].x), index(points[i].y), index(points[i].z)}, static_cast<Index>(i)};
  }
  std::sort(cubes.begin(), cubes.end());
  return cubes;
}

std::size_t count_cubes(std::span<const Point3> points, double side) {
  const std::vector<Cube> cubes = cubes_of(points, side);
  std::size_t count = 0;
  for (std::size_t i = 0; i < cubes.size(); ++i) count += i == 0 || cubes[i].place != cubes[i - 1].place ? 1u : 0u;
  return count;
}

double diagonal(std::span<const Point3> points) {
  Box3 box;
  for (const Point3& p : points) box.add(p);
  return points.empty() ? 0 : length(box.max - box.min);
}

/// Normal and RMS height of one support.
void fit(const Landmarks& marks, std::size_t i, std::span<const Index> found, Point3& normal, double& height) {
  normal = {0, 0, 0}, height = 0;
  if (found.size() < least_support) return;
  const auto n = static_cast<double>(found.size());
  Point3 mean{0, 0, 0};
  for (const Index k : found) mean = mean + (marks.places[k] - marks.places[i]);
  mean = (1 / n) * mean;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Index k : found) {
    const Point3 q = marks.places[k] - marks.places[i] - mean;
    const Eigen::Vector3d d(q.x, q.y, q.z);
    scatter += d * d.transpose();
  }
  const Spectrum<3> axes = spectrum(scatter);
  constexpr double line = 1e-12;
  if (!(axes.values(1) > line * axes.values(2))) return;
  const Eigen::Vector3d v = axes.vectors.col(0);
  normal = {v(0), v(1), v(2)};
  height = std::sqrt(std::max(0.0, axes.values(0)) / n);
}

/// Prim's tree over the nearest neighbours, most parallel first; each part of the surface by itself, its first landmark
/// upwards.
void turn_to_one_side(Landmarks& marks, const PointTree& tree) {
  struct Edge {
    double turn;
    Index from, to;
    bool operator<(const Edge& other) const {  // the queue gives the largest
      if (turn != other.turn) return turn > other.turn;
      return from != other.from ? from > other.from : to > other.to;
    }
  };
  const std::size_t n = marks.places.size();
  std::vector<char> done(n, 0);
  std::vector<Index> near;
  const auto reach = [&](std::priority_queue<Edge>& queue, Index from) {
    done[from] = 1;
    tree.nearest(marks.places[from], tree_neighbours + 1, near);
    for (const Index to : near)
      if (done[to] == 0) queue.push({1 - std::fabs(dot(marks.normals[from], marks.normals[to])), from, to});
  };
  for (std::size_t first = 0; first < n; ++first) {
    if (done[first] != 0) continue;
    std::priority_queue<Edge> queue;
    std::vector<Index> part{static_cast<Index>(first)};
    reach(queue, static_cast<Index>(first));
    while (!queue.empty()) {
      const Edge edge = queue.top();
      queue.pop();
      if (done[edge.to] != 0) continue;
      if (dot(marks.normals[edge.from], marks.normals[edge.to]) < 0)
        marks.normals[edge.to] = -1.0 * marks.normals[edge.to];
      part.push_back(edge.to);
      reach(queue, edge.to);
    }
    double up = 0;
    for (const Index i : part) up += marks.normals[i].z;
    if (up < 0)
      for (const Index i : part) marks.normals[i] = -1.0 * marks.normals[i];
  }
}

SpinImage image_of(const Landmarks& marks, std::size_t i, std::span<const Index> found, double top) {
  SpinImage image;
  const double radius = support_sides * marks.side;
  std::array<float, SpinImage::rings> counts{};
  for (const Index k : found) {
    if (k == i) continue;
    const Point3 d = marks.places[k] - marks.places[i];
    const double up = dot(d, marks.normals[i]), out = std::sqrt(std::max(0.0, squared_length(d) - up * up));
    const auto ring =
        std::min(SpinImage::rings - 1, static_cast<std::size_t>(out / radius * static_cast<double>(SpinImage::rings)));
    // Shared between two floors, so that a height near a border does not jump.
    const double place = std::clamp((up / top + 1) / 2, 0.0, 1.0) * (SpinImage::floors - 1);
    const auto floor = std::min(SpinImage::floors - 2, static_cast<std::size_t>(place));
    const auto part = static_cast<float>(place - static_cast<double>(floor));
    image.cells[ring * SpinImage::floors + floor] += 1 - part;
    image.cells[ring * SpinImage::floors + floor + 1] += part;
    counts[ring] += 1;
  }
  for (std::size_t ring = 0; ring < SpinImage::rings; ++ring)
    for (std::size_t floor = 0; floor < SpinImage::floors; ++floor) {
      float& cell = image.cells[ring * SpinImage::floors + floor];
      cell = counts[ring] < least_in_ring ? 0 : cell / counts[ring];
    }
  return image;
}

void describe_one(Landmarks& marks, double top, const Context& context) {
  context.check();
  const PointTree tree(marks.places);
  marks.images.assign(marks.places.size(), SpinImage{});
  for_blocks(marks.places.size(), landmark_block, [&](std::size_t begin, std::size_t end) {
    std::vector<Index> found;
    for (std::size_t i = begin; i < end; ++i) {
      found.clear();
      tree.within(marks.places[i], support_sides * marks.side, found);
      std::sort(found.begin(), found.end());
      marks.images[i] = image_of(marks, i, found, top);
    }
  });
}

}  // namespace

double landmark_side(std::span<const Point3> a, std::span<const Point3> b, std::size_t target) {
  const double size = std::max(diagonal(a), diagonal(b));
  double side = size / 64;
  if (!(side > 0)) return 1;
  constexpr int rounds = 4;
  for (int i = 0; i < rounds; ++i) {
    const auto count = static_cast<double>(std::max(count_cubes(a, side), count_cubes(b, side)));
    side *= std::clamp(std::sqrt(count / static_cast<double>(target)), 0.25, 4.0);
  }
  return std::clamp(side, size * 1e-4, size);
}

Landmarks landmarks(std::span<const Point3> points, double side, const Context& context) {
  context.check();
  Landmarks marks;
  marks.side = side;
  const std::vector<Cube> cubes = cubes_of(points, side);
  for (std::size_t i = 0; i < cubes.size();) {
    Point3 sum{0, 0, 0};
    std::size_t k = i;
    for (; k < cubes.size() && cubes[k].place == cubes[i].place; ++k) sum = sum + points[cubes[k].id];
    marks.places.push_back((1 / static_cast<double>(k - i)) * sum);
    i = k;
  }
  const PointTree tree(marks.places);
  const std::size_t n = marks.places.size();
  marks.normals.resize(n), marks.heights.resize(n);
  for_blocks(n, landmark_block, [&](std::size_t begin, std::size_t end) {
    std::vector<Index> found;
    for (std::size_t i = begin; i < end; ++i) {
      found.clear();
      tree.within(marks.places[i], support_sides / 2 * side, found);
      std::sort(found.begin(), found.end());
      fit(marks, i, found, marks.normals[i], marks.heights[i]);
    }
  });
  turn_to_one_side(marks, tree);
  return marks;
}

void describe(Landmarks& a, Landmarks& b, const Context& context) {
  double squares = 0, count = 0;
  for (const Landmarks* marks : {&a, &b})
    for (const double h : marks->heights) squares += h * h, count += 1;
  // Normals are of half the support, so heights over the whole of it are some two times larger.
  const double top = std::max(2 * floors_rms * std::sqrt(squares / std::max(1.0, count)), 1e-12 * a.side);
  both([&] { describe_one(a, top, context); }, [&] { describe_one(b, top, context); });
}

float image_distance(const SpinImage& a, const SpinImage& b) {
  float sum = 0, rings = 0;
  for (std::size_t ring = 0; ring < SpinImage::rings; ++ring) {
    const float* p = a.cells.data() + ring * SpinImage::floors;
    const float* q = b.cells.data() + ring * SpinImage::floors;
    float own = 0, mass = 0, other = 0;
    for (std::size_t k = 0; k < SpinImage::floors; ++k) {
      const float d = p[k] - q[k];
      own += d * d, mass += p[k], other += q[k];
    }
    if (mass == 0 || other == 0) continue;
    sum += own, rings += 1;
  }
  constexpr float none = 2;  // no ring in common: as different as two rings can be
  return rings > 0 ? sum / rings : none;
}

SpinImage flipped(const SpinImage& image) {
  SpinImage result;
  for (std::size_t ring = 0; ring < SpinImage::rings; ++ring)
    for (std::size_t k = 0; k < SpinImage::floors; ++k)
      result.cells[ring * SpinImage::floors + k] = image.cells[ring * SpinImage::floors + SpinImage::floors - 1 - k];
  return result;
}

}  // namespace isopach
