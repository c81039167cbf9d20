// isopach distance A B
#include <fmt/core.h>

#include <memory>
#include <optional>
#include <sstream>

#include "cli/answer.hpp"
#include "cli/command.hpp"
#include "cli/output.hpp"
#include "cli/parse.hpp"
#include "cli/scans.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/las.hpp"
#include "isopach/io/read.hpp"
#include "isopach/io/write.hpp"
#include "isopach/report/distance.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "Distances in space between scans A and B, both ways: point to point, point to surface, along the normal, along\n"
    "the direction, the Hausdorff distance with a proven bound, and M3C2. Positive: B lies above A.\n";

constexpr const char* footer =
    "Examples:\n"
    "  isopach distance before.ply after.ply                      all but surface and m3c2, on stdout\n"
    "  isopach distance part.stl scan.ply --measure hausdorff --tolerance 0.001 --unit mm\n"
    "  isopach distance before.laz after.laz --measure m3c2 --normal-scale 2 --projection-scale 1 --max-depth 5 -o "
    "out\n"
    "  isopach distance a.ply b.ply --measure c2c,c2s -o out --format csv";

struct Request {
  std::string path_a, path_b, pose_path, core_points;
  Delivery delivery;
  std::size_t samples = 0;  ///< 0: not said
  DistanceOptions options;
  RunOptions run;
};

DistanceMeasures parse_measures(const std::string& text) {
  DistanceMeasures m;
  const std::vector<std::pair<std::string, bool*>> names{{"c2c", &m.c2c},         {"c2s", &m.c2s},
                                                         {"normal", &m.normal},   {"vertical", &m.vertical},
                                                         {"surface", &m.surface}, {"hausdorff", &m.hausdorff},
                                                         {"m3c2", &m.m3c2}};
  std::istringstream words(text);
  bool any = false;
  for (std::string word; std::getline(words, word, ',');) {
    bool known = false;
    for (const auto& [name, flag] : names)
      if (name == word) known = any = *flag = true;
    if (!known)
      throw UsageError(
          fmt::format("--measure: '{}' is not one of c2c, c2s, normal, vertical, surface, hausdorff, m3c2", word));
  }
  if (!any) throw UsageError("--measure: name at least one, e.g. c2c,c2s");
  return m;
}

void add_surface_options(Command& command, Request& request) {
  DistanceOptions& options = request.options;
  add_scan_options(command, options.project, request.pose_path, options.unit,
                   "Direction of 'vertical', and that Delaunay surfaces are seen along (default z)",
                   "Height of a Delaunay surface where points have the same place; error: refuse");
  command.choice<MeshSource>(
      "--mesh", options.mesh,
      {{"auto", MeshSource::automatic}, {"delaunay", MeshSource::delaunay}, {"faces", MeshSource::faces}},
      "Surface of a scan; faces: those of the file; delaunay: made from its points; auto: faces where there are any");
  add_border_options(command, options.border, options.max_edge);
  command.flag("--allow-crs", options.allow_crs,
               "Measure although the CRS is in degrees, is Web Mercator, differs, or heights have another unit");
}

void add_measure_options(Command& command, Request& request) {
  DistanceOptions& options = request.options;
  command.heading("Measure");
  command.parsed("--measure", "LIST", options.measures, parse_measures,
                 "What to measure, of c2c (nearest point), c2s (closest point of the surface), normal, vertical, "
                 "surface (mean and rms by area), hausdorff, m3c2 (default c2c,c2s,normal,vertical,hausdorff)");
  command
      .option("--tolerance", "L", options.tolerance,
              "hausdorff: proven to this length (default a millionth of the diagonal of both scans)")
      .check(positive());
  command
      .option("--samples", "N", request.samples,
              fmt::format("surface: samples a triangle, on average and at least (default {})", options.samples))
      .check(whole_number(1, 1'000'000));
  command.heading("M3C2 (Lague, Brodu, Leroux 2013)");
  command
      .option("--normal-scale", "D", options.m3c2.normal_scale,
              "Diameter of the ball in A whose points give the normal")
      .check(positive());
  command
      .option("--projection-scale", "d", options.m3c2.projection_scale,
              "Diameter of the cylinder along the normal in which both scans are averaged")
      .check(positive());
  command
      .option("--max-depth", "L", options.m3c2.max_depth,
              "How far the cylinder reaches from the core point, to either side")
      .check(positive());
  command
      .option("--registration-error", "REG", options.m3c2.registration_error,
              "Of the alignment of A and B, added to the level of detection")
      .check(not_negative())
      .show_default();
  command.option("--core-points", "FILE", request.core_points,
                 "Points to measure at, any format (default the points of A)");
}

/// An option that would do nothing is a mistake.
void check_use(const Request& request) {
  const DistanceMeasures& m = request.options.measures;
  const auto needs = [](bool given, const char* option, bool measured, const char* measure) {
    if (given && !measured)
      throw UsageError(fmt::format("{}: is an option of {}: add that to --measure", option, measure));
  };
  const M3c2Options& o = request.options.m3c2;
  const bool surface = m.c2s || m.normal || m.vertical || m.surface || m.hausdorff;
  for (const auto& [given, option] : {std::pair{request.options.border != BorderRule::trim, "--border"},
                                      std::pair{request.options.max_edge > 0, "--max-edge"}}) {
    needs(given, option, surface, "c2s, normal, vertical, surface and hausdorff");
    if (given && request.options.mesh == MeshSource::faces)
      throw UsageError(fmt::format("{}: it is of Delaunay surfaces: leave it or --mesh faces out", option));
  }
  needs(request.options.tolerance > 0, "--tolerance", m.hausdorff, "hausdorff");
  needs(request.samples > 0, "--samples", m.surface, "surface");
  needs(o.normal_scale > 0, "--normal-scale", m.m3c2, "m3c2");
  needs(o.projection_scale > 0, "--projection-scale", m.m3c2, "m3c2");
  needs(o.max_depth > 0, "--max-depth", m.m3c2, "m3c2");
  needs(o.registration_error > 0, "--registration-error", m.m3c2, "m3c2");
  needs(!request.core_points.empty(), "--core-points", m.m3c2, "m3c2");
}

void add_output_options(Command& command, Delivery& delivery) {
  add_result_options(
      command, delivery,
      "Folder for report.html, result.json, points_a and points_b with their distances (LAS in: also LAS), core_points "
      "of m3c2; made if it is not there");
  command.choice<std::string>("--format", delivery.format, {{"ply", "ply"}, {"csv", "csv"}, {"las", "las"}},
                              "Of points_a, points_b and core_points");
}

/// LAS in gives LAS out with everything the file had; the format asked for beside it, unless it is the same.
void write_scan(const CloudView& cloud, const std::vector<Attribute>& fields, const std::string& name,
                const std::string& format, OutputFolder& folder, const Context& context) {
  if (fields.empty()) return;
  const bool copies = is_las_file(cloud);
  if (copies) write_las_with_fields(cloud, folder.path(name + "." + cloud.format), fields, context);
  if (!copies || format != "las") write_distance_points(folder.path(name + "." + format), cloud, fields, context);
}

}  // namespace

std::string DistanceAnswer::json(const std::vector<std::string>& outputs) const {
  return distance_json(distances, outputs);
}
std::string DistanceAnswer::text() const { return distance_text(distances); }
void DistanceAnswer::add_output_options(Command& command, Delivery& delivery) const {
  cli::add_output_options(command, delivery);
}

void DistanceAnswer::deliver(const Delivery& delivery, OutputFolder* folder, Run& run) {
  Distances& d = distances;
  const Context& context = run.context();
  Stopwatch watch;
  if (folder != nullptr) {
    write_scan(a, d.fields_a, "points_a", delivery.format, *folder, context);
    write_scan(b, d.fields_b, "points_b", delivery.format, *folder, context);
    if (d.m3c2) write_core_points(folder->path("core_points." + delivery.format), d, context);
  }
  set_write_time(d.timing, watch.lap());
  std::string json;
  if (folder != nullptr) {
    const std::string page = folder->path("report.html"), result = folder->path("result.json");
    json = distance_json(d, folder->names());
    write_text_atomically(result, json);
    write_text_atomically(page, distance_html(d, a, json, context));
    context.check();
    folder->commit();
  } else if (!delivery.json.empty()) {
    json = distance_json(d, {});
  }
  if (!delivery.json.empty()) write_json(delivery.json, json, run);
  if (delivery.json != "-") {
    run.show(distance_text(d));
    if (folder != nullptr) run.show("report: " + folder->final_path("report.html"));
  } else {
    for (const std::string& warning : d.warnings) run.warn(warning);
  }
}

int run_distance(const Arguments& arguments) {
  Request request;
  DistanceMeasures& m = request.options.measures;
  m.c2c = m.c2s = m.normal = m.vertical = m.hausdorff = true;
  Command command("distance", description, footer);
  command.positional("A", request.path_a, "Reference scan or mesh, or the one before; any format that compare reads");
  command.positional("B", request.path_b, "Compared scan or mesh, or the one after");
  add_output_options(command, request.delivery);
  add_surface_options(command, request);
  add_measure_options(command, request);
  add_run_options(command, request.run);
  if (!command.parse(arguments)) return 0;
  if (!request.pose_path.empty()) request.options.pose = read_pose(request.pose_path);
  check_use(request);
  if (request.samples > 0) request.options.samples = request.samples;
  check(request.options);

  Run run(request.run);
  std::unique_ptr<OutputFolder> folder;
  if (!request.delivery.output.empty()) folder = std::make_unique<OutputFolder>(request.delivery.output);
  Stopwatch watch;
  ReadOptions wanted = read_options(request.options.project);
  wanted.faces = request.options.mesh != MeshSource::delaunay;
  auto answer = std::make_unique<DistanceAnswer>();
  answer->a = scan_named(request.path_a, wanted, run.context());
  answer->b = scan_named(request.path_b, wanted, run.context());
  std::optional<CloudView> cores;
  if (!request.core_points.empty()) cores = scan_named(request.core_points, ReadOptions{}, run.context());
  const double read_s = watch.lap();
  answer->distances = distance(answer->a, answer->b, cores, request.options, run.context());
  add_read_time(answer->distances.timing, read_s);
  return finish(std::move(answer), request.delivery, folder.get(), run);
}

}  // namespace isopach::cli
