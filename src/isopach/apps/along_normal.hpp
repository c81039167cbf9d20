// along_normal: differences along the normal of the surface instead of along the direction.
//
// Along the direction a wall of slope θ shows every deviation 1 / cos θ times, so a few steep facets rule a mean
// square. Along the normal it is d · cos θ, to first order in the deviation.
#pragma once
#include <vector>

#include "isopach/compare/comparison.hpp"
#include "isopach/overlay/pair.hpp"

namespace isopach {

/// The cells of a comparison with d · cos θ in the place of d. θ at a node is the steeper one of the two scans: of its
/// own the mean slope of the facets around it that are kept and not folded, by area, of the other the mean of these
/// over the corners of the triangle there (root mean square); what the noise of the heights adds to the square is taken
/// off, so that rough ground does not pass for a slope. Areas stay those in the plane. `c` and `scans` come from one
/// comparison without polygons or mask. Cost: that of localise_in_order. Test: tests/apps/accuracy_test.cpp.
class NormalCells {
 public:
  NormalCells(const Comparison& c, const Pair& scans, const Context& context);
  /// As long as the comparison lives.
  [[nodiscard]] CellView view() const {
    return {c_.cells.triangulation, c_.cells.xy, zero_, d_, c_.cells.in_domain, pieces_};
  }

 private:
  const Comparison& c_;
  Array<double> zero_, d_;
  std::vector<CellPiece> pieces_;
};

}  // namespace isopach
