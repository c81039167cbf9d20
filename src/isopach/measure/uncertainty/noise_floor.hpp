// The noise floor: what two scans of an unchanged surface with these nodes, this roughness and this noise would show,
// and the gross volume without what they add to it. See the docs page "Noise floor".
#pragma once
#include <vector>

#include "isopach/measure/measures.hpp"
#include "isopach/measure/uncertainty/local_fit.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/overlay.hpp"

namespace isopach {

/// d = f̂2 − f̂1 at nodes, were the surface unchanged.
struct NullDifference {
  Array<double> chord;                ///< error of linear interpolation, as the curvature of the relief makes it
  Array<double> variance;             ///< of the rest, roughly: noise and roughness below the sampling
  std::vector<Array<double>> random;  ///< draws of the rest
};

/// At the nodes of both scans.
struct NullDifferences {
  NullDifference at_1, at_2;
};

/// From each scan alone, so that no change of the surface enters. For each scan local cubics (LocalFits) give the error
/// of a chord at each node of the other, and their residuals the noise: one of the residuals near the node, with a
/// random sign, is a draw of it, that is interpolated like a height. The part of the chords that the noise itself makes
/// is taken off by local shrinking: √(1 − noise²/all²) over stretches of nodes. Random numbers are drawn by the
/// coordinates of the points: exchanging the scans changes all signs, and nothing else. Cost O(nodes).
[[nodiscard]] NullDifferences null_differences(const OverlayMesh& m1, const OverlayMesh& m2, const Context& context);

/// At the nodes of T.
[[nodiscard]] NullDifference unite(const NullDifferences& d, const UnitedNodes& nodes);

struct NoiseFloor {
  double above = 0, below = 0, rho = 0;  ///< that an unchanged surface would show
  Volume debiased;                       ///< net as measured; absolute between |net| and what was measured or more
  double debiased_rho = 0;
};

/// Floor: the measure of the null difference. Debiased: the measured gross less the bias of |·|, which is
/// ∫ |m + null| − ∫ |m| for m the measured difference without chords and with its random part averaged away
/// (`shrink`). Where the change is large nothing is taken off, where there is none the floor is. Cost O(nodes).
/// Test: tests/compare/noise_floor_test.cpp.
[[nodiscard]] NoiseFloor noise_floor(const CellView& cells, const NullDifference& null, const Volume& measured,
                                     const Context& context);

}  // namespace isopach
