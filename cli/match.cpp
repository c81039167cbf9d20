// isopach match MOVING FIXED
#include "isopach/match/match.hpp"

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
#include "cli/values.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/read.hpp"
#include "isopach/report/draw/agreement.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/match.hpp"
#include "isopach/report/report.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "The pose of scan MOVING on scan FIXED that minimises the measure between their surfaces, or another --objective.\n"
    "The pose is the matrix that takes coordinates of MOVING to those of FIXED; compare --pose and convert --pose "
    "apply "
    "it.\n";

constexpr const char* footer =
    "Exit codes: 0 done, 2 wrong usage, 3 input cannot be read, 4 no overlap, 5 not converged or not trusted, 130\n"
    "interrupted.\n"
    "\n"
    "Examples:\n"
    "  isopach match after.laz before.laz                          the pose and how good it is, on stdout\n"
    "  isopach match after.laz before.laz -o result                and pose.txt, moved.ply, result.json in result/\n"
    "  isopach match after.ply before.ply --freedom x,y,z          shifts only\n"
    "  isopach match part.ply whole.ply --start guess.txt --overlap 0.7\n"
    "  isopach match head.ply bust.ply --coarse --objective icp-plane   any position, seen from all sides\n"
    "  isopach compare before.laz after.laz --pose result/pose.txt";

struct Request {
  std::string moving, fixed, start;
  Delivery delivery;
  bool pose_only = false;
  MatchOptions options;
  bool visible = false;
  RunOptions run;
};

void add_output_options(Command& command, Delivery& delivery) {
  add_result_options(
      command, delivery,
      "Folder for result.json, report.html, pose.txt, moved.ply (MOVING in its new place, with the attributes "
      "stable and agreement), agreement.png, before.png and after.png; made if it is not there");
  command.option("--pose-out", "FILE", delivery.pose_out, "The pose alone: four lines of four numbers")
      .check(not_empty());
  add_view_option(command, delivery.map);
  command.flag("--no-map", delivery.no_map,
               "No agreement.png, before.png and after.png, and no pictures in the report");
}

void add_pose_only(Command& command, Request& request) {
  command.flag("--pose-only", request.pose_only,
               "Do not compare before and after (rho, rms, coverage, maps): saves about half of the time");
}

/// Maps of what agrees and, where both comparisons were made, of before and after: the same place, the same colours.
MatchPictures write_pictures(const MatchAnswer& answer, const Delivery& delivery, OutputFolder& folder,
                             const Run& run) {
  const Matching& m = answer.matching;
  const CloudView& moving = answer.moving;
  MatchPictures files;
  files.vertices = delivery.map.vertices;
  if (delivery.no_map) return files;
  if (!m.agreement.empty()) {
    ProjectOptions project = answer.project;
    project.crop.reset();
    const Frame frame =
        m.comparison_after ? m.comparison_after->frame : choose_frame(moving, moving, Pose{}, project, run.context());
    write_agreement(files.agreement = folder.path("agreement.png"), moving, m, frame, MapOptions{}.width,
                    run.context());
  }
  const auto scales = paired_scales(m.comparison_before, m.comparison_after);
  const auto draw = [&](const Comparison& c, const char* name, const MapScale& scale) {
    const std::string path = folder.path(name);
    write_png(path, render_map(c, MapOptions{}, run.context(), scale));
    return path;
  };
  if (m.comparison_before) files.before = draw(*m.comparison_before, "before.png", scales[0]);
  if (m.comparison_after) files.after = draw(*m.comparison_after, "after.png", scales[1]);
  return files;
}

}  // namespace

std::string MatchAnswer::json(const std::vector<std::string>& outputs) const { return match_json(matching, outputs); }
std::string MatchAnswer::text() const { return match_text(matching); }
void MatchAnswer::add_output_options(Command& command, Delivery& delivery) const {
  cli::add_output_options(command, delivery);
}
void MatchAnswer::require() const {
  if (!matching.converged)
    throw Error(ExitCode::not_converged,
                matching.reason +
                    ": the pose is the best one found; allow more steps, give a better --start, or fewer --freedom");
  require_trust(matching, "match");
}

void MatchAnswer::deliver(const Delivery& delivery, OutputFolder* folder, Run& run) {
  Matching& m = matching;
  Stopwatch watch;
  MatchPictures pictures;
  if (folder != nullptr) {
    folder->write_text("pose.txt", pose_text(m.pose));
    write_moved(folder->path("moved.ply"), moving, m, run.context());
    pictures = write_pictures(*this, delivery, *folder, run);
  }
  set_write_time(m.timing, watch.lap());
  std::string json;
  if (folder != nullptr) {
    const std::string report = folder->path("report.html"), result = folder->path("result.json");
    json = match_json(m, folder->names());
    write_text_atomically(result, json);
    write_match_html(report, m, pictures, json, run.context());
    run.context().check();
    folder->commit();
  } else if (!delivery.json.empty()) {
    json = match_json(m, {});
  }
  if (!delivery.pose_out.empty()) write_text_atomically(delivery.pose_out, pose_text(m.pose));
  if (!delivery.json.empty()) write_json(delivery.json, json, run);
  if (delivery.json != "-") {
    run.show(match_text(m));
  } else {
    for (const std::string& warning : m.warnings) run.warn(warning);
  }
}

namespace {

Freedom parse_freedom(const std::string& text) {
  Freedom f{false, false, false, false, false, false, false};
  const std::pair<const char*, bool*> names[] = {{"x", &f.shift_x},     {"y", &f.shift_y},     {"z", &f.shift_z},
                                                 {"turn-x", &f.turn_x}, {"turn-y", &f.turn_y}, {"turn-z", &f.turn_z},
                                                 {"scale", &f.scale}};
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    bool known = false;
    for (const auto& [name, free] : names)
      if (word == name) *free = known = true;
    if (!known)
      throw UsageError(fmt::format(
          "--freedom: '{}' is not one of x, y, z, turn-x, turn-y, turn-z, scale (a list, e.g. x,y,z)", word));
    begin = end + 1;
  }
  return f;
}

struct PairLength {
  double length = 3;
  bool absolute = false;
};
PairLength parse_pair_length(const std::string& text) {
  if (text == "none") return {0, true};
  const bool medians = text.ends_with('x');
  const double length = parse_number(medians ? text.substr(0, text.size() - 1) : text, "--reject-distance");
  if (!(length > 0))
    throw UsageError(
        fmt::format("--reject-distance: '{}' is not none, a length above 0, or a number of medians such as 3x", text));
  return {length, !medians};
}

double parse_normal_angle(const std::string& text) {
  if (text == "none") return 0;
  const double angle = parse_number(text, "--reject-normal");
  if (!(angle > 0 && angle <= 90))
    throw UsageError(fmt::format("--reject-normal: '{}' is not none or an angle above 0 and up to 90 degrees", text));
  return angle;
}

void add_pair_options(Command& command, IcpOptions& icp) {
  command.heading("Pairs of points (icp-point, icp-plane, icp-gicp)");
  command.option_with(
      "--reject-distance", "LENGTH|Nx|none",
      [&icp](const std::string& text) {
        const PairLength p = parse_pair_length(text);
        icp.reject_distance = p.length, icp.reject_distance_absolute = p.absolute;
      },
      "Longest pair: a length in the unit of the scans, or in medians of all pairs (default 3x)");
  command.parsed("--reject-normal", "DEGREES|none", icp.reject_normal, parse_normal_angle,
                 "Largest angle between the normals of a pair (default 45)");
  command.choice("--reject-boundary", icp.reject_boundary, {{"on", true}, {"off", false}},
                 "No pair with a point on the boundary of FIXED");
  command.choice("--pair-weights", icp.weights,
                 {{"tukey", IcpOptions::Weights::tukey}, {"uniform", IcpOptions::Weights::uniform}},
                 "tukey: pairs that fit badly get less weight, or none; uniform: equal weights");
  command.flag("--one-to-one", icp.one_to_one, "Of all pairs with the same point of FIXED, keep only the shortest");
  command.flag("--symmetric", icp.symmetric,
               "Search for pairs in both directions: from MOVING to FIXED and from FIXED to MOVING");
}

}  // namespace

double parse_overlap(const std::string& text) {
  if (text == "auto") return 0;
  const double share = parse_number(text, "--overlap");
  if (!(share > 0 && share <= 1))
    throw UsageError(fmt::format("--overlap: '{}' is not auto or a share above 0 and up to 1", text));
  return share;
}

/// Pairs of points slide along each other slowly: of 24 right poses that were not yet found to stand still after 100
/// steps (bench/trust_study.py) all but two were of this objective.
constexpr int most_steps_of_points = 500;

void add_match_options(Command& command, MatchOptions& options) {
  command.heading("Matching");
  command
      .choice("--objective", options.objective,
              {{"measure", Objective::measure},
               {"icp-point", Objective::icp_point},
               {"icp-plane", Objective::icp_plane},
               {"icp-gicp", Objective::icp_gicp},
               {"currents", Objective::currents}},
              "What is minimised: the measure between the surfaces, or the distances of pairs of nearest points, to "
              "the point, to the plane at it, or between the planes at both (Generalized-ICP), or the distance of the "
              "surfaces "
              "as currents")
      .each([&options](const std::string& objective) {  // before --max-iterations is looked at, which wins
        if (objective == "icp-point") options.max_iterations = most_steps_of_points;
      });
  command.flag("--coarse", options.coarse,
               "Search for a start first: any rotation, any shift that leaves half of a scan in common");
  command.parsed("--overlap", "auto|SHARE", options.overlap, parse_overlap,
                 "Share of the common area that is fitted; auto: all that differs no more than noise; 1: everything "
                 "(default auto)");
  command.parsed("--freedom", "LIST", options.freedom, parse_freedom,
                 "Motions that are searched, in the axes of the projection: x, y, z, turn-x, turn-y, turn-z, scale "
                 "(default all but scale)");
  command
      .option("--max-iterations", "N", options.max_iterations,
              "Most steps of the search on all points; icp-point, whose steps are many and small, has 500 by default")
      .check(whole_number(1, 100000))
      .show_default();
  command
      .option("--tolerance", "SHARE", options.tolerance,
              "The search has converged when a step moves the scan by less than this share of its extent (default "
              "1e-8, or where a step is negligible against the effect of noise on the pose)")
      .check(positive());
  add_accept_doubt(command, options.accept_doubt);
}

void add_accept_doubt(Command& command, bool& accept_doubt) {
  command.flag("--accept-doubt", accept_doubt,
               "Take the pose although the verdict on it is not 'trusted': for those who know that the surface changed "
               "over most of its area, or which of several places is right");
}

void refuse_match_options(const MatchOptions& options, const std::string& without) {
  const MatchOptions plain;
  const Freedom &f = options.freedom, &g = plain.freedom;
  const auto refuse = [&](bool given, const char* name) {
    if (given) throw UsageError(fmt::format("{}: it says how to match: give it with {}", name, without));
  };
  refuse(options.objective != plain.objective, "--objective");
  refuse(options.coarse, "--coarse");
  refuse(options.overlap != plain.overlap, "--overlap");
  refuse(f.shift_x != g.shift_x || f.shift_y != g.shift_y || f.shift_z != g.shift_z || f.turn_x != g.turn_x ||
             f.turn_y != g.turn_y || f.turn_z != g.turn_z || f.scale != g.scale,
         "--freedom");
  refuse(options.max_iterations != plain.max_iterations, "--max-iterations");
  refuse(options.tolerance != plain.tolerance, "--tolerance");
  refuse(options.accept_doubt, "--accept-doubt");
}

int run_match(const Arguments& arguments) {
  Request request;
  CompareOptions& compare = request.options.compare;
  Command command("match", description, footer);
  command.positional("MOVING", request.moving, "Scan to be moved; any format that compare reads");
  command.positional("FIXED", request.fixed, "Scan that stays where it is");
  add_output_options(command, request.delivery);
  add_pose_only(command, request);
  add_scan_options(command, compare.project, request.start, compare.unit,
                   "Direction that heights are measured along; fit: normal of the plane fitted to both scans (default "
                   "z)",
                   "Height of points of one scan with the same place; error: refuse such a scan",
                   {"--start", "the row-major matrix that takes MOVING to FIXED, to start from (default: as is)"});
  command.flag("--allow-crs", compare.allow_crs,
               "Match although the CRS is in degrees, is Web Mercator, or differs between the scans");
  add_border_options(command, compare);
  add_visible_option(command, request.visible);
  command.heading("Matching");
  command.parsed(
      "--weight", "FORMULA|@ATTRIBUTE|FILE", compare.weight,
      +[](const std::string& text) { return parse_weight(text); },
      "Weight of 0 or more of what is fitted: a formula of x, y, z1, z2, slope1, slope2 at the points of FIXED; an "
      "attribute of the points, of MOVING if it has it, else of FIXED, or @a:NAME (FIXED), @b:NAME (MOVING); a raster");
  add_match_options(command, request.options);
  command
      .option("--sigma", "S", request.options.sigma,
              "Width of the kernel of --objective currents, in the unit of the scans (default: five mean edges of the "
              "coarser scan)")
      .check(positive());
  add_pair_options(command, request.options.icp);
  add_run_options(command, request.run);
  if (!command.parse(arguments)) return 0;
  if (!request.start.empty() && request.options.coarse)
    throw UsageError("--start and --coarse: give a start, or let the program search for one, not both");
  request.options.judge = !request.pose_only;
  const bool may_write = !request.delivery.output.empty() || !session().shell;
  request.options.keep_comparisons = may_write && !request.delivery.no_map;
  request.options.label_points = may_write;
  if (!request.start.empty()) request.options.start = read_pose(request.start, "--start");

  Run run(request.run);
  std::unique_ptr<OutputFolder> folder;
  if (!request.delivery.output.empty()) folder = std::make_unique<OutputFolder>(request.delivery.output);
  Stopwatch watch;
  ReadOptions wanted = read_options(compare.project);
  wanted.faces = true;  // files that have some may be nominal meshes
  if (compare.weight.kind == WeightSource::Kind::attribute) wanted.attributes.push_back(compare.weight.text);
  read_rasters(compare, run.context());
  auto answer = std::make_unique<MatchAnswer>();
  CloudView &moving = answer->moving, &fixed = answer->fixed;
  moving = scan_named(request.moving, wanted, run.context());
  fixed = scan_named(request.fixed, wanted, run.context());
  if (request.visible) {
    CloudView seen = visible_of(fixed, {}, moving, compare.project, run.context());
    moving = visible_of(std::move(moving), request.options.start, fixed, compare.project, run.context());
    fixed = std::move(seen);
  }
  const double read_s = watch.lap();
  answer->matching = match(moving, fixed, request.options, run.context());
  answer->project = compare.project;
  add_read_time(answer->matching.timing, read_s);
  return finish(std::move(answer), request.delivery, folder.get(), run);
}

}  // namespace isopach::cli
