// What a comparison in tiles writes: its cells are looked at once more, and not kept.
#include <fmt/format.h>

#include <array>
#include <utility>

#include "cli/answer.hpp"
#include "cli/output.hpp"
#include "cli/parse.hpp"
#include "isopach/base/error.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/layers.hpp"
#include "isopach/report/page/text.hpp"

namespace isopach::cli {
namespace {

/// Before anything is drawn of it.
void check_extent(const MapOptions& map, const Comparison& c) {
  if (!map.extent) return;
  const Box2& e = *map.extent;
  for (const Box3* scan : {&c.a.bounds, &c.b.bounds})
    if (!scan->empty() && e.min.x <= scan->max.x && scan->min.x <= e.max.x && e.min.y <= scan->max.y &&
        scan->min.y <= e.max.y)
      return;
  throw UsageError(
      fmt::format("--extent {},{},{},{}: the scans do not reach into it: give x and y as in the files, or leave it out",
                  e.min.x, e.min.y, e.max.x, e.max.y));
}

bool shows_anything(const Delivery& delivery) {
  return (!delivery.output.empty() && (!delivery.no_map || delivery.map.vertices != 0)) || !delivery.pdf.empty();
}

}  // namespace

std::string TiledAnswer::json(const std::vector<std::string>& outputs) const {
  return comparison_json(comparison, outputs);
}
std::string TiledAnswer::text() const { return comparison_text(comparison, std::nullopt, nullptr); }

LookAtCells TiledAnswer::look(const Delivery& delivery, const Context& context) {
  const bool shows = shows_anything(delivery);
  if (!shows && !(delivery.raster > 0)) return {};
  return [this, shows, step = delivery.raster, map = delivery.map, &context](const PartedCells& cells,
                                                                             const Comparison& c) {
    check_extent(map, c);
    context.step("map", 0);
    if (step > 0) raster = difference_layers(cells, c, step, context);
    if (shows) picture = picture_of(cells, c, map, context);
  };
}

/// As of a comparison in memory, with the picture in place of the cells.
void TiledAnswer::deliver(const Delivery& delivery, OutputFolder* folder, Run& run) {
  Delivery rest = delivery;
  rest.no_cells = rest.no_points = true, rest.raster = 0;
  if (folder != nullptr && raster) {
    write_raster_layers(folder->path("difference.tif"), *raster, run.context());
    folder->write_text("difference.qml", raster_style(comparison, delivery.map));
    raster.reset();
  }
  if (picture) {
    comparison.cells = std::move(picture->cells);
    rest.map.words.drawn = drawn_by(*picture, comparison);
    rest.map.words.where = where_compared(comparison) + "   ·   " + rest.map.words.drawn;
  } else {
    comparison.cells = {};
    rest.no_map = true, rest.map.vertices = 0;
  }
  cli::deliver(comparison, {}, {}, std::nullopt, rest, folder, run, nullptr);
}

void TiledAnswer::require() const {
  const std::string over = exceeded(comparison, tolerances);
  if (!over.empty()) throw Error(ExitCode::tolerance, "--fail-above: " + over);
}

void refuse_files_of_cells(const Delivery& delivery) {
  const std::array<std::pair<const char*, bool>, 4> asked{{{"contours", delivery.contours > 0},
                                                           {"profile", !delivery.profile.empty()},
                                                           {"outlines", delivery.outlines},
                                                           {"vtu", delivery.vtu}}};
  for (const auto& [name, is_asked] : asked)
    if (is_asked)
      throw UsageError(
          fmt::format("--{}: a comparison in tiles has no cells to make it of: leave it out, or take --raster", name));
}

}  // namespace isopach::cli
