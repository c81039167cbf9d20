// face_regions: the difference of the two sides of a face by region, from a comparison of the face with its mirror
// image in face coordinates (the symmetry plane is x = 0).
#pragma once
#include <string>
#include <vector>

#include "isopach/apps/mirror.hpp"
#include "isopach/measure/measures.hpp"
#include "isopach/overlay/regions.hpp"

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

/// Polygons that were drawn over a face as it is seen in its file, along the axis nearest to where it looks.
struct FacePolygons {
  std::vector<std::string> names;
  std::vector<Regions> regions;  ///< one polygon each, in the two axes across that one
  Upright place;                 ///< from those axes, the third behind them, to face coordinates
  Point3 origin{0, 0, 0};        ///< of the cells, in face coordinates

  /// Where a point of the cells' coordinates is seen.
  [[nodiscard]] Point2 seen(const Point3& p) const;
};

/// One row a polygon, after the whole. A place x ≥ 0 belongs to a polygon if the face there or the face at its mirror
/// image is seen inside it: so it does not matter on which side a polygon is drawn, and one that crosses the plane
/// counts no pair of places twice. On a cell both are affine in x and y, so it is cut exactly (overlay/regions.hpp) and
/// the integrals, by area in face coordinates, are exact up to rounding. Cost O(cells · polygons). Oracle:
/// tests/apps/face_regions_test.cpp (subdivision, even-odd count).
[[nodiscard]] std::vector<SideDifference> face_regions(const CellView& cells, const FacePolygons& polygons,
                                                       const Context& context);

}  // namespace isopach
