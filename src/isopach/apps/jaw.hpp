// What a sequence of motions says of the joint: the hinge axis, the frame that goes with it, angles about it, smooth
// paths.
//
// The hinge axis is the line of the moving part that moves least: Σ |motion_k(p) − p|² over the frames is quadratic in
// p; its minimiser is a point of the line, the eigenvector of the least eigenvalue of Σ (R_k − 1)ᵀ(R_k − 1) is its
// direction. It is where the motion has its hinge, not where the anatomy has it. Test: tests/apps/jaw_test.cpp.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "isopach/geom/rigid.hpp"

namespace isopach {

struct HingeAxis {
  Point3 point{0, 0, 0};      ///< the point of the line nearest to the one that was asked about
  Point3 direction{0, 0, 0};  ///< unit; the widest opening turns positively about it
  double rest = 0;            ///< RMS way of `point` over the frames: 0 for a pure hinge
};

/// Nothing where no motion turns by `least_angle` (rad) or more: slides have no axis.
[[nodiscard]] std::optional<HingeAxis> hinge_axis(std::span<const Pose> motions, const Point3& near,
                                                  double least_angle);

/// The turn of a motion about `axis` (rad, signed): the twist of its swing–twist decomposition.
[[nodiscard]] double turn_about(const Pose& motion, const Point3& axis);

/// Right-handed axes at the hinge: x along it, z from it towards `front`, y = z × x, which an opening jaw moves
/// against. T_reference_local. Where `front` lies on the axis: z is any direction across.
[[nodiscard]] Pose hinge_frame(const HingeAxis& axis, const Point3& front);

/// Values at times (ascending), each replaced by the weighted least-squares parabola through its neighbours: those
/// nearer than `width` + 1, weights (1 − (Δt/(width + 1))³)³ [Cleveland1979]; a line or the mean where there are fewer
/// than 4 or 3 of them. width 0: as they are.
[[nodiscard]] std::vector<Point3> smooth_path(std::span<const double> times, std::span<const Point3> values,
                                              double width);

}  // namespace isopach
