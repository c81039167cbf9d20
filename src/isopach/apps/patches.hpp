// Patches of 16 neighbouring places: what of the values there a plane, or a quadratic surface, does not explain.
#pragma once
#include <Eigen/Core>

#include "isopach/geom/vec.hpp"

namespace isopach {

inline constexpr int patch = 16;

template <int columns>
using PatchValues = Eigen::Matrix<double, patch, columns>;

/// Takes the plane of least squares off each column of `values` (1 or 2), which belong to the places `xy` (one row
/// each). Gives the degrees of freedom that are left: 13, or more where the places lie on a line (14) or are one (15).
template <int columns>
int take_off_plane(const PatchValues<2>& xy, PatchValues<columns>& values);

/// Takes the quadratic surface of least squares off each column of `values` (3): what a patch shows of waves much
/// longer than itself is curvature, and that is none of its detail. Test: Scanners.TheCurvatureOfLongWavesIsNoDetail.
void take_off_quadratic(const PatchValues<2>& xy, PatchValues<3>& values);

/// Variance of `values` about their plane, so scaled that the median over many patches is that of normal noise: the
/// median of chi² over its degrees of freedom is (1 − 2/(9 n))³ [Wilson1931].
[[nodiscard]] double patch_variance(const PatchValues<2>& xy, PatchValues<1> values);

}  // namespace isopach
