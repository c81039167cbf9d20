// ThinPoints: a few thousand points that stand for a scan in space: means of cells, with normals and a k-d tree. What
// the search for the pose of a face works on.
#pragma once
#include <memory>
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/distance/point_tree.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

struct ThinPoints {
  Array<Point3> points;
  Array<Point3> normals;  ///< length 1, of either sign, by total least squares over the neighbours
  std::unique_ptr<PointTree> tree;
  double spacing = 0;  ///< median distance of a point from its nearest neighbour

  ThinPoints() = default;
  ThinPoints(ThinPoints&&) = default;  // the tree points into `points`, whose memory moves along
  ThinPoints& operator=(ThinPoints&&) = default;
};

/// Means of the points in cubes of a side that leaves about `wanted` of them (all points if there are no more), normals
/// over `neighbours` others. `points` come in an order that is a function of the set (see order_points); so is the
/// result, the same bits for any number of threads. Cost O(n log n). Test: tests/apps/face_pose_test.cpp.
[[nodiscard]] ThinPoints thin_points(std::span<const Point3> points, std::size_t wanted, std::size_t neighbours);

/// The nearest of some points, read off a grid of cells: the one that is nearest to the middle of the cell.
class NearestGrid {
 public:
  /// Along the longest side of the box, widened by an eighth on every side, there are `cells`. Cost O(cells³ log n).
  NearestGrid(const ThinPoints& points, std::size_t cells);

  /// Index of a point near p; p outside the box counts as on its border.
  [[nodiscard]] Index near(const Point3& p) const {
    const std::size_t i = cell(p.x - lowest_.x, sides_[0]), j = cell(p.y - lowest_.y, sides_[1]);
    return nearest_[(i * sides_[1] + j) * sides_[2] + cell(p.z - lowest_.z, sides_[2])];
  }

 private:
  [[nodiscard]] std::size_t cell(double along, std::size_t side) const {
    const double k = along / step_;
    if (!(k > 0)) return 0;
    return k < static_cast<double>(side) ? static_cast<std::size_t>(k) : side - 1;
  }

  Point3 lowest_{0, 0, 0};
  double step_ = 1;
  std::size_t sides_[3] = {1, 1, 1};
  Array<Index> nearest_;
};

}  // namespace isopach
