// M3C2: distances between two point clouds along the normals of core points, with a level of detection.
//
// Source: [Lague2013]. Names of the parameters are those of the paper.
#pragma once
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

struct M3c2Options {
  double normal_scale = 0;        ///< D: diameter of the ball in the first cloud whose plane gives the normal
  double projection_scale = 0;    ///< d: diameter of the cylinder along the normal
  double max_depth = 0;           ///< the cylinder reaches this far from the core point, to either side
  double registration_error = 0;  ///< reg: of the alignment of the two clouds
};

/// One value per core point. NaN where there is none.
struct M3c2Field {
  Array<double> distance;        ///< mean of the second cloud less that of the first, along the normal
  Array<double> lod;             ///< level of detection at 95 %; NaN for fewer than m3c2_least points in either cloud
  Array<double> significant;     ///< 1 where |distance| > lod, else 0
  Array<double> sigma1, sigma2;  ///< standard deviation along the normal (divided by n), the local roughness
  Array<double> n1, n2;          ///< points in the cylinder
  Array<Point3> normal;          ///< unit, up: z ≥ 0; NaN where the ball holds no plane
};

/// Fewer points have no standard deviation that a level of detection could rest on.
inline constexpr int m3c2_least = 4;

/// LOD = 1.96 (sqrt(σ1²/n1 + σ2²/n2) + reg), equation (1) of the paper. Normal: of the plane through the points of the
/// first cloud at D/2 or nearer; none where these are fewer than 3 or lie on a line. A function of the three sets of
/// points. Cost: the points in the balls. Oracles: tests/distance/m3c2_test.cpp (every point tried; the results of
/// CloudCompare and PDAL on shared data).
[[nodiscard]] M3c2Field m3c2(std::span<const Point3> first, std::span<const Point3> second,
                             std::span<const Point3> cores, const M3c2Options& options, const Context& context);

}  // namespace isopach
