// face_regions: the difference of the two sides of a face by region, from a comparison of the face with its mirror
// image in face coordinates (the symmetry plane is x = 0).
#pragma once
#include <string>
#include <vector>

#include "isopach/measure/measures.hpp"

namespace isopach {

/// Regions besides the whole: upper, middle and lower third, or upper and lower half, of the height (y) of the domain.
enum class FaceParts { thirds, halves };

/// The positive side of a region against its mirror image on the negative side.
struct SideDifference {
  std::string name;
  double area = 0;         ///< of the positive side
  Volume volume;           ///< above: where the positive side stands out further; net: directional
  double directional = 0;  ///< net / area: which side stands out, and how far on average
  double absolute = 0;     ///< absolute / area: how much the sides differ, whichever stands out
  double rms = 0;
  double largest = 0;  ///< |d|
};

/// Cells are cut at x = 0 and at the borders of the parts; d is linear on each, so the integrals are exact up to
/// rounding. The whole comes first. A part without area has zeros. Cost O(cells). Oracle:
/// tests/apps/face_regions_test.cpp (subdivision).
[[nodiscard]] std::vector<SideDifference> face_regions(const CellView& cells, FaceParts parts, const Context& context);

}  // namespace isopach
