// isopach scanners A B REFERENCE
#include <fmt/core.h>

#include <memory>

#include "cli/answer.hpp"
#include "cli/application.hpp"
#include "cli/match.hpp"
#include "cli/parse.hpp"
#include "cli/scans.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/read.hpp"
#include "isopach/report/scanners.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "Two scanners on one object: noise and bias of each against a reference of it, rho_V and rho_dV between them, and\n"
    "which details of the reference each of them resolves.\n";

constexpr const char* footer =
    "Exit codes: 0 done, 2 wrong usage, 3 input cannot be read, 4 no overlap, 5 not converged, 130 interrupted.\n"
    "\n"
    "Examples:\n"
    "  isopach scanners handheld.ply lab.ply master.ply --unit mm\n"
    "  isopach scanners a.ply b.ply reference.ply --align none --reference-sigma 0.01 -o result";

struct Request {
  std::string a, b, reference;
  std::string start;
  ScannersOptions options;
  Delivery output;
  bool visible = false;
  RunOptions run;
};

}  // namespace

std::string ScannersAnswer::json(const std::vector<std::string>& outputs) const {
  return scanners_json(scanners, outputs);
}
std::string ScannersAnswer::text() const { return scanners_text(scanners); }
void ScannersAnswer::add_output_options(Command& command, Delivery& delivery) const {
  add_application_output(command, delivery, "difference.png");
}
bool ScannersAnswer::draw(const std::string& path, const MapOptions& look, const Context& context) const {
  write_scanners_map(path, scanners, look, context);
  return true;
}
void ScannersAnswer::require() const {
  if (!scanners.scan[0].converged || !scanners.scan[1].converged)
    throw Error(ExitCode::not_converged,
                "a scan could not be matched to the reference: allow more steps (--max-iterations), or give a better "
                "--start");
}

void ScannersAnswer::deliver(const Delivery& delivery, OutputFolder* folder, Run& run) {
  Scanners& s = scanners;
  const Context& context = run.context();
  const MapOptions& look = delivery.map;
  Delivered files;
  files.write = [&](OutputFolder& out) {
    const std::string map = out.path("difference.png");
    write_scanners_map(map, s, look, context);
    if (delivery.svg) write_scanners_map(out.path("difference.svg"), s, look, context);
    return map;
  };
  files.json = [&](const std::vector<std::string>& outputs) { return scanners_json(s, outputs); };
  files.page = [&](const std::string& path, const std::string& map, const std::string& json) {
    write_scanners_html(path, s, map, json, look, context);
  };
  files.text = [&] { return scanners_text(s); };
  deliver_application(files, s.timing, s.warnings, delivery, folder, run);
}

int run_scanners(const Arguments& arguments) {
  Request request;
  CompareOptions& compare = request.options.match.compare;
  Command command("scanners", description, footer);
  command.positional("A", request.a, "Scan by the first scanner; any format that compare reads");
  command.positional("B", request.b, "Scan by the second");
  command.positional("REFERENCE", request.reference, "The object itself: a better scan, a model with dense points");
  add_application_output(command, request.output, "difference.png");
  command.heading("Scanners");
  command.choice<bool>("--align", request.options.align, {{"none", false}, {"rigid", true}},
                       "Whether each scan is matched to the reference first; none: all are in one system");
  command
      .option(
          "--reference-sigma", "S", request.options.reference_sigma,
          "Noise of the reference, one standard deviation, subtracted from that of the scanners (default 0: it is the "
          "truth)")
      .check(not_negative());
  add_scan_options(
      command, compare.project, request.start, compare.unit,
      "Direction that heights are measured along; fit: normal of the plane fitted to both (default z)",
      "Height of points of one scan with the same place; error: refuse such a scan",
      {"--start", "the row-major matrix that takes both scans to REFERENCE, to start from (default: as is)"});
  command.flag("--allow-crs", compare.allow_crs,
               "Go on although the CRS is in degrees, is Web Mercator, or differs between the scans");
  add_border_options(command, compare);
  add_visible_option(command, request.visible);
  add_match_options(command, request.options.match);
  add_run_options(command, request.run);
  if (!command.parse(arguments)) return 0;
  if (!request.start.empty()) request.options.match.start = read_pose(request.start, "--start");

  Run run(request.run);
  const Context& context = run.context();
  const std::unique_ptr<OutputFolder> folder = open_folder(request.output);
  Stopwatch watch;
  ReadOptions wanted = read_options(compare.project);
  wanted.faces = true;  // files that have some may be nominal meshes
  auto answer = std::make_unique<ScannersAnswer>();
  CloudView &a = answer->a, &b = answer->b, &reference = answer->reference;
  a = scan_named(request.a, wanted, context), b = scan_named(request.b, wanted, context);
  reference = scan_named(request.reference, wanted, context);
  if (request.visible) {
    const Pose& start = request.options.match.start;
    CloudView seen = visible_of(reference, {}, a.faces.empty() ? b : a, compare.project, context);
    a = visible_of(std::move(a), start, reference, compare.project, context);
    b = visible_of(std::move(b), start, reference, compare.project, context);
    reference = std::move(seen);
  }
  const double read_s = watch.lap();
  answer->scanners = scanners(a, b, reference, request.options, context);
  add_read_time(answer->scanners.timing, read_s);
  return finish(std::move(answer), request.output, folder.get(), run);
}

}  // namespace isopach::cli
