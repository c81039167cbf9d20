// isopach roughness SCAN [AFTER]
#include "isopach/apps/roughness.hpp"

#include <fmt/core.h>

#include <memory>
#include <optional>

#include "cli/answer.hpp"
#include "cli/command.hpp"
#include "cli/match.hpp"
#include "cli/output.hpp"
#include "cli/parse.hpp"
#include "cli/scans.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/read.hpp"
#include "isopach/measure/texture/form.hpp"
#include "isopach/report/roughness.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "How rough a surface is once its form and its waviness are removed: the areal parameters of ISO 25178-2, its\n"
    "wrinkles, and with a second scan what changed.\n";

constexpr const char* footer =
    "Examples:\n"
    "  isopach roughness skin.ply --l-filter 8                        parameters and wrinkles, on stdout\n"
    "  isopach roughness skin.ply --s-filter 0.25 --l-filter 8 -o out and maps, points, wrinkles.csv, report.html\n"
    "  isopach roughness before.ply after.ply --match --l-filter 8    what a treatment changed\n"
    "  isopach roughness face.obj --form polynomial --degree 4 --l-filter 20\n"
    "  isopach roughness part.stl --form reference --reference nominal.stl --match";

struct Request {
  std::string scan, after, reference, pose_path;
  Delivery delivery;
  std::optional<unsigned> degree;
  std::optional<double> margin;
  bool no_layer_check = false;
  RoughnessOptions options;
  bool visible = false;
  RunOptions run;
};

void add_removal_options(Command& command, Request& request) {
  RoughnessOptions& o = request.options;
  command.heading("What is removed");
  command.choice<FormKind>("--form", o.form,
                           {{"none", FormKind::none},
                            {"plane", FormKind::plane},
                            {"polynomial", FormKind::polynomial},
                            {"reference", FormKind::reference}},
                           "Form of the scan; polynomial: in x and y, of --degree, by least squares over the area; "
                           "reference: the surface of --reference");
  command
      .option("--degree", "N", request.degree,
              fmt::format("Of the polynomial, 1 to {} (default {})", most_form_degree, o.degree))
      .check(whole_number(1, most_form_degree));
  command
      .option("--reference", "FILE", request.reference, "Scan or mesh whose heights are the form, in place or --match")
      .check(not_empty());
  command
      .option("--s-filter", "L", o.s_filter,
              "Cut-off of the S-filter: waves shorter than this, and noise, are removed, in the unit of x and y "
              "(default: none)")
      .check(positive());
  command
      .option("--l-filter", "L", o.l_filter,
              "Cut-off of the L-filter: waviness, waves longer than this, is removed (default: none)")
      .check(positive());
  command.choice<MeanFilter>(
      "--filter", o.filter, {{"gaussian", MeanFilter::gaussian}, {"robust", MeanFilter::robust}},
      "Of the waviness; gaussian: ISO 16610-61; robust: not drawn by deep valleys, ISO 16610-71");
  command
      .option("--filter-degree", "0|1", o.filter_degree,
              "Filters near the rim; 0: weights are normalised; 1: planes stay planes, too")
      .check(whole_number(0, 1))
      .show_default();
}

void add_measure_options(Command& command, Request& request) {
  RoughnessOptions& o = request.options;
  command.heading("Measure");
  command
      .option("--margin", "L", request.margin,
              "Not evaluated: what is nearer than this to the rim of the scan (default: half of --l-filter)")
      .check(not_negative());
  command.choice<Interpolation>("--interpolation", o.interpolation,
                                {{"cubic", Interpolation::cubic}, {"linear", Interpolation::linear}},
                                "Of the surface between its points; cubic: smooth; linear: plane triangles");
  command
      .option("--wrinkle-depth", "D", o.wrinkles.depth,
              "Wrinkles are deeper than this under the robust mean surface (default: 3 NMAD of the heights over it)")
      .check(positive());
  command
      .option("--wrinkle-length", "L", o.wrinkles.length,
              "Wrinkles are longer than this (default: 10 times the spacing of the points)")
      .check(positive());
  add_border_options(command, o.compare);
}

void add_output_options(Command& command, Delivery& delivery) {
  add_result_options(command, delivery,
                     "Folder for result.json, report.html, roughness.png, wrinkles.png, wrinkles.csv and points (with "
                     "waviness, roughness, valley, wrinkle); of AFTER too; made if it is not there");
  command.choice<std::string>("--format", delivery.format, {{"ply", "ply"}, {"csv", "csv"}, {"las", "las"}},
                              "Of the points");
  add_view_option(command, delivery.map);
  command.option("--map-width", "PIXELS", delivery.map.width, "Width of the maps")
      .check(whole_number(300, 20000))
      .show_default();
}

/// An option that would do nothing is a mistake.
void check_use(const Request& request) {
  const RoughnessOptions& o = request.options;
  if (request.degree && o.form != FormKind::polynomial)
    throw UsageError("--degree: is an option of --form polynomial: add that");
  if (o.accept_doubt && !o.match) throw UsageError("--accept-doubt: it says how to match: give it with --match");
  if (request.delivery.output.empty() && request.delivery.format != "ply")
    throw UsageError("--format: there are no points to write: name a folder with -o");
}

/// Maps and points of one scan; `suffix` sets the names of the second apart.
void write_scan(const Texture& x, const CloudView& cloud, const std::string& suffix, const std::string& words,
                const Roughness& r, const Delivery& delivery, OutputFolder& folder,
                std::vector<ReportPicture>& pictures, const Context& context) {
  const std::string map = folder.path("roughness" + suffix + ".png"), lines = folder.path("wrinkles" + suffix + ".png");
  write_roughness_map(map, r, x, delivery.map, context);
  write_wrinkle_map(lines, r, x, delivery.map, context);
  pictures.push_back({map, "Roughness" + words});
  pictures.push_back({lines, "Wrinkles" + words + ", over the robust mean surface"});
  write_roughness_points(folder.path("points" + suffix + "." + delivery.format), cloud, x, context);
}

}  // namespace

std::string RoughnessAnswer::json(const std::vector<std::string>& outputs) const {
  return roughness_json(roughness, outputs);
}
std::string RoughnessAnswer::text() const { return roughness_text(roughness); }
void RoughnessAnswer::add_output_options(Command& command, Delivery& delivery) const {
  cli::add_output_options(command, delivery);
}

bool RoughnessAnswer::draw(const std::string& path, const MapOptions& look, const Context& context) const {
  write_roughness_map(path, roughness, roughness.scan, look, context);
  return true;
}

void RoughnessAnswer::deliver(const Delivery& delivery, OutputFolder* folder, Run& run) {
  Roughness& r = roughness;
  const Context& context = run.context();
  Stopwatch watch;
  std::vector<ReportPicture> pictures;
  if (folder != nullptr) {
    write_scan(r.scan, scan, "", r.after ? " before" : "", r, delivery, *folder, pictures, context);
    if (r.after) write_scan(*r.after, after, "_after", " after", r, delivery, *folder, pictures, context);
    folder->write_text("wrinkles.csv", wrinkles_csv(r));
  }
  set_write_time(r.timing, watch.lap());
  std::string json;
  if (folder != nullptr) {
    const std::string page = folder->path("report.html"), result = folder->path("result.json");
    json = roughness_json(r, folder->names());
    write_text_atomically(result, json);
    write_roughness_html(page, r, pictures, json, delivery.map, context);
    context.check();
    folder->commit();
  } else if (!delivery.json.empty()) {
    json = roughness_json(r, {});
  }
  if (!delivery.json.empty()) write_json(delivery.json, json, run);
  if (delivery.json != "-") {
    run.show(roughness_text(r));
  } else {
    for (const std::string& warning : r.warnings) run.warn(warning);
  }
}

int run_roughness(const Arguments& arguments) {
  Request request;
  RoughnessOptions& o = request.options;
  Command command("roughness", description, footer);
  command.positional("SCAN", request.scan, "Scan of a surface, or the one before; any format that compare reads");
  command
      .positional("AFTER", request.after,
                  "The same surface afterwards, processed in the same way and compared with SCAN")
      .required(false);
  add_output_options(command, request.delivery);
  add_removal_options(command, request);
  add_measure_options(command, request);
  add_scan_options(
      command, o.compare.project, request.pose_path, o.compare.unit,
      "Direction that heights are measured along; fit: normal of the plane fitted to the scans (default z)",
      "Height of points of one scan with the same place; error: refuse such a scan",
      {"--pose", "the row-major matrix that takes AFTER to SCAN, applied to AFTER first (default: as is)"});
  command.flag("--match", o.match, "Move AFTER and the reference on SCAN first, as isopach match does");
  add_accept_doubt(command, o.accept_doubt);
  command.flag("--allow-crs", o.compare.allow_crs,
               "Measure although the CRS is in degrees, is Web Mercator, differs, or heights have another unit");
  add_visible_option(command, request.visible);
  command.flag("--no-layer-check", request.no_layer_check,
               "Skip the search for several layers above one another, and for folds (saves time)");
  add_run_options(command, request.run);
  if (!command.parse(arguments)) return 0;
  check_use(request);
  if (request.degree) o.degree = *request.degree;
  if (request.margin) o.margin = *request.margin;
  o.compare.check_layers = !request.no_layer_check;
  if (!request.pose_path.empty()) o.compare.pose = read_pose(request.pose_path);

  Run run(request.run);
  std::unique_ptr<OutputFolder> folder;
  if (!request.delivery.output.empty()) folder = std::make_unique<OutputFolder>(request.delivery.output);
  Stopwatch watch;
  ReadOptions wanted = read_options(o.compare.project);
  wanted.faces = request.visible || request.options.match;  // a nominal mesh is told by its faces
  auto answer = std::make_unique<RoughnessAnswer>();
  CloudView &scan = answer->scan, &after = answer->after, reference;
  scan = scan_named(request.scan, wanted, run.context());
  if (!request.after.empty()) after = scan_named(request.after, wanted, run.context());
  if (!request.reference.empty()) reference = scan_named(request.reference, wanted, run.context());
  if (request.visible) {
    CloudView seen = visible_of(scan, {}, after, o.compare.project, run.context());
    if (!request.after.empty())
      after = visible_of(std::move(after), o.compare.pose, scan, o.compare.project, run.context());
    scan = std::move(seen);
  }
  const double read_s = watch.lap();
  const auto given = [](const std::string& path, const CloudView& cloud) {
    return path.empty() ? std::nullopt : std::optional<CloudView>(cloud);
  };
  answer->roughness =
      roughness(scan, given(request.after, after), given(request.reference, reference), o, run.context());
  add_read_time(answer->roughness.timing, read_s);
  return finish(std::move(answer), request.delivery, folder.get(), run);
}

}  // namespace isopach::cli
