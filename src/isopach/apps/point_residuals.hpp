// point_residuals: how the points of a scan lie about the surface of another, apart into bias, form and noise.
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/compare/comparison.hpp"

namespace isopach {

/// Of the heights of points above the other surface, unit of heights.
struct PointResiduals {
  std::size_t count = 0;  ///< points over the other surface
  double bias = 0;        ///< mean
  double rms = 0;
  double std = 0;    ///< about the mean: form and noise together
  double noise = 0;  ///< what neighbouring points do not share
  double form = 0;   ///< what they do: deviations of the shape, about the bias
};

/// Patches of 16 neighbouring points (a run along the curve): the noise is the standard deviation about the plane of a
/// patch, from the median of their variances (of 13 degrees of freedom), so that steps and outliers in less than half
/// of them do not count; the form is what the means of patches scatter more than that noise would make them. The
/// surface of the other scan is taken as it is: its own noise σ appears in `noise` as about σ²/2 more variance, as does
/// its error of interpolation. `field` is dz_signed of the cloud's points. A function of the set of points. Cost: that
/// of `project`. Test: tests/apps/accuracy_test.cpp.
[[nodiscard]] PointResiduals point_residuals(const CloudView& cloud, const Pose& pose, const Frame& frame,
                                             const ProjectOptions& options, const Array<double>& field,
                                             const Context& context);

}  // namespace isopach
