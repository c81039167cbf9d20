// isopach accuracy RECONSTRUCTION REFERENCE
#include <fmt/core.h>

#include <cmath>
#include <memory>

#include "cli/answer.hpp"
#include "cli/application.hpp"
#include "cli/match.hpp"
#include "cli/parse.hpp"
#include "cli/scans.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/read.hpp"
#include "isopach/report/accuracy.hpp"
#include "isopach/report/match.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "How well a reconstruction agrees with a reference scan: alignment, bias, scatter, noise and form, largest "
    "deviation,\n"
    "completeness; a verdict by tolerances.\n";

constexpr const char* footer =
    "Exit codes: 0 done, 2 wrong usage, 3 input cannot be read, 4 no overlap, 5 not converged, 6 tolerance exceeded, "
    "130\n"
    "interrupted.\n"
    "\n"
    "Examples:\n"
    "  isopach accuracy part.ply master.ply --unit mm            the numbers, on stdout\n"
    "  isopach accuracy photo.ply scan.ply --align scale -o out  scale found too; map, report, result.json in out/\n"
    "  isopach accuracy part.ply master.ply --align none --fail-above bias=0.02,p95=0.05 --fail-below "
    "completeness=0.98";

struct Request {
  std::string reconstruction, reference, start;
  AccuracyOptions options;
  std::vector<AccuracyLimit> limits;
  Delivery output;
  bool visible = false;
  RunOptions run;
};

std::string names() {
  std::string all;
  for (const AccuracyStatistic& s : accuracy_statistics())
    all += (all.empty() ? "" : ", ") + fmt::format("{} ({})", s.name, s.meaning);
  return all;
}

void add_limits(const std::string& text, const std::string& option, bool least, std::vector<AccuracyLimit>& limits) {
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos)
      throw UsageError(fmt::format("{}: '{}' is not STATISTIC=LIMIT, e.g. p95=0.05", option, part));
    const AccuracyLimit limit{part.substr(0, equals), parse_number(part.substr(equals + 1), option + " " + part),
                              least};
    std::vector<std::string> known;
    for (const AccuracyStatistic& s : accuracy_statistics()) known.emplace_back(s.name);
    if (std::find(known.begin(), known.end(), limit.statistic) == known.end())
      throw UsageError(fmt::format("{}: unknown statistic '{}'{}; known: {}", option, limit.statistic,
                                   did_you_mean(limit.statistic, known), names()));
    if (limit.limit < 0) throw UsageError(fmt::format("{}: the limit in '{}' is below 0", option, part));
    limits.push_back(limit);
    begin = end + 1;
  }
}

}  // namespace

std::string AccuracyAnswer::json(const std::vector<std::string>& outputs) const {
  return accuracy_json(accuracy, checks, outputs);
}
std::string AccuracyAnswer::text() const { return accuracy_text(accuracy, checks); }
void AccuracyAnswer::add_output_options(Command& command, Delivery& delivery) const {
  add_application_output(command, delivery, "accuracy.png, pose.txt");
}
bool AccuracyAnswer::draw(const std::string& path, const MapOptions& look, const Context& context) const {
  write_accuracy_map(path, accuracy, look, context);
  return true;
}
void AccuracyAnswer::require() const {
  if (accuracy.matching && !accuracy.matching->converged)
    throw Error(ExitCode::not_converged,
                accuracy.matching->reason +
                    ": the alignment is the best one found; allow more steps (--max-iterations), or "
                    "give a better --start");
  const std::string exceeded = failed(accuracy, checks);
  if (!exceeded.empty()) throw Error(ExitCode::tolerance, exceeded);
}

void AccuracyAnswer::deliver(const Delivery& delivery, OutputFolder* folder, Run& run) {
  Accuracy& a = accuracy;
  const Context& context = run.context();
  const MapOptions& look = delivery.map;
  Delivered files;
  files.write = [&](OutputFolder& out) {
    const std::string map = out.path("accuracy.png");
    write_accuracy_map(map, a, look, context);
    if (delivery.svg) write_accuracy_map(out.path("accuracy.svg"), a, look, context);
    out.write_text("pose.txt", pose_text(a.pose));
    return map;
  };
  files.json = [&](const std::vector<std::string>& outputs) { return accuracy_json(a, checks, outputs); };
  files.page = [&](const std::string& path, const std::string& map, const std::string& json) {
    write_accuracy_html(path, a, map, json, look, context);
  };
  files.text = [&] { return accuracy_text(a, checks); };
  deliver_application(files, a.timing, a.warnings, delivery, folder, run);
}

int run_accuracy(const Arguments& arguments) {
  Request request;
  MatchOptions& options = request.options.match;
  CompareOptions& compare = options.compare;
  std::string above, below;
  Command command("accuracy", description, footer);
  command.positional("RECONSTRUCTION", request.reconstruction,
                     "Scan or model under test; any format that compare reads");
  command.positional("REFERENCE", request.reference, "What it is compared with: a better scan, a model");
  add_application_output(command, request.output, "accuracy.png, pose.txt");
  command.heading("Accuracy");
  command.choice<Align>("--align", request.options.align,
                        {{"none", Align::none}, {"rigid", Align::rigid}, {"scale", Align::scale}},
                        "What the alignment finds; none: both are in one system; scale: a uniform scale too");
  command
      .option("--within", "TOLERANCE", request.options.within,
              "Also the share of the reference that is met to within this height")
      .check(positive());
  command.option("--fail-above", "STATISTIC=LIMIT[,…]", above, "Exit 6 if a statistic is above its limit: " + names());
  command.option("--fail-below", "STATISTIC=LIMIT[,…]", below, "Exit 6 if a statistic is below its limit");
  add_scan_options(command, compare.project, request.start, compare.unit,
                   "Direction that heights are measured along; fit: normal of the plane fitted to both (default z)",
                   "Height of points of one scan with the same place; error: refuse such a scan",
                   {"--start",
                    "the row-major matrix that takes RECONSTRUCTION to REFERENCE, to start from or, with "
                    "--align none, to use (default: as is)"});
  command.flag("--allow-crs", compare.allow_crs,
               "Go on although the CRS is in degrees, is Web Mercator, or differs between the scans");
  add_border_options(command, compare);
  add_visible_option(command, request.visible);
  add_match_options(command, options);
  add_run_options(command, request.run);
  if (!command.parse(arguments)) return 0;
  if (!request.start.empty()) options.start = read_pose(request.start, "--start");
  if (!above.empty()) add_limits(above, "--fail-above", false, request.limits);
  if (!below.empty()) add_limits(below, "--fail-below", true, request.limits);
  for (const AccuracyLimit& limit : request.limits)
    if (limit.statistic == "within" && !(request.options.within > 0))
      throw UsageError(std::string(limit.least ? "--fail-below" : "--fail-above") +
                       ": within is known with --within alone");

  Run run(request.run);
  const std::unique_ptr<OutputFolder> folder = open_folder(request.output);
  Stopwatch watch;
  ReadOptions wanted = read_options(compare.project);
  wanted.faces = true;
  auto answer = std::make_unique<AccuracyAnswer>();
  CloudView &reconstruction = answer->reconstruction, &reference = answer->reference;
  reconstruction = scan_named(request.reconstruction, wanted, run.context());
  reference = scan_named(request.reference, wanted, run.context());
  if (request.visible) {
    CloudView seen = visible_of(reference, {}, reconstruction, compare.project, run.context());
    reconstruction = visible_of(std::move(reconstruction), options.start, reference, compare.project, run.context());
    reference = std::move(seen);
  }
  const double read_s = watch.lap();
  answer->accuracy = accuracy(reconstruction, reference, request.options, run.context());
  answer->checks = verdict(answer->accuracy, request.limits);
  add_read_time(answer->accuracy.timing, read_s);
  return finish(std::move(answer), request.output, folder.get(), run);
}

}  // namespace isopach::cli
