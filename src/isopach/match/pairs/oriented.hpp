// OrientedCloud: the points of a scan in frame coordinates, in an order of their own, with a k-d tree, normals and the
// boundary. What ICP and the coarse start look for pairs in.
#pragma once
#include <memory>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/distance/box_tree.hpp"
#include "isopach/distance/point_tree.hpp"
#include "isopach/field/height_field.hpp"

namespace isopach {

struct OrientedCloud {
  Array<Point3> points;           ///< frame coordinates, Morton order: a function of the set of points
  Array<Index> ids;               ///< of each in its Cloud
  Array<Point3> normals;          ///< length 1, of either sign; (0, 0, 0) where the neighbours lie on a line
  Array<double> height;           ///< of each point over the plane of its neighbours, along its normal
  Array<unsigned char> boundary;  ///< 1 where the neighbours leave a side open
  Array<double> areas;            ///< of surface that each stands for, over their mean: dense parts weigh no more
  std::unique_ptr<PointTree> tree;
  std::unique_ptr<BoxTree> boxes;  ///< the same points, for one or two nearest
  bool of_means = false;           ///< its points are means of a scan's points
  double slope_noise = 0;          ///< variance (rad²) of a normal that noise alone gives, median over the points
  double roughness = 0;            ///< distance of the neighbours from the plane, RMS, median over the points

  OrientedCloud() = default;
  OrientedCloud(OrientedCloud&&) = default;  // the tree points into `points`, whose memory moves along
  OrientedCloud& operator=(OrientedCloud&&) = default;
};

/// Neighbours that a normal is fitted to, the point included; doubled, up to eight times as many, while they are more
/// of a line than a surface: along one ring of a turning scanner the next ring is farther than many points of the same.
inline constexpr std::size_t normal_neighbours = 16;

/// The kept points of a cloud (project: classes, crop, not finite ones) after `pose`, without normals. `thin` > 0 keeps
/// one point per cube of that side: the first in the order. Cost O(n log n).
[[nodiscard]] OrientedCloud order_points(const CloudView& cloud, const Pose& pose, const Frame& frame,
                                         const ProjectOptions& project, double thin, const Context& context);

/// Means of ordered points within bricks of the Morton order: cubes, or halves or quarters of cubes, of the smallest
/// size that leaves at most `most` of them. A mean has the less noise the more points it is of. Cost O(n). Test:
/// tests/match/means_test.cpp.
struct Means {
  OrientedCloud cloud;    ///< not yet oriented; the id of a mean is that of its first point
  Array<Index> of_point;  ///< of each ordered point
};
[[nodiscard]] Means means_of(const OrientedCloud& cloud, std::size_t most);

/// Normals as orient() finds them, of some points alone. Makes `tree` if there is none.
[[nodiscard]] Array<Point3> normals_at(OrientedCloud& cloud, const Array<Index>& which);

/// What is found of a cloud besides its normals; what is not asked for costs nothing.
struct Orient {
  bool boundary = true;  ///< else none is on it
};

/// Trees, normals by total least squares over the nearest neighbours ([Hoppe1992], section 3.1), and boundary:
/// where, seen along the normal, the neighbours leave an angle of more than 144° open, and on rings eight times as many
/// as well: what is open to the next ring of a turning scanner is no boundary. Cost O(n log n); the same bits for any
/// number of threads. Test: tests/match/oriented_test.cpp.
void orient(OrientedCloud& cloud, const Context& context, const Orient& wanted = {});

}  // namespace isopach
