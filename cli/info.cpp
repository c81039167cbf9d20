// isopach info FILE...
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/answer.hpp"
#include "cli/command.hpp"
#include "cli/output.hpp"
#include "cli/parse.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/base/option_key.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/read.hpp"
#include "isopach/report/info.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "What files hold: points, bounds, unit, CRS, attributes, duplicates, layers along z, spacing.\n";

constexpr const char* footer =
    "duplicates: points with the x and y of another point. layers: share of the area with several surfaces above one\n"
    "another; for a comparison it should be 0. spacing: estimated median distance from a point to its nearest\n"
    "neighbour in the plane.\n"
    "\n"
    "Examples:\n"
    "  isopach info before.laz after.laz\n"
    "  isopach info scan.ply --json -\n"
    "  isopach info scan.ply -o out                               out/report.html";

struct Info {
  Cloud cloud;
  Box3 bounds;
  std::optional<HeightField> field;  ///< none if no point is finite
  double layers = 0, spacing = 0;
};

/// Median over a sample of nodes of the distance to the nearest of the nodes close to it on the curve: with 16 on each
/// side the true nearest neighbour is nearly always among them.
double estimate_spacing(const HeightField& field) {
  constexpr std::size_t samples = 10000, reach = 16;
  const std::size_t n = field.xy.size();
  if (n < 2) return 0;
  std::vector<double> nearest;
  for (std::size_t i = 0; i < n; i += std::max<std::size_t>(1, n / samples)) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = i > reach ? i - reach : 0; j < std::min(n, i + reach + 1); ++j)
      if (j != i) least = std::min(least, std::hypot(field.xy[i].x - field.xy[j].x, field.xy[i].y - field.xy[j].y));
    nearest.push_back(least);
  }
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return *middle;
}

Info inspect(const std::string& path, const ProjectOptions& project_options, const Context& context) {
  Info info;
  ReadOptions options;
  options.all_attributes = true;
  options.faces = true;
  info.cloud = cloud_named(path, options, context);
  for (const Point3& p : info.cloud.points)
    if (is_finite(p)) info.bounds.add(p);
  if (info.bounds.empty()) return info;
  const Frame frame = choose_frame(info.cloud, info.cloud, Pose{}, project_options, context);
  info.field = project(info.cloud, Pose{}, frame, project_options, context);
  info.layers = layered_share(*info.field, info.cloud, Pose{}, frame, context);
  info.spacing = estimate_spacing(*info.field);
  return info;
}

nlohmann::ordered_json to_json(const std::string& path, const Info& info) {
  const Cloud& cloud = info.cloud;
  nlohmann::ordered_json json;
  json["path"] = path;
  json["format"] = cloud.format;
  json["points"] = cloud.points.size();
  json["faces"] = cloud.faces.size();
  json["unit"] = cloud.unit;
  json["vertical_unit"] = cloud.vertical_unit;
  json["crs"] = cloud.crs.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(cloud.crs);
  if (info.bounds.empty())
    json["bounds"] = nullptr;
  else
    json["bounds"] = {{"min", {info.bounds.min.x, info.bounds.min.y, info.bounds.min.z}},
                      {"max", {info.bounds.max.x, info.bounds.max.y, info.bounds.max.z}}};
  json["attributes"] = nlohmann::ordered_json::array();
  for (const Attribute& attribute : cloud.attributes) json["attributes"].push_back(attribute.name);
  json["nodata"] = cloud.nodata;
  json["nonfinite"] = info.field ? info.field->cleaning.dropped_nonfinite : cloud.points.size();
  json["nodes"] = info.field ? info.field->xy.size() : 0;
  json["duplicates"] = info.field ? info.field->cleaning.duplicates : 0;
  json["layered_share"] = info.layers;
  json["spacing"] = info.spacing;
  json["notes"] = nlohmann::ordered_json::array();
  for (const std::string& note : cloud.notes) json["notes"].push_back(for_shell(note));
  return json;
}

std::string span(double low, double high) { return fmt::format("{:.10g} to {:.10g}  ({:.6g})", low, high, high - low); }

/// A CRS as one short line: its name, for WKT what stands in the first quotes.
std::string crs_name(const std::string& crs) {
  const std::size_t open = crs.find('"');
  const std::size_t close = open == std::string::npos ? open : crs.find('"', open + 1);
  if (close == std::string::npos) return crs.empty() ? "none" : crs;
  return crs.substr(open + 1, close - open - 1);
}

std::string to_text(const std::string& path, const Info& info) {
  const Cloud& cloud = info.cloud;
  std::string out = path + "\n";
  const auto row = [&](const char* name, const std::string& value) {
    out += fmt::format("  {:<12} {}\n", name, value);
  };
  row("format", cloud.format);
  row("points", fmt::format("{}", cloud.points.size()));
  if (!cloud.faces.empty()) row("faces", fmt::format("{}", cloud.faces.size()));
  if (cloud.grid) row("grid", fmt::format("{} columns, {} rows", cloud.grid->columns, cloud.grid->rows));
  row("unit",
      cloud.unit == cloud.vertical_unit ? cloud.unit : fmt::format("{}, heights {}", cloud.unit, cloud.vertical_unit));
  row("CRS", crs_name(cloud.crs));
  std::string names;
  for (const Attribute& attribute : cloud.attributes) names += (names.empty() ? "" : " ") + attribute.name;
  row("attributes", names.empty() ? "none" : names);
  if (cloud.nodata > 0) row("no data", fmt::format("{}", cloud.nodata));
  if (!info.field) {
    row("bounds", "none: no point is finite");
    return out;
  }
  row("x", span(info.bounds.min.x, info.bounds.max.x));
  row("y", span(info.bounds.min.y, info.bounds.max.y));
  row("z", span(info.bounds.min.z, info.bounds.max.z));
  const Cleaning& cleaning = info.field->cleaning;
  if (cleaning.dropped_nonfinite > 0) row("not finite", fmt::format("{}", cleaning.dropped_nonfinite));
  row("duplicates", fmt::format("{}{}", cleaning.duplicates,
                                cleaning.duplicates == 0 ? ""
                                                         : fmt::format("  (heights differ by up to {:.6g})",
                                                                       cleaning.duplicate_max_spread)));
  row("layers", info.layers == 0 ? "one" : fmt::format("several over {:.2g} % of the area", 100 * info.layers));
  row("spacing", fmt::format("about {:.3g}", info.spacing));
  for (const std::string& note : cloud.notes) row("note", for_shell(note));
  return out;
}

}  // namespace

int run_info(const Arguments& arguments) {
  std::vector<std::string> paths;
  ProjectOptions project_options;
  RunOptions run_options;
  Command command("info", description, footer);
  command.positional("FILE", paths, "Files to look at");
  Delivery delivery;
  add_result_options(
      command, delivery,
      "Folder for result.json and report.html, with a picture and a view of the first file's points; made "
      "if it is not there");
  command.heading("Scans");
  command.parsed("--direction", "x|y|z|fit|X,Y,Z", project_options.direction, parse_direction,
                 "Direction that duplicates, layers and spacing are seen along (default z)");
  add_run_options(command, run_options);
  if (!command.parse(arguments)) return 0;

  Run run(run_options);
  std::unique_ptr<OutputFolder> folder;
  if (!delivery.output.empty()) folder = std::make_unique<OutputFolder>(delivery.output);
  Array<Point3> first;
  nlohmann::ordered_json json{{"schema", "isopach.info/1"}, {"files", nlohmann::ordered_json::array()}};
  auto answer = std::make_unique<InfoAnswer>();
  for (const std::string& path : paths) {
    Info info = inspect(path, project_options, run.context());
    json["files"].push_back(to_json(name_of_scan(path), info));
    const std::string text = to_text(name_of_scan(path), info);
    answer->words += text;
    if (delivery.json != "-") run.show(text);
    if (folder && json["files"].size() == 1) first = std::move(info.cloud.points);
  }
  answer->record = json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  if (folder) {
    const std::string result = folder->path("result.json"), page = folder->path("report.html");
    write_text_atomically(result, answer->record);
    write_text_atomically(page, info_html(answer->record, first, run.context()));
    run.context().check();
    folder->commit();
    if (delivery.json != "-") run.show("report: " + folder->final_path("report.html"));
  }
  if (!delivery.json.empty()) write_json(delivery.json, answer->record, run);
  return finish(std::move(answer), {}, nullptr, run);
}

}  // namespace isopach::cli
