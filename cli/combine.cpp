// isopach combine FACE JAW --reference REF
#include "isopach/apps/combine.hpp"

#include <fmt/core.h>

#include <memory>

#include "cli/answer.hpp"
#include "cli/command.hpp"
#include "cli/output.hpp"
#include "cli/parse.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/read.hpp"
#include "isopach/report/combine.hpp"
#include "isopach/report/match.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "Two scans that share no surface in one model, by a reference object that is seen in both: it is found in each "
    "scan,\n"
    "in any position, and JAW is moved to where it belongs in the coordinates of FACE.\n";

constexpr const char* footer =
    "Exit codes: 0 done, 2 wrong usage, 3 input cannot be read, 4 the object is not found in a scan, 5 its place "
    "there\n"
    "is not determined, 130 interrupted.\n"
    "\n"
    "Examples:\n"
    "  isopach combine face.ply jaw.ply --reference plate.stl -o result     combined.ply, pose.txt, report.html in "
    "result/\n"
    "  isopach simulate combine -o scans                                    scans with known truth to try it on";

struct Request {
  std::string face, jaw, reference, start_face, start_jaw;
  Delivery delivery;
  CombineOptions options;
  RunOptions run;
};

void add_options(Command& command, Request& request) {
  CombineOptions& o = request.options;
  command.heading("Reference object");
  command.option("--reference", "FILE", request.reference, "A scan of the object alone, or its model")
      .required(true)
      .check(not_empty());
  command
      .option("--least-share", "SHARE", o.least_share,
              "Share of the object's points that must lie on a surface of each scan")
      .check(share())
      .show_default();
  command.option(
      "--start-face", "FILE", request.start_face,
      "Four lines of four numbers: approximate pose of the object in FACE (default: the program searches for it)");
  command.option("--start-jaw", "FILE", request.start_jaw, "The same in JAW");
  command.parsed("--unit", "m|mm|cm|um|km|ft|us-ft|in", o.unit, parse_unit,
                 "Unit of all scans, where the files do not say it or say it wrongly");
}

void add_output_options(Command& command, Delivery& delivery) {
  add_result_options(
      command, delivery,
      "Folder for combined.ply (with the attribute part: 0 face, 1 jaw, 2 and 3 the object in them), pose.txt, "
      "result.json and report.html; made if it is not there");
}

}  // namespace

std::string CombineAnswer::json(const std::vector<std::string>& outputs) const {
  return combine_json(combination, outputs);
}
std::string CombineAnswer::text() const { return combine_text(combination); }
void CombineAnswer::add_output_options(Command& command, Delivery& delivery) const {
  cli::add_output_options(command, delivery);
}

void CombineAnswer::deliver(const Delivery& delivery, OutputFolder* folder, Run& run) {
  Combination& c = combination;
  Stopwatch watch;
  std::string json;
  if (folder != nullptr) {
    write_combined(folder->path("combined.ply"), c, run.context());
    folder->write_text("pose.txt", pose_text(c.face_jaw));
    const std::string page = folder->path("report.html"), result = folder->path("result.json");
    set_write_time(c.timing, watch.lap());
    json = combine_json(c, folder->names());
    write_text_atomically(result, json);
    write_text_atomically(page, combine_html(c, json, run.context()));
    run.context().check();
    folder->commit();
  } else if (!delivery.json.empty()) {
    json = combine_json(c, {});
  }
  if (!delivery.json.empty()) write_json(delivery.json, json, run);
  if (delivery.json != "-") {
    run.show(combine_text(c));
    if (folder != nullptr) run.show("report: " + folder->final_path("report.html"));
  } else {
    for (const std::string& warning : c.warnings) run.warn(warning);
  }
}

int run_combine(const Arguments& arguments) {
  Request request;
  Command command("combine", description, footer);
  command.positional("FACE", request.face, "The scan whose coordinates the model has; any format compare reads");
  command.positional("JAW", request.jaw, "The scan that is moved to it");
  add_options(command, request);
  add_output_options(command, request.delivery);
  add_run_options(command, request.run);
  if (!command.parse(arguments)) return 0;
  if (!request.start_face.empty()) request.options.start_face = read_pose(request.start_face, "--start-face");
  if (!request.start_jaw.empty()) request.options.start_jaw = read_pose(request.start_jaw, "--start-jaw");

  Run run(request.run);
  std::unique_ptr<OutputFolder> folder;
  if (!request.delivery.output.empty()) folder = std::make_unique<OutputFolder>(request.delivery.output);
  ReadOptions wanted;
  wanted.attributes.clear();
  const CloudView face = scan_named(request.face, wanted, run.context());
  const CloudView jaw = scan_named(request.jaw, wanted, run.context());
  const CloudView reference = scan_named(request.reference, wanted, run.context());
  auto answer = std::make_unique<CombineAnswer>();
  answer->combination = combine(face, jaw, reference, request.options, run.context());
  return finish(std::move(answer), request.delivery, folder.get(), run);
}

}  // namespace isopach::cli
