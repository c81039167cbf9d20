#include "cli/output.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>

#include "cli/answer.hpp"
#include "cli/parse.hpp"
#include "cli/session.hpp"
#include "isopach/io/input_file.hpp"
#include "isopach/io/las.hpp"
#include "isopach/io/write.hpp"
#include "isopach/report/changes.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/layers.hpp"
#include "isopach/report/page/matched.hpp"
#include "isopach/report/page/moved.hpp"
#include "isopach/report/page/text.hpp"
#include "isopach/report/profile.hpp"
#include "isopach/report/short_report.hpp"
#include "isopach/report/vector_layers.hpp"
#include "isopach/report/vector_styles.hpp"

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

void add_view_option(Command& command, MapOptions& map) {
  command
      .option("--report-vertices", "N", map.vertices,
              "Most vertices of the surface that the report shows in three dimensions; 0: no such view (default: up to "
              "200000, as many as keep the report below 5 MB)")
      .check(whole_number(0, 20000000));
}

namespace {

/// The day of the run. Where SOURCE_DATE_EPOCH is set, that of these seconds since 1970: builds that must give the same
/// bytes on any day set it.
std::string run_date() {
  std::time_t now = std::time(nullptr);
  const char* const epoch = std::getenv("SOURCE_DATE_EPOCH");  // NOLINT(concurrency-mt-unsafe)
  const std::optional<double> given = epoch != nullptr ? as_number(epoch) : std::nullopt;
  if (given && *given >= 0 && *given < 1e11) now = static_cast<std::time_t>(*given);
  std::tm day{};
  if ((given ? gmtime_r(&now, &day) : localtime_r(&now, &day)) == nullptr) return "";
  return fmt::format("{:04}-{:02}-{:02}", day.tm_year + 1900, day.tm_mon + 1, day.tm_mday);
}

Logo read_logo(const std::string& path) {
  std::error_code none;
  const std::filesystem::file_status status = std::filesystem::status(path, none);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw InputError(path + ": is no file: --logo takes a PNG");
  if (const auto size = std::filesystem::file_size(path, none); !none && size > largest_logo)
    throw InputError(
        fmt::format("{}: has {} kB: --logo takes a PNG of at most {} kB", path, size / 1000, largest_logo / 1000));
  const Context context;
  InputFile file(path, context);
  const std::span<const char> bytes = file.bytes();
  return logo_of({bytes.data(), bytes.size()}, path);
}

}  // namespace

void add_map_options(Command& command, Delivery& delivery, const std::string& title) {
  MapOptions& map = delivery.map;
  map.date = run_date();
  std::vector<std::pair<std::string, std::string>> names;
  for (const std::string& name : palettes()) names.emplace_back(name, name);
  command.choice<std::string>("--palette", map.palette, names, "Diverging colours of the map");
  command.flag("--flip-palette", map.flip, "Swap the two ends of the palette");
  command
      .option(
          "--range", "LIMIT", map.range,
          "Colours of map, histogram and view reach from -LIMIT to LIMIT, in the unit of d, so that results side by "
          "side have the same colours (default: as the differences are)")
      .check(positive());
  command.option("--title", "TEXT", map.title, title);
  command.option("--author", "TEXT", map.author, "Who made them, on map and report, beside the date of the run");
  command.parsed("--logo", "FILE", map.logo, read_logo,
                 "A PNG for map and report, of at most 1000 kB and 2000 pixels either way");
  command.option("--map-width", "PIXELS", map.width, "Width of the map").check(whole_number(400, 16000)).show_default();
  command.flag("--svg", delivery.svg, "Also the map as SVG: words and lines as such, the surface as a picture");
  add_view_option(command, map);
}

Option add_result_options(Command& command, Delivery& delivery, const std::string& files) {
  command.heading("Output");
  const Option folder = command.option("-o,--output", "DIR", delivery.output, files).check(not_empty());
  command
      .option("--json", "FILE", delivery.json, "The result as JSON to FILE; - prints it, and nothing else, on stdout")
      .check(not_empty());
  return folder;
}

void add_page_options(Command& command, Delivery& delivery, const std::string& title) {
  add_map_options(command, delivery, title);
  command.option_with(
      "--extent", "XMIN,YMIN,XMAX,YMAX",
      [&delivery](const std::string& text) { delivery.map.extent = parse_extent(text); },
      "What the map shows, in x and y of the scans, so that results side by side have the same frame (default: what "
      "was "
      "compared)");
  command.choice<bool>("--report", delivery.short_report, {{"full", false}, {"short", true}},
                       "report.html; short: two pages for a client, with the map, the numbers and what they are worth");
  command.option("--pdf", "FILE", delivery.pdf, "The short report as PDF, on two pages of A4, to FILE")
      .check(not_empty());
  command.flag("--no-map", delivery.no_map, "No difference.png, and no picture in the report");
}

void add_delivery_options(Command& command, Delivery& delivery, const std::string& default_folder) {
  delivery.output = default_folder;
  const Option folder =
      add_result_options(command, delivery,
                         "Folder for result.json, histogram.csv, report.html, difference.png, difference.ply, "
                         "points_a.ply, points_b.ply, with polygons budget.csv, of changes changes.csv and "
                         "changes.geojson (LAS in: also points_a.las); made if it is not there");
  if (!default_folder.empty()) folder.show_default();
  add_page_options(command, delivery, "Title of map and report; without it the names of the scans");
  command.flag("--no-cells", delivery.no_cells, "No difference.ply");
  command.flag("--no-points", delivery.no_points, "No points_a and points_b");
  command.heading("Layers");
  command
      .option(
          "--raster", "STEP", delivery.raster,
          "Also difference.tif: a GeoTIFF of d, coverage, both heights, level of detection; each pixel is the exact "
          "mean over what was measured of it. Side of the pixels, in the unit of x and y")
      .check(positive());
  command
      .option("--contours", "STEP", delivery.contours,
              "Also contours.geojson: the lines where d is a multiple of this, 0 included, exact on the cells")
      .check(positive());
  command
      .option("--profile", "X,Y;X,Y...|FILE", delivery.profile,
              "Also profile.csv and profile.svg: the section along a line, with a row at every cell it crosses; its "
              "corners, or a file of them: GeoJSON, or two numbers a line")
      .check(not_empty());
  command.flag("--outlines", delivery.outlines,
               "Also outlines.geojson: what was compared, and what each scan covers, as polygons");
  command.choice<VectorFormat>(
      "--vectors", delivery.vectors,
      {{"geojson", VectorFormat::geojson}, {"gpkg", VectorFormat::gpkg}, {"fgb", VectorFormat::fgb}},
      "Format of contours, outlines and changes: GeoJSON, GeoPackage, FlatGeobuf");
  command.flag("--vtu", delivery.vtu, "Also cells.vtu: the cells with d and both heights, for ParaView");
}

void check_layers(Delivery& delivery, const ProjectOptions& project) {
  const std::array<std::pair<const char*, bool>, 8> asked{{{"svg", delivery.svg},
                                                           {"extent", delivery.map.extent.has_value()},
                                                           {"raster", delivery.raster > 0},
                                                           {"contours", delivery.contours > 0},
                                                           {"profile", !delivery.profile.empty()},
                                                           {"outlines", delivery.outlines},
                                                           {"vectors", delivery.vectors != VectorFormat::geojson},
                                                           {"vtu", delivery.vtu}}};
  for (const auto& [name, is_asked] : asked) {
    if (!is_asked) continue;
    if (session().shell && delivery.output.empty())
      throw UsageError(fmt::format("--{}: acts with --output alone, which names the folder to write into", name));
    constexpr std::array<std::string_view, 3> with_any{"svg", "vtu", "vectors"};
    if (std::find(with_any.begin(), with_any.end(), name) == with_any.end())
      require_map_direction(project, std::string("@") + name);
  }
  if (delivery.raster > 0) need_raster_writer("difference.tif");
  need_vector_writer(delivery.vectors, std::string("vectors.") + ending_of(delivery.vectors));
  if (!delivery.profile.empty() && delivery.line.empty()) delivery.line = read_line(delivery.profile, "--profile");
}

void check_extent(const MapOptions& map, const CloudView& a, const CloudView& b) {
  if (!map.extent) return;
  const Box2& asked = *map.extent;
  Box2 there;
  for (const CloudView* cloud : {&a, &b})
    for (const Point3& p : cloud->points) {
      if (!is_finite(p)) continue;
      if (asked.min.x <= p.x && p.x <= asked.max.x && asked.min.y <= p.y && p.y <= asked.max.y) return;
      there.add(Point2{p.x, p.y});
    }
  const auto text = [](const Box2& box) {
    return fmt::format("{},{},{},{}", box.min.x, box.min.y, box.max.x, box.max.y);
  };
  throw UsageError(
      fmt::format("--extent {}: no point of the scans lies in it{}: give x and y as in the files, or leave "
                  "it out",
                  text(asked), there.empty() ? "" : "; they lie in " + text(there)));
}

namespace {

/// points_a.ply, and for LAS input points_a.las with the same fields as extra bytes.
void write_scan(const CloudView& cloud, const PointFields& fields, const std::string& name, OutputFolder& folder,
                const Context& context) {
  write_points(folder.path(name + ".ply"), cloud, fields, context);
  if (!is_las_file(cloud)) return;
  write_las_with_fields(cloud, folder.path(name + "." + cloud.format), attributes_of(fields), context);
}

const std::string& crs_of(const Comparison& c) { return c.a.crs.empty() ? c.b.crs : c.a.crs; }

void write_layers(const Comparison& c, const Delivery& delivery, OutputFolder& folder, const Context& context) {
  const auto vectors = [&](const std::string& name, const std::string& geojson) {
    write_vectors(folder.path(name + "." + ending_of(delivery.vectors)), geojson, delivery.vectors, crs_of(c));
  };
  if (delivery.raster > 0) {
    const RasterLayers layers = difference_layers(c, delivery.raster, context);
    write_raster_layers(folder.path("difference.tif"), layers, context);
    folder.write_text("difference.qml", raster_style(c, delivery.map));
  }
  if (delivery.contours > 0) {
    vectors("contours", contours_geojson(c, delivery.contours, context));
    folder.write_text("contours.qml", contours_style(c, delivery.map));
  }
  if (!delivery.profile.empty()) {
    folder.write_text("profile.csv", profile_csv(c, delivery.line, context));
    folder.write_text("profile.svg", profile_svg(c, delivery.line, context));
  }
  if (delivery.outlines) {
    vectors("outlines", outlines_geojson(c, context));
    folder.write_text("outlines.qml", outlines_style(c, delivery.map));
  }
  if (delivery.vtu) write_vtu(folder.path("cells.vtu"), c, context);
}

/// difference.ply shows the cells that were measured; with --surface both the overlay's stand beside those of T.
void write_all_cells(const Comparison& c, OutputFolder& folder, const Context& context) {
  if (c.options.surface != Surface::overlay) write_cells(folder.path("difference.ply"), c, context);
  if (c.options.surface == Surface::common) return;
  write_overlay_cells(folder.path(c.options.surface == Surface::both ? "difference_overlay.ply" : "difference.ply"), c,
                      context);
}

}  // namespace

void write_changes(const Comparison& comparison, const Delivery& delivery, OutputFolder& folder) {
  if (!comparison.changes) return;
  folder.write_text("changes.csv", changes_csv(comparison));
  write_vectors(folder.path(std::string("changes.") + ending_of(delivery.vectors)), changes_geojson(comparison),
                delivery.vectors, crs_of(comparison));
  folder.write_text("changes.qml", changes_style(comparison, delivery.map));
}

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
  if (folder != nullptr) write_changes(comparison, delivery, *folder);
  if (comparison.changes) look.lines = change_lines(comparison);
  if (matched != nullptr)
    look.words.where = where_compared(comparison) + "   ·   " + moved_briefly(*matched, "B", Typography::fine);
  if (folder != nullptr) {
    if (!delivery.no_map) write_map(map = folder->path("difference.png"), comparison, look, context);
    if (delivery.svg) write_map(folder->path("difference.svg"), comparison, look, context);
  }
  if (!delivery.pdf.empty())
    write_atomically(delivery.pdf, [&](const std::string& path) {
      write_pdf(path, comparison, look, matched, !delivery.no_map, context);
    });

  if (folder != nullptr) {
    Delivery layers = delivery;
    check_layers(layers, comparison.options.project);
    write_layers(comparison, layers, *folder, context);
  }

  set_write_time(comparison.timing, watch.lap());

  std::string json;
  if (folder != nullptr) {
    // Both files hold the list of all files, themselves among them.
    const std::string report = folder->path("report.html"), result = folder->path("result.json"),
                      histogram = folder->path("histogram.csv");
    json = comparison_json(comparison, folder->names(), matched);
    write_text_atomically(result, json);
    write_text_atomically(histogram, histogram_csv(comparison));
    if (delivery.short_report)
      write_short_html(report, comparison, json, {map, truth, look, matched}, context);
    else
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
