// hillshade: light and shadow of surface A, so that a map of differences shows the ground (or the face) it lies on.
// Lambert's cosine, light from the north-west (azimuth 315°, altitude 45°), slopes by central differences.
#pragma once
#include "isopach/base/array.hpp"
#include "isopach/report/draw/raster.hpp"

namespace isopach {

struct Hillshade {
  Array<float> grey;        ///< 0.35 (in shadow) … 1 (facing the light), per pixel of the raster
  double exaggeration = 1;  ///< heights were multiplied by this, so that flat and steep scenes both read
};

[[nodiscard]] Hillshade hillshade(const CellRaster& raster);

}  // namespace isopach
