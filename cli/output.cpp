#include "cli/output.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/deliver.hpp"
#include "cli/input_words.hpp"
#include "isopach/io/write.hpp"
#include "isopach/report/map.hpp"
#include "isopach/report/matched.hpp"
#include "isopach/report/moved.hpp"
#include "isopach/report/text.hpp"

namespace isopach::cli {
namespace fs = std::filesystem;

namespace {

/// What an earlier run says in `record` that it wrote; nothing where that is no record of isopach.
std::vector<std::string> outputs_of(const fs::path& record) {
  std::error_code error;
  if (!fs::is_regular_file(record, error)) return {};
  std::ifstream file(record, std::ios::binary);
  const nlohmann::json json = nlohmann::json::parse(file, nullptr, false);
  if (!json.is_object()) return {};
  const auto schema = json.find("schema"), outputs = json.find("outputs");
  if (schema == json.end() || !schema->is_string() || schema->get<std::string>().rfind("isopach.", 0) != 0) return {};
  if (outputs == json.end() || !outputs->is_array()) return {};
  std::vector<std::string> names;
  for (const nlohmann::json& name : *outputs)
    if (name.is_string()) names.push_back(name.get<std::string>());
  return names;
}

/// A name within the folder, and no way out of it.
bool is_plain_name(const std::string& name) {
  return !name.empty() && name != "." && name != ".." && name.find_first_of("/\\:") == std::string::npos &&
         name.find('\0') == std::string::npos;
}

bool is_named(const fs::path& file, const std::vector<std::string>& words) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    std::error_code error;
    return fs::equivalent(word, file, error) && !error;
  });
}

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Names that the record of an earlier run lists and this one does not write, of regular files that are no input of
/// this one.
std::vector<std::string> left_over(const fs::path& folder, const std::string& record,
                                   const std::vector<std::string>& written) {
  const std::vector<std::string>& words = input_words();
  std::vector<std::string> names;
  if (is_named(folder, words)) return names;  // a folder of scans that gets its own result
  for (const std::string& name : outputs_of(folder / record)) {
    if (!is_plain_name(name) || holds(written, name)) continue;
    std::error_code error;
    if (!fs::is_regular_file(fs::symlink_status(folder / name, error)) || error) continue;
    if (!is_named(folder / name, words)) names.push_back(name);
  }
  return names;
}

}  // namespace

OutputFolder::OutputFolder(const std::string& folder)
    : folder_(folder), staging_(folder_ / fmt::format(".isopach-{}", getpid())) {
  std::error_code error;
  if (fs::exists(folder_, error) && !fs::is_directory(folder_, error))
    throw UsageError(fmt::format("--output {}: is a file, not a folder", folder));
  std::vector<fs::path> missing;
  for (fs::path p = fs::absolute(folder_).lexically_normal(); !p.empty() && !fs::exists(p, error); p = p.parent_path())
    missing.push_back(p);
  made_.assign(missing.rbegin(), missing.rend());
  fs::create_directories(staging_, error);
  if (error) {
    for (auto p = made_.rbegin(); p != made_.rend(); ++p) fs::remove(*p, error);
    throw UsageError(fmt::format("--output {}: cannot be written to; choose another folder", folder));
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  for (auto p = made_.rbegin(); p != made_.rend(); ++p) fs::remove(*p, ignored);  // removes empty folders only
}

std::string OutputFolder::path(const std::string& name) {
  names_.push_back(name);
  return (staging_ / name).string();
}

void OutputFolder::write_text(const std::string& name, const std::string& text) { write_text_file(path(name), text); }

// A folder holds one result: the files that an earlier run listed in its record and this one does not write go. Nothing
// else is ever removed: no file outside the folder, no folder, no link, no input of this run. The record is put in
// place last, so that a run that is cut short leaves the old list.
void OutputFolder::commit() {
  const std::string record = holds(names_, "result.json") ? "result.json" : "truth.json";  // of simulate
  const auto put = [&](const std::string& name) {
    std::error_code error;
    fs::rename(staging_ / name, folder_ / name, error);
    if (error)
      throw UsageError(fmt::format("--output {}: {} cannot be put there: {}", folder_.string(), name, error.message()));
  };
  for (const std::string& name : names_)
    if (name != record) put(name);
  for (const std::string& name : left_over(folder_, record, names_)) {
    std::error_code error;
    fs::remove(folder_ / name, error);
    if (error)
      throw UsageError(fmt::format("--output {}: {} of an earlier result cannot be removed: {}; choose another folder",
                                   folder_.string(), name, error.message()));
  }
  if (holds(names_, record)) put(record);
}

void write_text_file(const std::string& path, const std::string& text) {
  write_atomically(path, [&](const std::string& temporary) {
    std::ofstream file(temporary, std::ios::binary);
    file << text;
    file.close();
    if (!file) throw UsageError(fmt::format("{}: cannot be written: is the folder there and the disk not full?", path));
  });
}

double Stopwatch::lap() {
  const auto now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - last_).count();
  last_ = now;
  return seconds;
}

void write_json(const std::string& path, const std::string& text, Run& run) {
  if (path == "-")
    run.print(text);
  else
    write_text_file(path, text);
}

void add_map_options(Command& command, MapOptions& map, const std::string& title) {
  std::vector<std::pair<std::string, std::string>> names;
  for (const std::string& name : palettes()) names.emplace_back(name, name);
  command.choice<std::string>("--palette", map.palette, names, "Diverging colours of the map");
  command.flag("--flip-palette", map.flip, "Swap the two ends of the palette");
  command.option("--title", "TEXT", map.title, title);
  command.option("--map-width", "PIXELS", map.width, "Width of the map")
      ->check(whole_number(400, 16000))
      ->capture_default_str();
}

void add_delivery_options(Command& command, Delivery& delivery, const std::string& default_folder) {
  command.heading("Output");
  delivery.output = default_folder;
  CLI::Option* output = command.option(
      "-o,--output", "DIR", delivery.output,
      "Folder for result.json, histogram.csv, report.html, difference.png, difference.ply, "
      "points_a.ply, points_b.ply, with polygons budget.csv (LAS in: also points_a.las); made if it is not there");
  output->check(not_empty());
  if (!default_folder.empty()) output->capture_default_str();
  command
      .option("--json", "FILE", delivery.json, "The result as JSON to FILE; - prints it, and nothing else, on stdout")
      ->check(not_empty());
  add_map_options(command, delivery.map, "Title of map and report; without it the names of the scans");
  command.flag("--no-map", delivery.no_map, "No difference.png, and no picture in the report");
  command.flag("--no-cells", delivery.no_cells, "No difference.ply");
  command.flag("--no-points", delivery.no_points, "No points_a and points_b");
}

namespace {

bool is_las(const Cloud& cloud) { return cloud.format == "las" || cloud.format == "laz"; }

/// points_a.ply, and for LAS input points_a.las with the same fields as extra bytes.
void write_scan(const Cloud& cloud, const PointFields& fields, const std::string& name, OutputFolder& folder,
                const Context& context) {
  write_points(folder.path(name + ".ply"), cloud, fields, context);
  if (!is_las(cloud)) return;
  write_las_with_fields(cloud.path, folder.path(name + "." + cloud.format), attributes_of(fields), context);
}

/// difference.ply shows the cells that were measured; with --surface both the overlay's stand beside those of T.
void write_all_cells(const Comparison& c, OutputFolder& folder, const Context& context) {
  if (c.options.surface != Surface::overlay) write_cells(folder.path("difference.ply"), c, context);
  if (c.options.surface == Surface::common) return;
  write_overlay_cells(folder.path(c.options.surface == Surface::both ? "difference_overlay.ply" : "difference.ply"), c,
                      context);
}

}  // namespace

void deliver(Comparison& comparison, const Cloud& a, const Cloud& b, const std::optional<Truth>& truth,
             const Delivery& delivery, OutputFolder* folder, double read_s, Run& run) {
  deliver(comparison, a, b, truth, delivery, folder, read_s, run, nullptr);
}

void deliver(Comparison& comparison, const Cloud& a, const Cloud& b, const std::optional<Truth>& truth,
             const Delivery& delivery, OutputFolder* folder, double read_s, Run& run, const Matching* matched) {
  const Context& context = run.context();
  Stopwatch watch;
  if (folder != nullptr) {
    if (!delivery.no_cells) write_all_cells(comparison, *folder, context);
    if (!delivery.no_points) {
      write_scan(a, comparison.fields_a, "points_a", *folder, context);
      write_scan(b, comparison.fields_b, "points_b", *folder, context);
    }
  }
  if (folder != nullptr && !comparison.budget.empty()) folder->write_text("budget.csv", budget_csv(comparison));
  std::string map;
  MapOptions look = delivery.map;
  if (matched != nullptr)
    look.words.where = where_compared(comparison) + "   ·   " + moved_briefly(*matched, "B", Typography::fine);
  if (folder != nullptr && !delivery.no_map) write_map(map = folder->path("difference.png"), comparison, look, context);

  const double write_s = watch.lap();
  auto& timing = comparison.timing;
  timing.stages.insert(timing.stages.begin(), {"read", read_s});
  timing.stages.emplace_back("write", write_s);
  timing.total += read_s + write_s;

  std::string json;
  if (folder != nullptr) {
    // Both files hold the list of all files, themselves among them.
    const std::string report = folder->path("report.html"), result = folder->path("result.json"),
                      histogram = folder->path("histogram.csv");
    json = comparison_json(comparison, folder->names(), matched);
    write_text_file(result, json);
    write_text_file(histogram, histogram_csv(comparison));
    write_html(report, comparison, map, json, truth, context, delivery.map, matched);
    context.check();
    folder->commit();
  } else if (!delivery.json.empty()) {
    json = comparison_json(comparison, {}, matched);
  }
  if (!delivery.json.empty()) write_json(delivery.json, json, run);

  if (delivery.json != "-") {
    run.show(comparison_text(comparison, truth, matched));  // warnings included
  } else {
    for (const std::string& warning : comparison.warnings) run.say("warning: " + warning);
  }
}

}  // namespace isopach::cli
