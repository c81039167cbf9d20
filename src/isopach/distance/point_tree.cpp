#include "isopach/distance/point_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <type_traits>

namespace isopach {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// What nanoflann wants to know of the points.
struct Points {
  std::span<const Point3> points;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    const Point3& p = points[i];
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Metric = nanoflann::L2_Simple_Adaptor<double, Points, double, Index>;
using KdTree = nanoflann::KDTreeSingleIndexAdaptor<Metric, Points, 3, Index>;

/// The results nanoflann writes to; names and types are its own.
struct Nearest {
  using DistanceType = double;
  using IndexType = Index;
  using CountType = std::size_t;
  double best = infinity;
  CountType count = 0;

  [[nodiscard]] CountType size() const { return count; }
  [[nodiscard]] bool empty() const { return count == 0; }
  [[nodiscard]] bool full() const { return count > 0; }
  [[nodiscard]] double worstDist() const { return best; }
  bool addPoint(double distance2, Index) {
    if (distance2 < best) best = distance2, count = 1;
    return true;
  }
  void sort() {}
};

struct NearestTwo {
  using DistanceType = double;
  using IndexType = Index;
  using CountType = std::size_t;
  PointTree::Two two;
  CountType count = 0;

  [[nodiscard]] CountType size() const { return count; }
  [[nodiscard]] bool empty() const { return count == 0; }
  [[nodiscard]] bool full() const { return count >= 2; }
  [[nodiscard]] double worstDist() const { return two.second2; }
  bool addPoint(double distance2, Index i) {
    if (distance2 < two.first2) {
      two.second = two.first, two.second2 = two.first2;
      two.first = i, two.first2 = distance2;
    } else if (distance2 < two.second2) {
      two.second = i, two.second2 = distance2;
    }
    ++count;
    return true;
  }
  void sort() {}
};

struct Within {
  using DistanceType = double;
  using IndexType = Index;
  using CountType = std::size_t;
  double limit;   ///< squared
  double beyond;  ///< the next double: nanoflann offers what is nearer than the worst, and the limit itself counts
  std::vector<Index>& found;

  [[nodiscard]] CountType size() const { return found.size(); }
  [[nodiscard]] bool empty() const { return found.empty(); }
  [[nodiscard]] bool full() const { return true; }
  [[nodiscard]] double worstDist() const { return beyond; }
  bool addPoint(double distance2, Index i) {
    if (distance2 <= limit) found.push_back(i);
    return true;
  }
  void sort() {}
};

// nanoflann 1.5 renamed the parameters of a search; the type is read off the function.
template <class Result, class Parameters>
Parameters parameters_of(bool (KdTree::*)(Result&, const double*, const Parameters&) const);
template <class Result>
using ParametersOf = decltype(parameters_of<Result>(&KdTree::template findNeighbors<Result>));

template <class Result>
void find(const KdTree& tree, Result& result, const Point3& p) {
  const double place[3] = {p.x, p.y, p.z};
  tree.findNeighbors(result, place, std::decay_t<ParametersOf<Result>>());
}

}  // namespace

struct PointTree::Tree {
  Points points;
  KdTree kd;
  explicit Tree(std::span<const Point3> p) : points{p}, kd(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(12)) {}
};

PointTree::PointTree(std::span<const Point3> points) : tree_(std::make_unique<Tree>(points)) {}
PointTree::~PointTree() = default;

double PointTree::nearest_distance2(const Point3& p) const {
  Nearest nearest;
  if (!tree_->points.points.empty()) find(tree_->kd, nearest, p);
  return nearest.best;
}

PointTree::Two PointTree::nearest_two(const Point3& p) const {
  NearestTwo nearest;
  if (!tree_->points.points.empty()) find(tree_->kd, nearest, p);
  return nearest.two;
}

void PointTree::nearest(const Point3& p, std::size_t k, std::vector<Index>& found) const {
  k = std::min(k, tree_->points.points.size());
  found.resize(k);
  if (k == 0) return;
  constexpr std::size_t room = 64;
  double few[room];
  std::vector<double> many(k > room ? k : 0);
  nanoflann::KNNResultSet<double, Index> result(k);
  result.init(found.data(), k > room ? many.data() : few);
  find(tree_->kd, result, p);
}

void PointTree::within(const Point3& p, double radius, std::vector<Index>& found) const {
  if (tree_->points.points.empty()) return;
  const double limit = radius * radius;
  Within within{limit, std::nextafter(limit, infinity), found};
  find(tree_->kd, within, p);
}

}  // namespace isopach
