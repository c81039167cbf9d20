// A scene before it is scanned: one of these per scene, made by the file of its name; scene.cpp scans any of them.
#pragma once
#include <string>
#include <vector>

#include "isopach/simulate/sampling.hpp"
#include "isopach/simulate/scene.hpp"

namespace isopach {

/// `variant` is an index into `variants` (0 where there are none); `epoch` is 1 or 2.
struct SceneModel {
  std::string name, description, unit;
  std::vector<std::string> variants;
  SceneOptions defaults;
  std::size_t least_points = 4;
  double steps_per_unit = 0;  ///< coordinates are whole multiples of 1/steps_per_unit; 0: not rounded
  double (*height)(int variant, int epoch, double x, double y) = nullptr;
  Outline (*footprint)(int variant, const SceneOptions& options) = nullptr;
  Truth (*truth)(int variant, const Outline& footprint) = nullptr;
  Array<Point2> (*nodes)(int epoch, const Outline& footprint, std::size_t count, std::uint64_t seed) = nullptr;
};

[[nodiscard]] SceneModel terrain_scene();
[[nodiscard]] SceneModel face_scene();
[[nodiscard]] SceneModel plane_scene();
[[nodiscard]] SceneModel paraboloid_scene();
[[nodiscard]] SceneModel cone_scene();
[[nodiscard]] SceneModel relief_scene();
[[nodiscard]] SceneModel worst_case_scene();

}  // namespace isopach
