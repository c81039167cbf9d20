#include "cli/output.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "cli/answer.hpp"
#include "cli/session.hpp"
#include "isopach/io/las.hpp"
#include "isopach/io/write.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/page/matched.hpp"
#include "isopach/report/page/moved.hpp"
#include "isopach/report/page/text.hpp"

namespace isopach::cli {

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
    write_text_atomically(path, text);
}

void add_map_options(Command& command, MapOptions& map, const std::string& title) {
  std::vector<std::pair<std::string, std::string>> names;
  for (const std::string& name : palettes()) names.emplace_back(name, name);
  command.choice<std::string>("--palette", map.palette, names, "Diverging colours of the map");
  command.flag("--flip-palette", map.flip, "Swap the two ends of the palette");
  command.option("--title", "TEXT", map.title, title);
  command.option("--map-width", "PIXELS", map.width, "Width of the map").check(whole_number(400, 16000)).show_default();
}

Option add_result_options(Command& command, Delivery& delivery, const std::string& files) {
  command.heading("Output");
  const Option folder = command.option("-o,--output", "DIR", delivery.output, files).check(not_empty());
  command
      .option("--json", "FILE", delivery.json, "The result as JSON to FILE; - prints it, and nothing else, on stdout")
      .check(not_empty());
  return folder;
}

void add_delivery_options(Command& command, Delivery& delivery, const std::string& default_folder) {
  delivery.output = default_folder;
  const Option folder = add_result_options(
      command, delivery,
      "Folder for result.json, histogram.csv, report.html, difference.png, difference.ply, "
      "points_a.ply, points_b.ply, with polygons budget.csv (LAS in: also points_a.las); made if it is not there");
  if (!default_folder.empty()) folder.show_default();
  add_map_options(command, delivery.map, "Title of map and report; without it the names of the scans");
  command.flag("--no-map", delivery.no_map, "No difference.png, and no picture in the report");
  command.flag("--no-cells", delivery.no_cells, "No difference.ply");
  command.flag("--no-points", delivery.no_points, "No points_a and points_b");
}

namespace {

/// points_a.ply, and for LAS input points_a.las with the same fields as extra bytes.
void write_scan(const CloudView& cloud, const PointFields& fields, const std::string& name, OutputFolder& folder,
                const Context& context) {
  write_points(folder.path(name + ".ply"), cloud, fields, context);
  if (!is_las_file(cloud)) return;
  write_las_with_fields(cloud, folder.path(name + "." + cloud.format), attributes_of(fields), context);
}

/// difference.ply shows the cells that were measured; with --surface both the overlay's stand beside those of T.
void write_all_cells(const Comparison& c, OutputFolder& folder, const Context& context) {
  if (c.options.surface != Surface::overlay) write_cells(folder.path("difference.ply"), c, context);
  if (c.options.surface == Surface::common) return;
  write_overlay_cells(folder.path(c.options.surface == Surface::both ? "difference_overlay.ply" : "difference.ply"), c,
                      context);
}

}  // namespace

void add_read_time(Timing& timing, double seconds) {
  timing.stages.insert(timing.stages.begin(), {"read", seconds});
  timing.total += seconds;
}

void set_write_time(Timing& timing, double seconds) {
  if (!timing.stages.empty() && timing.stages.back().first == "write") {
    timing.total -= timing.stages.back().second;
    timing.stages.pop_back();
  }
  timing.stages.emplace_back("write", seconds);
  timing.total += seconds;
}

void Answer::add_output_options(Command&, Delivery&) const {}

int finish(std::unique_ptr<Answer> answer, const Delivery& delivery, OutputFolder* folder, Run& run) {
  if (!session().shell) {
    session().answer = std::move(answer);
    return 0;
  }
  answer->deliver(delivery, folder, run);
  answer->require();
  return 0;
}

void deliver(Comparison& comparison, const CloudView& a, const CloudView& b, const std::optional<Truth>& truth,
             const Delivery& delivery, OutputFolder* folder, Run& run, const Matching* matched) {
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

  set_write_time(comparison.timing, watch.lap());

  std::string json;
  if (folder != nullptr) {
    // Both files hold the list of all files, themselves among them.
    const std::string report = folder->path("report.html"), result = folder->path("result.json"),
                      histogram = folder->path("histogram.csv");
    json = comparison_json(comparison, folder->names(), matched);
    write_text_atomically(result, json);
    write_text_atomically(histogram, histogram_csv(comparison));
    write_html(report, comparison, json, {map, truth, delivery.map, matched}, context);
    context.check();
    folder->commit();
  } else if (!delivery.json.empty()) {
    json = comparison_json(comparison, {}, matched);
  }
  if (!delivery.json.empty()) write_json(delivery.json, json, run);

  if (delivery.json != "-") {
    run.show(comparison_text(comparison, truth, matched));  // warnings included
  } else {
    for (const std::string& warning : comparison.warnings) run.warn(warning);
  }
}

}  // namespace isopach::cli
