// PointTree: nearest points and points near a place, by nanoflann's k-d tree.
#pragma once
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

  /// Appends the indices of all points at `radius` from p or nearer, in no particular order.
  void within(const Point3& p, double radius, std::vector<Index>& found) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace isopach
