// PointTree: nearest points and points near a place, by nanoflann's k-d tree.
#pragma once
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/types.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

class PointTree {
 public:
  /// `points` is kept by reference. Cost O(n log n).
  explicit PointTree(std::span<const Point3> points);
  ~PointTree();
  PointTree(const PointTree&) = delete;
  PointTree& operator=(const PointTree&) = delete;

  /// Squared distance to the nearest point; infinity if there are none. Oracle: tests/distance/point_tree_test.cpp.
  [[nodiscard]] double nearest_distance2(const Point3& p) const;

  /// The two nearest points and their squared distances; no_index and infinity where there are fewer. Which of two
  /// equally near ones comes first depends on the order of the points alone. Oracle: the same test.
  struct Two {
    Index first = no_index, second = no_index;
    double first2 = std::numeric_limits<double>::infinity(), second2 = std::numeric_limits<double>::infinity();
  };
  [[nodiscard]] Two nearest_two(const Point3& p) const;

  /// The min(k, n) nearest points, nearest first, into `found`, which is emptied.
  void nearest(const Point3& p, std::size_t k, std::vector<Index>& found) const;

  /// Appends the indices of all points at `radius` from p or nearer, in no particular order.
  void within(const Point3& p, double radius, std::vector<Index>& found) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace isopach
