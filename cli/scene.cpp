#include "cli/scene.hpp"

namespace isopach::cli {

SceneOptions SceneRequest::scene_options() const {
  SceneOptions options = scene_defaults(name);
  if (points) options.points_a = options.points_b = *points;
  if (points_b) options.points_b = *points_b;
  if (noise) options.noise_a = options.noise_b = *noise;
  if (noise_b) options.noise_b = *noise_b;
  options.variant = variant;
  return options;
}

std::string scene_list() {
  std::string all;
  for (const std::string& name : scene_names()) all += (all.empty() ? "" : ", ") + name;
  return all;
}

void add_scene_options(Command& command, SceneRequest& request) {
  command.heading("Scene");
  command.option("--points", "N", request.points, "Points of each scan, about (default: the scene's own)")
      .check(whole_number(1));
  command.option("--points-b", "N", request.points_b, "Points of scan b (default: as --points)").check(whole_number(1));
  command
      .option("--noise", "SIGMA", request.noise,
              "Standard deviation of the heights, in the unit of the scene (default: its own)")
      .check(not_negative());
  command.option("--noise-b", "SIGMA", request.noise_b, "The same of scan b (default: as --noise)")
      .check(not_negative());
  command.option("--variant", "NAME", request.variant, "Variant of the scene; an unknown name lists the known ones");
  add_seed(command, request.seed);
}

nlohmann::ordered_json truth_of(const Scene& scene, const SceneRequest& request) {
  const SceneOptions options = request.scene_options();
  const Truth& truth = scene.truth;
  nlohmann::ordered_json json;
  json["schema"] = "isopach.truth/1";
  json["scene"] = scene.name;
  json["description"] = scene.description;
  json["parameters"] = {{"points_a", options.points_a}, {"points_b", options.points_b}, {"noise_a", options.noise_a},
                        {"noise_b", options.noise_b},   {"variant", options.variant},   {"seed", request.seed}};
  json["unit"] = truth.unit;
  json["area"] = truth.area;
  json["volume"] = {{"above", truth.above}, {"below", truth.below}, {"net", truth.net}, {"error", truth.error}};
  json["parts"] = nlohmann::ordered_json::object();
  for (const auto& [name, value] : truth.parts) json["parts"][name] = value;
  return json;
}

std::string truth_json(nlohmann::ordered_json truth, const std::vector<std::string>& outputs) {
  truth["outputs"] = outputs;
  return truth.dump(2) + "\n";
}

}  // namespace isopach::cli
