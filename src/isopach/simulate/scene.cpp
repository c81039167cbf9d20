#include "isopach/simulate/scene.hpp"

#include <cmath>

#include <fmt/format.h>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/simulate/model.hpp"

namespace isopach {
namespace {

std::vector<SceneModel> models() {
  return {terrain_scene(), face_scene(),   plane_scene(), paraboloid_scene(),
          cone_scene(),    relief_scene(), skin_scene(),  worst_case_scene()};
}

SceneModel find_model(const std::string& name) {
  for (SceneModel& model : models())
    if (model.name == name) return std::move(model);
  throw UsageError(fmt::format("unknown scene '{}': choose one of {}", name, fmt::join(scene_names(), ", ")));
}

int find_variant(const SceneModel& model, const std::string& variant) {
  if (variant.empty()) return 0;
  for (std::size_t i = 0; i < model.variants.size(); ++i)
    if (model.variants[i] == variant) return static_cast<int>(i);
  if (model.variants.empty())
    throw UsageError(fmt::format("unknown variant '{}': scene {} has no variants", variant, model.name));
  throw UsageError(fmt::format("unknown variant '{}' of scene {}: choose one of {}", variant, model.name,
                               fmt::join(model.variants, ", ")));
}

void check_scan(const SceneModel& model, const char* scan, std::size_t points, double noise) {
  if (points < model.least_points)
    throw UsageError(fmt::format("{} points for scan {} are too few: scene {} needs at least {}", points, scan,
                                 model.name, model.least_points));
  if (points > max_nodes)
    throw UsageError(fmt::format("{} points for scan {} are too many: ask for at most {}", points, scan, max_nodes));
  if (!(noise >= 0) || !std::isfinite(noise))
    throw UsageError(fmt::format("noise {} for scan {} makes no sense: give a standard deviation >= 0", noise, scan));
}

double rounded(double value, double steps_per_unit) {
  return steps_per_unit > 0 ? std::round(value * steps_per_unit) / steps_per_unit : value;
}

Cloud scan(const SceneModel& model, int variant, int epoch, const Array<Point2>& nodes, double noise,
           std::uint64_t seed) {
  const RandomStream random(seed, static_cast<std::uint64_t>(epoch));
  const double steps = model.steps_per_unit;
  Cloud cloud;
  cloud.points.resize(nodes.size());
  for_each_index(nodes.size(), [&](std::size_t i) {
    const double x = rounded(nodes[i].x, steps), y = rounded(nodes[i].y, steps);
    const double error = noise > 0 ? noise * random.normal(i) : 0;
    cloud.points[i] = {x, y, rounded(model.height(variant, epoch, x, y) + error, steps)};
  });
  cloud.format = "simulated";
  cloud.unit = cloud.vertical_unit = model.unit;
  return cloud;
}

}  // namespace

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const SceneModel& model : models()) names.push_back(model.name);
  return names;
}

std::vector<std::string> scene_variants(const std::string& name) { return find_model(name).variants; }

SceneOptions scene_defaults(const std::string& name) { return find_model(name).defaults; }

std::function<double(double, double)> scene_surface(const std::string& name, const std::string& variant, int epoch) {
  const SceneModel model = find_model(name);
  if (epoch != 1 && epoch != 2) throw UsageError(fmt::format("unknown epoch {}: choose 1 or 2", epoch));
  return [height = model.height, index = find_variant(model, variant), epoch](double x, double y) {
    return height(index, epoch, x, y);
  };
}

Scene make_scene(const std::string& name, const SceneOptions& options, const Context& context) {
  const SceneModel model = find_model(name);
  const int variant = find_variant(model, options.variant);
  check_scan(model, "A", options.points_a, options.noise_a);
  check_scan(model, "B", options.points_b, options.noise_b);
  Scene scene;
  scene.name = model.name;
  scene.description = model.description;
  scene.footprint = model.footprint(variant, options);
  scene.truth = model.truth(variant, scene.footprint);
  scene.truth.unit = model.unit;
  const auto make_scan = [&](int epoch, std::size_t count, double noise) {
    const Array<Point2> nodes = model.nodes(epoch, scene.footprint, count, context.seed);
    return scan(model, variant, epoch, nodes, noise, context.seed);
  };
  run_with_threads(context, [&] {
    context.step("simulate", 0);
    scene.a = make_scan(1, options.points_a, options.noise_a);
    context.step("simulate", 0.5);
    scene.b = make_scan(2, options.points_b, options.noise_b);
    context.step("simulate", 1);
  });
  return scene;
}

}  // namespace isopach
