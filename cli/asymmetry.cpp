// isopach asymmetry FACE
#include "isopach/apps/asymmetry.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <memory>

#include "cli/answer.hpp"
#include "cli/application.hpp"
#include "cli/match.hpp"
#include "cli/parse.hpp"
#include "cli/scans.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/polygons.hpp"
#include "isopach/io/read.hpp"
#include "isopach/report/asymmetry.hpp"
#include "isopach/report/match.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "How the two sides of a face differ: its symmetry plane, an asymmetry index, which side stands out where. FACE is "
    "a\n"
    "scan in any position: the program finds the face, turns it upright and names its sides as the patient's right "
    "and\n"
    "left; it needs no landmarks. For other objects that are nearly symmetric, give --direction.\n";

constexpr const char* footer =
    "Exit codes: 0 done, 2 wrong usage, 3 input cannot be read, 4 no overlap, 5 not converged, 130 interrupted.\n"
    "\n"
    "Examples:\n"
    "  isopach asymmetry face.ply                              index, plane and regions on stdout\n"
    "  isopach asymmetry face.ply -o result --unit mm          and map, report, points with their asymmetry\n"
    "  isopach asymmetry face.ply --rim 8                      without the outermost 8 units: hair, frayed edges\n"
    "  isopach asymmetry face.ply --stable forehead,nose       the plane from parts that are not swollen\n"
    "  isopach asymmetry vase.obj --direction z --visible      not a face: the direction is given";

struct Request {
  std::string face, across, regions, stable;
  AsymmetryOptions options;
  Delivery output;
  RunOptions run;
};

constexpr const char* files_beside =
    "asymmetry.png, points.ply (FACE with the attribute asymmetry), pose.txt (takes FACE to face coordinates)";

}  // namespace

std::string AsymmetryAnswer::json(const std::vector<std::string>& outputs) const {
  return asymmetry_json(asymmetry, outputs);
}
std::string AsymmetryAnswer::text() const { return asymmetry_text(asymmetry); }
void AsymmetryAnswer::add_output_options(Command& command, Delivery& delivery) const {
  add_application_output(command, delivery, files_beside);
}
bool AsymmetryAnswer::draw(const std::string& path, const MapOptions& look, const Context& context) const {
  write_asymmetry_map(path, asymmetry, look, context);
  return true;
}
void AsymmetryAnswer::require() const {
  if (!asymmetry.converged)
    throw Error(ExitCode::not_converged,
                asymmetry.reason + ": the plane is the best one found; allow more steps (--max-iterations)");
}

void AsymmetryAnswer::deliver(const Delivery& delivery, OutputFolder* folder, Run& run) {
  Asymmetry& a = asymmetry;
  const Context& context = run.context();
  const MapOptions& look = delivery.map;
  Delivered files;
  files.write = [&](OutputFolder& out) {
    const std::string map = out.path("asymmetry.png");
    write_asymmetry_map(map, a, look, context);
    if (delivery.svg) write_asymmetry_map(out.path("asymmetry.svg"), a, look, context);
    write_asymmetry_points(out.path("points.ply"), face, a, context);
    out.write_text("pose.txt", pose_text(a.to_face));
    return map;
  };
  files.json = [&](const std::vector<std::string>& outputs) { return asymmetry_json(a, outputs); };
  files.page = [&](const std::string& path, const std::string& map, const std::string& json) {
    write_asymmetry_html(path, a, map, json, look, context);
  };
  files.text = [&] { return asymmetry_text(a); };
  deliver_application(files, a.timing, a.warnings, delivery, folder, run);
}

namespace {

Point3 parse_across(const std::string& text) {
  if (text == "x") return {1, 0, 0};
  if (text == "y") return {0, 1, 0};
  if (text == "z") return {0, 0, 1};
  Point3 v{0, 0, 0};
  double* parts[3] = {&v.x, &v.y, &v.z};
  std::size_t begin = 0;
  for (int k = 0; k < 3; ++k) {
    const std::size_t end = k < 2 ? text.find(',', begin) : text.size();
    if (end == std::string::npos)
      throw UsageError(fmt::format("--across: '{}' is not x, y, z or three numbers X,Y,Z", text));
    *parts[k] = parse_number(text.substr(begin, end - begin), "--across");
    begin = end + 1;
  }
  return v;
}

std::vector<StablePart> parse_stable(const std::string& text) {
  using enum StablePart;
  std::vector<StablePart> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::size_t known = parts.size();
    for (const StablePart part : {forehead, eyes, nose, cheeks, mouth, chin})
      if (word == to_text(part)) parts.push_back(part);
    if (parts.size() == known)
      throw UsageError(
          fmt::format("--stable: '{}' is none of forehead, eyes, nose, cheeks, mouth, chin (commas between)", word));
    begin = end + 1;
  }
  return parts;
}

/// Whether it names a file. A word that is neither a part nor a file is a wrong word.
bool parse_regions(const std::string& text, AsymmetryOptions& options) {
  if (text == "halves") options.parts = FaceParts::halves;
  if (text.empty() || text == "halves" || text == "thirds") return false;
  if (has_polygons(text)) return true;
  std::error_code none;
  if (!std::filesystem::exists(text, none))
    throw UsageError(fmt::format("--regions: '{}' is not thirds, halves or a file of polygons", text));
  return true;
}

}  // namespace

int run_asymmetry(const Arguments& arguments) {
  Request request;
  AsymmetryOptions& options = request.options;
  CompareOptions& compare = options.compare;
  std::optional<Direction> direction;
  Command command("asymmetry", description, footer);
  command.positional("FACE", request.face, "Scan of a face; any format that compare reads");
  add_application_output(command, request.output, files_beside);
  command.heading("Scan");
  command.option_with(
      "--direction", "x|y|z|fit|X,Y,Z", [&](const std::string& text) { direction = parse_direction(text); },
      "Direction from the face to the viewer; fit: normal of the plane fitted to the scan (default: the face is found "
      "in "
      "the scan)");
  command.option(
      "--across", "x|y|z|X,Y,Z", request.across,
      "From one side of the face to the other, roughly; the positive side is the patient's left where the face is "
      "found, else the side in that direction (default x; for --direction x y, for y z)");
  add_points_options(command, compare.project, compare.unit,
                     "Height of points of the scan with the same place; error: refuse such a scan");
  command.flag("--allow-crs", compare.allow_crs, "Go on although the CRS is in degrees or Web Mercator");
  add_border_options(command, compare);
  command.heading("Asymmetry");
  command
      .option("--rim", "WIDTH", options.rim,
              "Points nearer than this to the border of the scan, or of a hole in it, are left out: hair, noise at the "
              "rim (default 0)")
      .check(not_negative());
  command
      .option("--depth", "LENGTH", options.depth,
              "Points farther than this behind the foremost one are left out: the back of a head (default: none)")
      .check(positive());
  command.flag("--visible", options.visible,
               "Of a file with faces: points behind a face, as in the mouth or at the back, are left out");
  command
      .option("--regions", "thirds|halves|FILE", request.regions,
              "Parts of the face with results of their own: by height, or polygons of a file (GeoJSON, GeoPackage, "
              "...) in x "
              "and y of FACE (of a face that looks along y in x and z, along x in y and z), drawn on either side "
              "(default thirds)")
      .check(not_empty());
  command
      .option(
          "--stable", "PARTS", request.stable,
          "Parts that the plane is fitted to alone, because others are swollen, missing or moved: of forehead, eyes, "
          "nose, cheeks, mouth, chin, with commas between (default: all)")
      .check(not_empty());
  command.parsed("--overlap", "auto|SHARE", options.overlap, parse_overlap,
                 "Share of the area that the plane is fitted to; auto: all that differs no more than noise; 1: "
                 "everything (default auto)");
  command.option("--max-iterations", "N", options.max_iterations, "Most steps of a search on all points")
      .check(whole_number(1, 100000))
      .show_default();
  command.flag("--accept-doubt", options.accept_doubt,
               "With --direction or --across: take the plane although both sides of the scan hardly agree about it");
  add_run_options(command, request.run);
  if (!command.parse(arguments)) return 0;
  if (!request.across.empty()) options.across = parse_across(request.across);
  const bool has_polygons = parse_regions(request.regions, options);
  if (!request.stable.empty()) options.stable = parse_stable(request.stable);
  if (options.accept_doubt && !direction && !options.across)
    throw UsageError(
        "--accept-doubt: without --direction and --across the plane is that of the face that was found: leave it out");
  if (direction) {
    options.orientation = FaceOrientation::given;
    compare.project.direction = *direction;
  }

  Run run(request.run);
  const std::unique_ptr<OutputFolder> folder = open_folder(request.output);
  Stopwatch watch;
  ReadOptions wanted = read_options(compare.project);
  wanted.faces = options.visible || options.orientation == FaceOrientation::found;
  if (has_polygons) options.polygons = polygons_named(request.regions);
  auto answer = std::make_unique<AsymmetryAnswer>();
  answer->face = scan_named(request.face, wanted, run.context());
  const double read_s = watch.lap();
  answer->asymmetry = asymmetry(answer->face, options, run.context());
  add_read_time(answer->asymmetry.timing, read_s);
  return finish(std::move(answer), request.output, folder.get(), run);
}

}  // namespace isopach::cli
