// Scanner simulations with known truth. A scene is two analytic surfaces f1, f2 over a rectangle, sampled as two scanners
// would sample them; the truth of every volume is known in closed form or by quadrature to a stated error.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"

namespace isopach {

struct SceneOptions {
  std::size_t points_a = 100000, points_b = 100000;  ///< about; scan lines may give a few more or less
  double noise_a = 0, noise_b = 0;                   ///< standard deviation of the heights, in the unit of the scene
  std::string variant;                               ///< scene-specific; empty = default
};

/// What is true of a scene. Volumes are of f2 − f1 over the scene's rectangle; `error` bounds each of them.
struct Truth {
  double area = 0, above = 0, below = 0, net = 0;
  double error = 0;                                  ///< absolute bound of the quadrature; 0 = closed form
  std::map<std::string, double> parts;               ///< named features, e.g. {"mound": 1234.5, "landslide_net": …}
  std::string unit = "m";
};

struct Scene {
  std::string name, description;
  Cloud a, b;
  Truth truth;
};

/// Names of the scenes, in the order of the documentation.
[[nodiscard]] std::vector<std::string> scene_names();

/// Makes a scene. The same options and context.seed give the same bits, whatever the number of threads.
/// Errors: UsageError for an unknown name or variant (lists the known ones) and for sizes that make no sense.
[[nodiscard]] Scene make_scene(const std::string& name, const SceneOptions& options, const Context& context);

}  // namespace isopach
