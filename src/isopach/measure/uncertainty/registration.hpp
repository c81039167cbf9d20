// registration: what an error of the pose of scan B does to heights and volumes, to first order.
//
// A small motion (ω, t) about a centre c takes a point p of surface B to p + ω × (p − c) + t. Above a fixed place the
// height of B then changes by n · (ω × (p − c) + t) with n = (−∂z/∂x, −∂z/∂y, 1), which is linear in the six numbers:
// the gradient is ((p − c) × n, n). On a cell where B is linear n is constant, so the integral over the cell is exact.
// The domain is taken as it is: that the rim of B moves, too, is not counted.
#pragma once
#include <array>
#include <span>

#include "isopach/field/height_field.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/uncertainty/uncertainty.hpp"

namespace isopach {

/// What is wrong with a covariance in words ("" if nothing is): numbers that are not finite, not symmetric, or with a
/// negative variance along some direction, beyond rounding.
[[nodiscard]] std::string fault_of(const PoseCovariance& covariance);

/// The same covariance with axes and centre in frame coordinates.
[[nodiscard]] PoseCovariance in_frame(const PoseCovariance& covariance, const Frame& frame);

/// Change of a number by a motion of B: turns about x, y, z (rad), then shifts along x, y, z; frame axes.
using MotionGradient = std::array<double, 6>;

/// Of the height of surface B over p, which lies on it, where it rises by `slope` along x and y.
[[nodiscard]] MotionGradient motion_gradient(const Point3& p, const Point2& slope, const Point3& centre);

/// gᵀ C g, never below 0.
[[nodiscard]] double variance(const MotionGradient& g, const PoseCovariance& covariance);

/// Of the three volumes: the integrals of motion_gradient over the domain, over d > 0 and over d < 0.
struct VolumeMotions {
  MotionGradient net{}, above{}, below{};
};

/// Over the cells of T or of the overlay. Compensated sums over fixed blocks. Cost O(cells). Oracle:
/// tests/measure/registration_test.cpp (scans that are moved, by differences).
[[nodiscard]] VolumeMotions volume_motions(const CellView& cells, const Point3& centre, const Context& context);
[[nodiscard]] VolumeMotions volume_motions(const OverlayCells& cells, const Point3& centre, const Context& context);

/// Standard deviation of the height of B at each of its nodes, `covariance` in frame coordinates. The slope at a node
/// is the mean of those of the triangles round it that are kept, by area; 0 where there is none. Cost O(nodes).
[[nodiscard]] Array<double> height_deviations(const OverlayMesh& b, const PoseCovariance& covariance,
                                              const Context& context);

}  // namespace isopach
