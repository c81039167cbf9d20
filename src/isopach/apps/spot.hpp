// find_spot: over how wide a spot a scanner averages the object, and its noise without what the spot hides.
#pragma once
#include "isopach/match/surface/surface.hpp"

namespace isopach {

struct Spot {
  double width = 0;  ///< diameter; 0: a point, as far as can be told
  double noise = 0;  ///< of the heights about the reference averaged over it, without that of the reference
};

/// A coarse scanner shows the mean over a spot, about as wide as its points are apart. What it hides would count as its
/// noise: detail that neighbouring points do not share. So the residuals are taken about the mean of the reference over
/// discs of a quarter to twice the spacing of the scan (nine widths, 2^(3/8) apart), and the width is the one with the
/// least noise; it is 0 unless that is less than `spot_gain` of the variance without a spot, and where the disc would
/// hold fewer than two nodes of the reference. Noise as in point_residuals, of at most 512 patches. `reference_sigma`
/// is taken off: half of its variance at a point, one part in as many as the nodes that a disc holds. `scan` and
/// `reference` are of one frame. Cost: O(512 · nodes of the reference under a patch). Test:
/// tests/apps/scanners_test.cpp.
[[nodiscard]] Spot find_spot(const HeightField& scan, const MatchSurface& reference, double spacing,
                             double reference_sigma, const Context& context);

inline constexpr double spot_gain = 0.9;

}  // namespace isopach
