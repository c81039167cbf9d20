// ScanMeshes: what a comparison makes of its two scans before it looks at them together, for those who need both.
#pragma once
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/field/height_field.hpp"

namespace isopach {

struct ScanMeshes {
  Frame frame;
  HeightField a, b;
  Triangulation t1, t2;
  Array<unsigned char> kept_1, kept_2;      ///< one flag per real triangle: what the borders keep; empty if all are
  Array<unsigned char> folded_1, folded_2;  ///< … and what of it is folded; empty if none is
};

}  // namespace isopach
