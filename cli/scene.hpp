// What simulate and demo share: the options of a scene, and its truth as JSON.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "cli/command.hpp"
#include "isopach/simulate/scene.hpp"

namespace isopach::cli {

struct SceneRequest {
  std::string name = "terrain", variant;
  std::optional<std::size_t> points, points_b;  ///< without them the scene's own; b without its own option as a
  std::optional<double> noise, noise_b;
  std::uint64_t seed = 1;

  [[nodiscard]] SceneOptions scene_options() const;
};

/// Names of the scenes, "a, b, c".
[[nodiscard]] std::string scene_list();
void add_scene_options(Command& command, SceneRequest& request);
/// What truth.json says, less its last key, `outputs`.
[[nodiscard]] nlohmann::ordered_json truth_of(const Scene& scene, const SceneRequest& request);
/// The text of truth.json. `outputs`: the files written, truth.json among them.
[[nodiscard]] std::string truth_json(nlohmann::ordered_json truth, const std::vector<std::string>& outputs);

}  // namespace isopach::cli
