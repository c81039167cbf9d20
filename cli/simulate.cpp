// isopach simulate SCENE -o DIR
#include <fmt/core.h>

#include "cli/command.hpp"
#include "cli/other_scenes.hpp"
#include "cli/output.hpp"
#include "cli/scene.hpp"
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
      ->required()
      ->check(not_empty());
  command.choice<Format>("--format", format, {{"ply", Format::ply}, {"las", Format::las}, {"xyz", Format::xyz}},
                         "Format of the scans");
  add_scene_options(command, scene_request);
  std::size_t frames = 0;
  command.option("--frames", "N", frames, "chewing: frames of the sequence (default 60)")
      ->check(whole_number(1, 100000));
  add_run_options(command, run_options);
  if (!command.parse(arguments)) return 0;

  Run run(run_options, scene_request.seed);
  OutputFolder folder(output);
  const std::string extension = format == Format::ply ? ".ply" : format == Format::las ? ".las" : ".xyz";
  if (scene_request.name == "chewing") return simulate_chewing(scene_request, frames, extension, folder, run);
  if (frames > 0) throw UsageError("--frames: is an option of the scene chewing");
  if (scene_request.name == "combine") return simulate_combine(scene_request, extension, folder, run);
  if (scene_request.name == "accuracy") return simulate_accuracy(scene_request, extension, folder, run);
  if (scene_request.name == "scanners") return simulate_scanners(scene_request, extension, folder, run);
  const Scene scene = make_scene(scene_request.name, scene_request.scene_options(), run.context());
  write_cloud(folder.path("a" + extension), scene.a, run.context());
  write_cloud(folder.path("b" + extension), scene.b, run.context());
  const std::string truth = folder.path("truth.json");
  write_text_atomically(truth, truth_json(scene, scene_request, folder.names()));
  run.context().check();
  folder.commit();
  run.show(fmt::format("{}: {}\na: {} points, b: {} points, in {}", scene.name, scene.description,
                       scene.a.points.size(), scene.b.points.size(), output));
  return 0;
}

}  // namespace isopach::cli
