// visible: what of a meshed scan is seen from where the direction comes from. The exact answer to folds where a file
// has faces: what lies behind one of them is no part of the height field.
#pragma once
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/field/height_field.hpp"

namespace isopach {

/// One flag per point of the cloud: kept by `field`, the projection of the cloud after `pose`, and under a face of it
/// (by more than rounding). Faces with a corner that `field` dropped hide nothing. Throws UsageError naming --visible
/// where the cloud has no faces. Cost O(n log n). Test: tests/apps/visible_test.cpp.
[[nodiscard]] Array<unsigned char> hidden_points(const CloudView& cloud, const Pose& pose, const Frame& frame,
                                                 const HeightField& field, const Context& context);

/// The cloud without its hidden points, seen after `pose` along the direction of `frame`, and without the faces that
/// had one of them as a corner; a note says how many. Attributes stay with their points. Errors: as hidden_points and
/// project (duplicates are not refused).
[[nodiscard]] Cloud visible_part(const CloudView& cloud, const Pose& pose, const Frame& frame,
                                 const ProjectOptions& options, const Context& context);

}  // namespace isopach
