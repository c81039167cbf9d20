// isopach demo
#include <fmt/core.h>

#include "cli/command.hpp"
#include "cli/output.hpp"
#include "cli/scene.hpp"
#include "cli/verbs.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/io/write.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "Makes two scans of a scene whose volumes are known, compares them, and writes the report with the truth beside "
    "it.\n";

constexpr const char* footer =
    "Examples:\n"
    "  isopach demo                                     then open isopach-demo/report.html\n"
    "  isopach demo face -o face-demo --points 200000";

}  // namespace

int run_demo(const Arguments& arguments) {
  SceneRequest scene_request;
  Delivery delivery;
  RunOptions run_options;
  Command command("demo", description, footer);
  command.positional("SCENE", scene_request.name, "One of " + scene_list() + " (default terrain)").required(false);
  add_delivery_options(command, delivery, "isopach-demo");
  add_scene_options(command, scene_request);
  add_run_options(command, run_options);
  if (!command.parse(arguments)) return 0;

  Run run(run_options, scene_request.seed);
  OutputFolder folder(delivery.output);
  Stopwatch watch;
  Scene scene = make_scene(scene_request.name, scene_request.scene_options(), run.context());
  if (delivery.map.title.empty()) delivery.map.title = fmt::format("Simulated scans: {}", scene.name);
  scene.a.path = "a.ply";
  scene.b.path = "b.ply";
  write_cloud(folder.path(scene.a.path), scene.a, run.context());
  write_cloud(folder.path(scene.b.path), scene.b, run.context());
  const std::string truth = folder.path("truth.json");
  write_text_atomically(truth, truth_json(truth_of(scene, scene_request), folder.names()));
  const double make_s = watch.lap();

  CompareOptions options;
  options.noise_floor = true;  // gained and lost as near to the truth as they can be told
  Comparison comparison = compare(scene.a, scene.b, options, run.context());
  add_read_time(comparison.timing, make_s);
  deliver(comparison, scene.a, scene.b, scene.truth, delivery, &folder, run, nullptr);
  if (delivery.json != "-") run.show("\nReport: " + folder.final_path("report.html"));
  return 0;
}

}  // namespace isopach::cli
