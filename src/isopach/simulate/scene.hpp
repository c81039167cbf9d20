// Scanner simulations with known truth. A scene is two analytic surfaces f1, f2 over a rectangle, sampled as two
// scanners would sample them; the truth of every volume is known in closed form or by quadrature to a stated error.
//
// Scenes (default variant first):
//   terrain      1 km² of hills in large map coordinates (m, kept to the millimetre, as LAS would); two flights; a
//   landslide
//                whose deposit is 1.25 times its scar, a mound and a pit
//   face         a head seen from the front (mm, +z to the viewer), symmetric in x; the second scan has a swollen cheek
//   plane        lifted: a constant lift over an irregular convex footprint; tilted: a difference that crosses zero
//   paraboloid   a difference h (1 − r²/R²) over a square: zero on a circle
//   cone         a difference h (1 − r/R) over a square: zero on a circle, not smooth at the apex
//   relief       smooth, rough, or rough and unchanged: what interpolation adds to a gross volume
//   worst-case   zigzag against two far columns: the walk along the spanning tree is quadratic here (constructed nodes;
//   the
//                seed acts on the noise alone)
// Tests: tests/simulate/scene_test.cpp (truth against quadrature of the surfaces), tests/simulate/sampling_test.cpp
#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/simulate/sampling.hpp"

namespace isopach {

struct SceneOptions {
  std::size_t points_a = 100000, points_b = 100000;  ///< about; scan lines may give a few more or less
  double noise_a = 0, noise_b = 0;                   ///< standard deviation of the heights, in the unit of the scene
  std::string variant;                               ///< scene-specific; empty = default
};

/// What is true of a scene. Volumes are of f2 − f1 over the scene's footprint; `error` bounds each of them. Of terrain
/// and face the scans reach the footprint's border only to within a point spacing, so that the measured area is a
/// little less; their volumes lie well inside. Of the other scenes the overlap of the hulls is the footprint.
struct Truth {
  double area = 0, above = 0, below = 0, net = 0;
  double error = 0;                     ///< absolute bound of the quadrature; 0 = closed form
  std::map<std::string, double> parts;  ///< signed volumes of named features, e.g. {"mound": 7162.83, …}
  std::string unit = "m";
};

struct Scene {
  std::string name, description;
  Cloud a, b;
  Truth truth;
  Outline footprint;  ///< convex, counter-clockwise
};

/// Names of the scenes, in the order of the documentation.
[[nodiscard]] std::vector<std::string> scene_names();

/// Variants of a scene, the default first; empty if there is only one. Errors: UsageError for an unknown name.
[[nodiscard]] std::vector<std::string> scene_variants(const std::string& name);

/// Sizes and noise that suit a scene: what its real scanners would give. Errors: UsageError for an unknown name.
[[nodiscard]] SceneOptions scene_defaults(const std::string& name);

/// The surface itself, without scanner: z = f(x, y) of epoch 1 (scan a) or 2 (scan b), in the scene's coordinates. It
/// does not depend on the seed. Errors: UsageError for an unknown name, variant or epoch.
[[nodiscard]] std::function<double(double x, double y)> scene_surface(const std::string& name,
                                                                      const std::string& variant, int epoch);

/// Makes a scene. The same options and context.seed give the same bits, whatever the number of threads. Cost:
/// O(points). Errors: UsageError for an unknown name or variant (lists the known ones), fewer points than a scan of
/// this scene needs (4; terrain and face 100), more than max_nodes, or a noise that is negative or not finite.
[[nodiscard]] Scene make_scene(const std::string& name, const SceneOptions& options, const Context& context);

}  // namespace isopach
