// isopach compare A B
#include <fmt/core.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "cli/answer.hpp"
#include "cli/command.hpp"
#include "cli/compare_request.hpp"
#include "cli/match.hpp"
#include "cli/output.hpp"
#include "cli/parse.hpp"
#include "cli/registration.hpp"
#include "cli/scans.hpp"
#include "cli/session.hpp"
#include "cli/tile_job.hpp"
#include "cli/values.hpp"
#include "cli/verbs.hpp"
#include "isopach/compare/check.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/compare/displacement.hpp"
#include "isopach/io/read.hpp"
#include "isopach/match/match.hpp"
#include "isopach/report/page/matched.hpp"
#include "isopach/report/page/text.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "How much and where scan B differs from scan A, measured without a grid between the two triangulated scans.\n"
    "Positive: B lies above A. Lengths are in the unit of the files; areas and volumes in its square and cube.\n";

constexpr const char* footer =
    "Exit codes: 0 done, 2 wrong usage, 3 input cannot be read, 4 no overlap, 5 the pose of --match is "
    "not\ntrusted, 6 --fail-above exceeded, 130 interrupted.\n"
    "\n"
    "Examples:\n"
    "  isopach compare before.laz after.laz                       the summary, on stdout\n"
    "  isopach compare before.laz after.laz -o result             and map, point clouds, report in result/\n"
    "  isopach compare before.laz after.laz --class 2             bare ground only\n"
    "  isopach compare part.stl scan.ply --direction fit --unit mm --fail-above p95=0.05\n"
    "  isopach compare a.tif b.tif --crop 1000,2000,1500,2400 --json - | python3 -m json.tool";

void add_projection_options(Command& command, CompareRequest& request) {
  add_scan_options(
      command, request.options.project, request.pose_path, request.options.unit,
      "Direction that heights are measured along; fit: normal of the plane fitted to both scans (default z)",
      "Height of points of one scan with the same place; error: refuse such a scan");
  command.flag(
      "--match", request.match,
      "Move B on A first, as isopach match does, from --pose; the pose is in the result, its covariance in the "
      "uncertainty (--uncertainty-model registration, the default with --match and sigmas)");
  command.flag("--allow-crs", request.options.allow_crs,
               "Compare although the CRS is in degrees, is Web Mercator, or differs between the scans");
  add_visible_option(command, request.visible);
  command.flag("--no-layer-check", request.no_layer_check,
               "Skip the search for several layers above one another, and for folds (saves time)");
}

void add_uncertainty_options(Command& command, CompareRequest& request) {
  UncertaintyOptions& options = request.options.uncertainty;
  command.heading("Uncertainty");
  command.parsed(
      "--sigma1", "S|@ATTRIBUTE|FILE", options.sigma1,
      +[](const std::string& text) { return parse_sigma(text, "--sigma1"); },
      "Standard deviation of the heights of A, in their unit: a number, an attribute of its points, or a raster");
  command.parsed(
      "--sigma2", "S|@ATTRIBUTE|FILE", options.sigma2,
      +[](const std::string& text) { return parse_sigma(text, "--sigma2"); }, "The same for B");
  command
      .option("--lod", "L", options.lod,
              "Level of detection: differences up to it count as noise in the thresholded volumes and on the map "
              "(default: from the sigmas)")
      .check(positive());
  command
      .option("--confidence", "P", options.confidence,
              "Probability of intervals, and of a level of detection from the sigmas, between 0 and 1")
      .check(share())
      .show_default();
  using Model = UncertaintyModel;
  request.model = command.choice<Model>(
      "--uncertainty-model", options.model,
      {{"none", Model::none},
       {"independent", Model::independent},
       {"correlated", Model::correlated},
       {"registration", Model::registration}},
      "How errors of heights propagate to the volumes; independent: from point to point; correlated: "
      "within --correlation-range; registration: the pose of B is uncertain, in addition to the noise");
  command
      .option("--correlation-range", "L", options.correlation_range,
              "Distance beyond which the errors of two points of a scan are not correlated, in the unit of x and y")
      .check(positive());
  using Shape = CorrelationShape;
  command.choice<Shape>(
      "--correlation", options.correlation,
      {{"spherical", Shape::spherical}, {"exponential", Shape::exponential}, {"gaussian", Shape::gaussian}},
      "How the correlation falls with the distance; 0 (spherical) or 5 % are left at the range");
  command.parsed("--registration-error", "REG|FILE", request.registration, parse_registration,
                 "For registration: standard deviation of a shift of B along the direction, in the unit of heights; or "
                 "result.json of isopach match, for the covariance of its pose (default with --match: that found)");
}

void add_change_options(Command& command, CompareRequest& request) {
  ChangeOptions& options = request.options.changes;
  command.heading("Changes");
  command.flag("--changes", options.asked,
               "Connected regions where |d| exceeds the level of detection as objects: volume, area, place, outline of "
               "each (changes.csv, changes.geojson)");
  command
      .option("--change-height", "H", options.height,
              "Objects are where |d| exceeds this height instead, in the unit of heights")
      .check(positive());
  command
      .option("--min-change-volume", "V", options.min_volume,
              "Objects below this volume are summed up, not listed (default: 0)")
      .check(not_negative());
  request.has_min_change_area =
      command
          .option("--min-change-area", "A", request.min_change_area,
                  "Objects below this area likewise (default: what ten points of the sparser scan cover)")
          .check(not_negative());
}

void add_currents_options(Command& command, CurrentsOptions& options) {
  command
      .option(
          "--sigma", "S", options.sigma,
          "Width of the kernel of --measure currents and --objective currents, in the unit of the scans: detail much "
          "smaller than it is not seen (default: five mean edges of the coarser scan)")
      .check(positive());
  command
      .option("--currents-error", "SHARE", options.error,
              "Largest error of the sums of --measure currents, as a share of the norms, 1e-11 to 1")
      .check(positive())
      .show_default();
}

void add_measure_options(Command& command, CompareRequest& request) {
  CompareOptions& options = request.options;
  command.heading("Measure");
  command.choice<Surface>("--surface", options.surface,
                          {{"common", Surface::common}, {"overlay", Surface::overlay}, {"both", Surface::both}},
                          "Cells of the integral; common: the Delaunay triangulation of both scans together; overlay: "
                          "exact between the triangulations of each; both: common, with the overlay's beside it");
  command.choice<MeasureKind>(
      "--measure", options.measure,
      {{"V", MeasureKind::V}, {"dV", MeasureKind::dV}, {"currents", MeasureKind::currents}},
      "The measure that summary and report show first; V: the volume between the scans; dV: for scans of "
      "different detail, the difference averaged over each triangle of the coarser scan before its size "
      "is taken; currents: positions and directions of the triangles, compared by a kernel of width "
      "--sigma");
  add_currents_options(command, options.currents);
  command.parsed(
      "--weight", "FORMULA|@ATTRIBUTE|FILE", options.weight,
      +[](const std::string& text) { return parse_weight(text); },
      "Also the measures with a weight of 0 or more: a formula of x, y, z1, z2, slope1, slope2; an attribute of the "
      "points, of B if it has it, else of A, or @a:NAME, @b:NAME; or a raster");
  command.choice<Interpolation>(
      "--interpolation", options.interpolation, {{"linear", Interpolation::linear}, {"cubic", Interpolation::cubic}},
      "A scan between its points; linear: plane triangles; cubic: smooth, through every point, for clean scans of "
      "smooth ground (--surface common only)");
  command.choice<DomainKind>(
      "--domain", options.domain, {{"overlap", DomainKind::overlap}, {"hull", DomainKind::hull}},
      "Where to measure; overlap: where both scans are; hull: the hull of both, each scan extrapolated "
      "beyond its border");
  add_border_options(command, options);
  command
      .option("--alpha", "R", options.alpha,
              "Alpha shape: triangles of a scan with a circumradius above this, in the unit of x and y, are no part of "
              "it (default: any)")
      .check(positive());
  command.option("--include", "POLYGONS", request.area.include,
                 "Measure inside these polygons alone, cells cut exactly; GeoJSON, GeoPackage, Shapefile, KML or "
                 "FlatGeobuf, in the x and y of "
                 "the scans; repeatable. Each polygon gets a row of volumes (budget.csv)");
  command.option("--exclude", "POLYGONS", request.area.exclude, "Do not measure inside these polygons; repeatable");
  command.option("--budget", "POLYGONS", request.area.budget,
                 "A row of volumes for each of these polygons; what is measured stays as it is; repeatable");
  command
      .option("--mask", "RASTER", request.area.mask, "Do not measure where a pixel of this raster is 0 or has no data")
      .check(not_empty());
  command.choice<LocateMethod>(
      "--locate", options.locate,
      {{"order", LocateMethod::order}, {"tree", LocateMethod::tree}, {"interface", LocateMethod::interface}},
      "How points of one scan are found in the other, with the same result; order: along the curve, the fastest; tree: "
      "along the spanning tree, as published; interface: from the triangulation of both");
  command
      .option("--min-coverage", "SHARE", options.min_coverage,
              "Exit 4 if the scans share less than this part of their area, 0 to 1")
      .check(share())
      .show_default();
  add_uncertainty_options(command, request);
  add_change_options(command, request);
  command.heading("Uncertainty");
  command.flag("--noise-floor", options.noise_floor,
               "Estimate from the scans themselves what two scans of an unchanged surface would show, and the gross "
               "volume without it");
  command.heading("Measure");
  command.option(
      "--fail-above", "STATISTIC=LIMIT", request.fail_above,
      fmt::format("Exit 6 if a statistic is above its limit, in the unit of the result; repeatable; mean, "
                  "median and net by their size, significant_area as a share, currents_distance as an area. One of {}",
                  statistic_names()));
}

/// What the matching knows of its pose, where the uncertainty wants that.
void take_covariance(const PoseCovariance& covariance, const CompareRequest& request, UncertaintyOptions& u) {
  if (!request.model.is_given() && u.sigma1.kind != SigmaSource::Kind::none) u.model = UncertaintyModel::registration;
  if (u.model != UncertaintyModel::registration || u.registration_error > 0 || u.registration_covariance) return;
  u.registration_covariance = covariance;
  u.registration_source = "match";
}

/// Before any file is read, let alone matched.
void check_before_work(const CompareRequest& request) {
  CompareOptions expected = request.options;
  if (request.match) {
    take_covariance({}, request, expected.uncertainty);
    if (request.matching.objective == Objective::currents && expected.measure != MeasureKind::currents)
      expected.currents.sigma = 0;  // it is of the matching alone
  }
  check(expected);
}

/// Puts the pose of b on a into the options, and how well it is known where the uncertainty wants that; what the
/// matching has to say goes into `remarks`.
std::shared_ptr<const Matching> match_first(const CloudView& a, const CloudView& b, const CompareRequest& request,
                                            CompareOptions& options, std::vector<std::string>& remarks,
                                            const Run& run) {
  MatchOptions wanted = request.matching;
  wanted.compare = options;
  wanted.compare.pose = {};
  wanted.compare.measure = MeasureKind::V, wanted.compare.currents = {};
  wanted.compare.check_layers = false;
  wanted.compare.uncertainty = {};
  wanted.compare.noise_floor = false;
  wanted.compare.changes = {};
  if (wanted.objective != Objective::measure) wanted.compare.weight = {};  // it is of the comparison then
  if (wanted.objective == Objective::currents) {                           // one --sigma for both
    wanted.sigma = options.currents.sigma;
    if (options.measure != MeasureKind::currents) options.currents.sigma = 0;
  }
  wanted.start = options.pose;
  wanted.judge = false;  // the comparison that follows does
  auto found = std::make_shared<Matching>(match(b, a, wanted, run.context()));
  const Matching& m = *found;
  require_trust(m, "@match");
  if (!m.converged)
    throw Error(ExitCode::not_converged, "--match: " + m.reason + ": look at it with isopach match, or give a --pose");
  remarks = m.weak_directions;
  options.pose = m.pose;
  if (m.undetermined.empty()) {
    take_covariance({m.covariance, m.centre}, request, options.uncertainty);
    return found;
  }
  UncertaintyOptions hoped = options.uncertainty;
  take_covariance({}, request, hoped);
  if (hoped.registration_covariance && !options.uncertainty.registration_covariance)
    remarks.push_back(
        "the uncertainty of net has the noise of the scans alone: how far the pose may be off along what the scans do "
        "not determine is not known; give it with --registration-error");
  return found;
}

}  // namespace

void add_compare_options(Command& command, CompareRequest& request) {
  add_projection_options(command, request);
  add_measure_options(command, request);
}

std::vector<Tolerance> settle_options(CompareRequest& request) {
  std::vector<Tolerance> tolerances;
  for (const std::string& text : request.fail_above)
    for (Tolerance& tolerance : parse_tolerances(text)) tolerances.push_back(std::move(tolerance));
  check_tolerances(tolerances, request.options);
  request.options.percentiles = percentiles_of(tolerances);
  request.options.check_layers = !request.no_layer_check;
  request.options.uncertainty.registration_error = request.registration.shift;
  request.options.uncertainty.registration_covariance = request.registration.covariance;
  request.options.uncertainty.registration_source = request.registration.source;
  if (request.has_min_change_area.is_given()) request.options.changes.min_area = request.min_change_area;
  check_before_work(request);
  return tolerances;
}

void refuse_in_tiles(const CompareRequest& request) {
  if (request.match)
    throw UsageError("--match: a comparison in tiles is given its pose: match samples first, then --pose");
  if (request.visible) throw UsageError("--visible: a comparison in tiles cannot have it: leave it out");
  const AreaPaths& area = request.area;
  const std::array<std::pair<const char*, bool>, 4> given{{{"include", !area.include.empty()},
                                                           {"exclude", !area.exclude.empty()},
                                                           {"budget", !area.budget.empty()},
                                                           {"mask", !area.mask.empty()}}};
  for (const auto& [name, is_given] : given)
    if (is_given)
      throw UsageError(
          fmt::format("--{}: a comparison by tiles cannot have it: leave it out, or compare in memory", name));
}

void hint_at_matching(const std::optional<Displacement>& found, Comparison& c) {
  if (!found) return;
  const auto length = [&](double v, int digits = 2) {
    return number(v, Typography::plain, digits) + " " + measured_unit(c, 1);
  };
  const double degrees = found->tilt * 180 / std::acos(-1.0);
  std::string motion = "a plain offset of " + length(found->offset, 3);
  if (found->kind != Displacement::Kind::offset)
    motion = fmt::format("an offset of {} and a tilt of {:.2g} degrees", length(found->offset, 3), degrees);
  if (found->kind == Displacement::Kind::shift)
    motion += fmt::format(" with a shift of {} {} across the direction", number(found->shift, Typography::plain, 2),
                          unit_text(c.unit));
  c.warnings.push_back(
      fmt::format("B lies off A as a whole: {} takes the median of |d| from {} to {}; if the scans were never put into "
                  "one frame, add "
                  "--match; if the whole surface changed by that, nothing is wrong",
                  motion, length(found->before), length(found->after)));
}

std::string CompareAnswer::json(const std::vector<std::string>& outputs) const {
  return comparison_json(comparison, outputs, matching.get());
}
std::string CompareAnswer::text() const { return comparison_text(comparison, std::nullopt, matching.get()); }
void CompareAnswer::add_output_options(Command& command, Delivery& delivery) const {
  add_delivery_options(command, delivery, "");
}
void CompareAnswer::deliver(const Delivery& delivery, OutputFolder* folder, Run& run) {
  cli::deliver(comparison, a, b, std::nullopt, delivery, folder, run, matching.get());
}
bool CompareAnswer::draw(const std::string& path, const MapOptions& look, const Context& context) const {
  write_map(path, comparison, look, context);
  return true;
}
void CompareAnswer::require() const {
  const std::string over = exceeded(comparison, tolerances);
  if (!over.empty()) throw Error(ExitCode::tolerance, "--fail-above: " + over);
}

namespace {

/// Whether a comparison in memory stays below --max-memory, as far as the heads of the files tell.
bool fits(const CompareRequest& request, const JobLimits& limits, const Context& context) {
  const auto points = points_stated(request.path_a, request.path_b, request.options, context);
  return points && memory_of_comparison(*points) <= limits.memory;
}

int compare_large(CompareRequest& request, const JobLimits& limits, std::vector<Tolerance> tolerances, Run& run) {
  refuse_in_tiles(request);
  refuse_files_of_cells(request.delivery);
  auto answer = std::make_unique<TiledAnswer>();
  answer->tolerances = std::move(tolerances);
  request.options.keep_points = false;
  std::unique_ptr<OutputFolder> folder;
  if (!request.delivery.output.empty()) folder = std::make_unique<OutputFolder>(request.delivery.output);
  Stopwatch watch;
  answer->comparison = compare_in_tiles(request.path_a, request.path_b, request.options, limits,
                                        answer->look(request.delivery, run.context()), run);
  Timing& timing = answer->comparison.timing;  // of the join, so far
  add_read_time(timing, watch.lap() - timing.total);
  return finish(std::move(answer), request.delivery, folder.get(), run);
}

}  // namespace

int run_compare(const Arguments& arguments) {
  CompareRequest request;
  Command command("compare", description, footer);
  command.positional(
      "A", request.path_a,
      "Reference scan, or the one before: XYZ, CSV, PTS, PLY, LAS, LAZ, OBJ, STL, PCD, GeoTIFF, ASC; or its "
      "tiles: a folder, a pattern in quotes, a list (.txt) or a catalogue (.vpc) of such files");
  command.positional("B", request.path_b, "Compared scan, or the one after");
  add_delivery_options(command, request.delivery, "");
  add_compare_options(command, request);
  JobLimits limits;
  command.heading("Run");
  command.option_with(
      "--max-memory", "SIZE", [&](const std::string& text) { limits.memory = parse_size(text, "--max-memory"); },
      "Compare in tiles, on disk, where the scans together would take more memory than this, e.g. 8G: the same numbers "
      "and --raster, a map and a view by means over squares; no files of cells and points");
  add_match_options(command, request.matching);
  add_run_options(command, request.run);
  if (!command.parse(arguments)) return 0;

  if (!request.match) refuse_match_options(request.matching, "--match");
  if (!request.pose_path.empty() && request.matching.coarse)
    throw UsageError("--pose and --coarse: give a start, or let the program search for one, not both");
  auto answer = std::make_unique<CompareAnswer>();
  answer->tolerances = settle_options(request);
  check_layers(request.delivery, request.options.project);
  if (!request.pose_path.empty()) request.options.pose = read_pose(request.pose_path);

  Run run(request.run);
  if (limits.memory > 0 && session().shell && !fits(request, limits, run.context()))
    return compare_large(request, limits, std::move(answer->tolerances), run);
  std::unique_ptr<OutputFolder> folder;
  if (!request.delivery.output.empty()) folder = std::make_unique<OutputFolder>(request.delivery.output);

  request.options.keep_overlay = (folder != nullptr || !session().shell) && !request.delivery.no_cells &&
                                 request.options.surface != Surface::common;
  request.options.keep_points = (folder != nullptr || !session().shell) && !request.delivery.no_points;
  Stopwatch watch;
  ReadOptions wanted = read_options(request.options.project);
  wanted.faces = request.visible || request.match;  // a nominal mesh is told by its faces
  const UncertaintyOptions& uncertainty = request.options.uncertainty;
  for (const SigmaSource* s : {&uncertainty.sigma1, &uncertainty.sigma2})
    if (s->kind == SigmaSource::Kind::attribute) wanted.attributes.push_back(s->name);
  if (request.options.weight.kind == WeightSource::Kind::attribute)
    wanted.attributes.push_back(request.options.weight.text);
  request.options.area = read_area(request.area, run.context());  // before the scans: these take longer
  read_rasters(request.options, run.context());
  CloudView &a = answer->a, &b = answer->b;
  a = scan_named(request.path_a, wanted, run.context());
  b = scan_named(request.path_b, wanted, run.context());
  if (!request.match && request.options.pose.is_identity()) check_extent(request.delivery.map, a, b);
  if (request.visible) {
    CloudView seen = visible_of(a, {}, b, request.options.project, run.context());
    b = visible_of(std::move(b), request.options.pose, a, request.options.project, run.context());
    a = std::move(seen);
  }
  const double read_s = watch.lap();
  std::vector<std::string> remarks;
  if (request.match) answer->matching = match_first(a, b, request, request.options, remarks, run);
  Comparison& comparison = answer->comparison;
  comparison = compare(a, b, request.options, run.context());
  comparison.warnings.insert(comparison.warnings.end(), remarks.begin(), remarks.end());
  if (!request.match) hint_at_matching(plain_displacement(comparison, run.context()), comparison);
  add_read_time(comparison.timing, read_s);
  return finish(std::move(answer), request.delivery, folder.get(), run);
}

}  // namespace isopach::cli
