// isopach simulate SCENE -o DIR
#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "cli/answer.hpp"
#include "cli/command.hpp"
#include "cli/other_scenes.hpp"
#include "cli/output.hpp"
#include "cli/scene.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/write.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "Scans of a simulated scene, as scanners would sample it, and its true values. Most scenes are two scans of one\n"
    "surface, a and b, with the volumes between them.\n";

constexpr const char* footer =
    "Examples:\n"
    "  isopach simulate terrain -o scans\n"
    "  isopach simulate face -o scans --points 300000 --noise 0.02 --noise-b 0.2\n"
    "  isopach simulate chewing -o frames --frames 40 --points 20000\n"
    "  isopach compare scans/a.ply scans/b.ply";

enum class Format { ply, las, xyz };

/// Makes the scans of any scene, one after the other.
SceneTruth make_scans(const SceneRequest& request, std::size_t frames, const TakeScan& take, const Context& context) {
  if (request.name == "chewing") return simulate_chewing(request, frames, take, context);
  if (frames > 0) throw UsageError("--frames: is an option of the scene chewing");
  if (request.name == "combine") return simulate_combine(request, take);
  if (request.name == "accuracy") return simulate_accuracy(request, take);
  if (request.name == "scanners") return simulate_scanners(request, take);
  Scene scene = make_scene(request.name, request.scene_options(), context);
  const std::string summary = fmt::format("{}: {}\na: {} points, b: {} points", scene.name, scene.description,
                                          scene.a.points.size(), scene.b.points.size());
  take("a", std::move(scene.a));
  take("b", std::move(scene.b));
  return {truth_of(scene, request), summary};
}

/// For a program: scans that keep in memory, as files would have kept them.
std::unique_ptr<SceneAnswer> scene_in_memory(const SceneRequest& request, std::size_t frames, const Context& context) {
  auto answer = std::make_unique<SceneAnswer>();
  const auto take = [&](const std::string& name, Cloud scan) {
    scan.path = name;
    answer->scans.emplace_back(name, std::make_shared<const Cloud>(std::move(scan)));
  };
  answer->truth = make_scans(request, frames, take, context).truth.dump(2) + "\n";
  return answer;
}

}  // namespace

int run_simulate(const Arguments& arguments) {
  SceneRequest scene_request;
  std::string output;
  Format format = Format::ply;
  RunOptions run_options;
  Command command("simulate", description, footer);
  command.positional("SCENE", scene_request.name,
                     "One of " + scene_list() +
                         ", chewing (a sequence of frames), combine (face, jaw and reference object), "
                         "accuracy (a reconstruction and its reference), scanners (a, b and their reference)");
  command.heading("Output");
  command.option("-o,--output", "DIR", output, "Folder for the scans and truth.json; made if it is not there")
      .required(session().shell)
      .check(not_empty());
  command.choice<Format>("--format", format, {{"ply", Format::ply}, {"las", Format::las}, {"xyz", Format::xyz}},
                         "Format of the scans");
  add_scene_options(command, scene_request);
  std::size_t frames = 0;
  command.option("--frames", "N", frames, "chewing: frames of the sequence (default 60)")
      .check(whole_number(1, 100000));
  add_run_options(command, run_options);
  if (!command.parse(arguments)) return 0;

  Run run(run_options, scene_request.seed);
  if (!session().shell) return finish(scene_in_memory(scene_request, frames, run.context()), {}, nullptr, run);
  OutputFolder folder(output);
  const std::string extension = format == Format::ply ? ".ply" : format == Format::las ? ".las" : ".xyz";
  const auto take = [&](const std::string& name, const Cloud& scan) {
    write_cloud(folder.path(name + extension), scan, run.context());
  };
  SceneTruth made = make_scans(scene_request, frames, take, run.context());
  const std::string truth = folder.path("truth.json");
  write_text_atomically(truth, truth_json(std::move(made.truth), folder.names()));
  run.context().check();
  folder.commit();
  const std::vector<std::string> pairs = scene_names();
  const bool is_pair = std::find(pairs.begin(), pairs.end(), scene_request.name) != pairs.end();
  run.show(is_pair ? fmt::format("{}, in {}", made.summary, output) : made.summary);
  return 0;
}

}  // namespace isopach::cli
