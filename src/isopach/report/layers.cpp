#include "isopach/report/layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "isopach/base/error.hpp"
#include "isopach/base/memory.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/measured_cells.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/page/words.hpp"

namespace isopach {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double most_pixels = 0x1p30;        // none of today's rasters is larger
constexpr std::uint64_t bytes_a_pixel = 130;  // sums and bands

/// Along one axis: the multiples of the step that hold all from `low` to `high`, which are local coordinates.
struct Span {
  double first = 0, count = 1;  // in steps
  Span(double low, double high, double offset, double step) {
    first = std::floor((low + offset) / step);
    double last = std::ceil((high + offset) / step);
    if (first * step - offset > low) first -= 1;  // by rounding
    if (last * step - offset < high) last += 1;
    count = std::max(1.0, last - first);
  }
};

Box2 box_of(const MeasuredCells& cells) {
  Box2 box;
  for (const auto& t : cells.triangles)
    for (const std::int32_t v : t) box.add(cells.xy[static_cast<std::size_t>(v)]);
  if (box.empty()) box.add(Point2{0, 0});
  return box;
}

/// Row by row from the top, `value(i)` of the sums, whose rows go up.
template <class F>
Array<double> from_top(const PixelGrid& grid, F&& value) {
  Array<double> out(grid.columns * grid.rows);
  for_each_index(out.size(), [&](std::size_t i) {
    out[i] = value(i % grid.columns + grid.columns * (grid.rows - 1 - i / grid.columns));
  });
  return out;
}

/// ∫ of the level over each pixel.
Array<double> level_over(const MeasuredCells& cells, const PixelGrid& grid, const Context& context) {
  Array<double> known(cells.lod.size());
  for_each_index(known.size(), [&](std::size_t i) { known[i] = std::isfinite(cells.lod[i]) ? cells.lod[i] : 0; });
  return sum_over_pixels({cells.xy, known, known, cells.triangles}, grid, context).z1;
}

std::string hex(const Rgb& colour) {
  const auto byte = [](double v) { return static_cast<int>(std::lround(255 * std::clamp(v, 0.0, 1.0))); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(colour.r), byte(colour.g), byte(colour.b));
}

}  // namespace

void require_map_direction(const ProjectOptions& options, const std::string& option) {
  const Direction& d = options.direction;
  const bool up = d.kind == Direction::Kind::vector && d.vector.x == 0 && d.vector.y == 0 && d.vector.z > 0;
  if (d.kind == Direction::Kind::axis_z || up) return;
  throw UsageError(option +
                   ": it is in x and y, so it goes with @direction z alone; leave the direction, or turn the scans by "
                   "@pose");
}

namespace {

/// Pixels that cover a box of the frame, and where they lie in the input.
struct MapGrid {
  PixelGrid pixels;
  std::array<double, 6> geotransform{};

  MapGrid(const Box2& box, const std::array<double, 3>& offset, double step) {
    const Span across(box.min.x, box.max.x, offset[0], step), up(box.min.y, box.max.y, offset[1], step);
    if (!(across.count * up.count <= most_pixels))
      throw UsageError(fmt::format("@raster: {:.4g} by {:.4g} pixels are too many: choose a larger step than {}",
                                   across.count, up.count, step));
    const auto bytes = static_cast<std::uint64_t>(across.count * up.count) * bytes_a_pixel;
    if (bytes > usable_memory())
      throw UsageError(
          fmt::format("@raster: {:.4g} by {:.4g} pixels take about {}, and there are {}: choose a larger step than {}",
                      across.count, up.count, bytes_in_words(bytes), bytes_in_words(usable_memory()), step));
    pixels = {across.first * step - offset[0], up.first * step - offset[1], step,
              static_cast<std::size_t>(across.count), static_cast<std::size_t>(up.count)};
    geotransform = {across.first * step, step, 0, (up.first + up.count) * step, 0, -step};
  }
};

/// d, coverage, z_a, z_b.
RasterLayers layers_of(const MapGrid& grid, const PixelSums& sums, double height_offset, const Comparison& c) {
  RasterLayers layers;
  const double step = grid.pixels.step;
  layers.columns = grid.pixels.columns, layers.rows = grid.pixels.rows;
  layers.geotransform = grid.geotransform;
  layers.crs = c.a.crs.empty() ? c.b.crs : c.a.crs;
  const std::string unit = height_unit(c) == "unknown" ? "" : height_unit(c);
  const auto mean = [&](const Array<double>& of, double offset) {
    return from_top(grid.pixels, [&](std::size_t i) { return sums.area[i] > 0 ? of[i] / sums.area[i] + offset : nan; });
  };
  layers.bands.push_back({"d", unit, mean(sums.d, 0)});
  layers.bands.push_back(
      {"coverage", "", from_top(grid.pixels, [&](std::size_t i) { return sums.area[i] / (step * step); })});
  layers.bands.push_back({"z_a", unit, mean(sums.z1, height_offset)});
  layers.bands.push_back({"z_b", unit, mean(sums.z2, height_offset)});
  return layers;
}

/// No height in the frame, and no difference of two, is larger.
double largest_height(const Comparison& c, const MeasuredCells& cells) {
  const Box3& box = c.frame.box;
  if (!box.empty()) return std::max(std::fabs(box.min.z), std::fabs(box.max.z)) + (box.max.z - box.min.z);
  double height = 0;
  for (std::size_t i = 0; i < cells.z1.size(); ++i)
    height = std::max(height, std::fabs(cells.z1[i]) + std::fabs(cells.z2[i]));
  return height;
}

std::array<Corner, 3> corners_of(const MeasuredCells& cells, std::size_t i) {
  std::array<Corner, 3> at{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto v = static_cast<std::size_t>(cells.triangles[i][k]);
    at[k] = {cells.xy[v].x, cells.xy[v].y, cells.z1[v], cells.z2[v]};
  }
  return at;
}
std::array<Corner, 3> corners_of(const CellPart& part, std::size_t i) {
  std::array<Corner, 3> at{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Index v = part.triangles[i][k];
    at[k] = {part.xy[v].x, part.xy[v].y, part.z1[v], part.z2[v]};
  }
  return at;
}

/// f(corners) for all cells, those of the parts first.
template <class F>
void for_corners(const PartedCells& parted, const MeasuredCells& rest, const Context& context, F&& f) {
  constexpr std::size_t some = std::size_t{1} << 18;
  for (std::size_t begin = 0; begin < parted.in_parts(); begin += some) {
    context.check();
    parted.visit(begin, std::min(begin + some, parted.in_parts()),
                 [&](const auto& view, std::size_t from, std::size_t to) {
                   if constexpr (std::is_same_v<std::decay_t<decltype(view)>, CellPart>)
                     for (std::size_t i = from; i < to; ++i) f(corners_of(view, i));
                 });
  }
  for (std::size_t i = 0; i < rest.triangles.size(); ++i) f(corners_of(rest, i));
}

bool is_even(const Comparison& c) { return c.uncertainty.lod && c.uncertainty.lod_is_given; }

/// The integral over each pixel of a level of detection that is the same everywhere.
Array<double> even_level(double lod, const PixelSums& sums) {
  Array<double> level(sums.area.size());
  for_each_index(level.size(), [&](std::size_t i) { level[i] = lod * sums.area[i]; });
  return level;
}

/// Level of detection, and d as a multiple of it. `level`: its integral over each pixel.
void add_level(RasterLayers& layers, const MapGrid& grid, const PixelSums& sums, const Array<double>& level) {
  const std::string unit = layers.bands[0].unit;
  layers.bands.push_back({"lod", unit, from_top(grid.pixels, [&](std::size_t i) {
                            return sums.area[i] > 0 ? level[i] / sums.area[i] : nan;
                          })});
  layers.bands.push_back({"significance", "", from_top(grid.pixels, [&](std::size_t i) {
                            return level[i] > 0 ? sums.d[i] / level[i] : nan;
                          })});
}

}  // namespace

RasterLayers difference_layers(const Comparison& c, double step, const Context& context) {
  const MeasuredCells cells = in_order(measured_cells(c));
  const MapGrid grid(box_of(cells), cells.offset, step);
  PixelAdder adder(grid.pixels, largest_height(c, cells));
  for (std::size_t i = 0; i < cells.triangles.size(); ++i) {
    if (i % 4096 == 0) context.check();
    adder.add(corners_of(cells, i));
  }
  const PixelSums sums = adder.sums();
  RasterLayers layers = layers_of(grid, sums, cells.offset[2], c);
  if (!cells.lod.empty())
    add_level(layers, grid, sums,
              is_even(c) ? even_level(*c.uncertainty.lod, sums) : level_over(cells, grid.pixels, context));
  return layers;
}

RasterLayers difference_layers(const PartedCells& parted, const Comparison& c, double step, const Context& context) {
  const MeasuredCells rest = in_order(measured_cells(c));
  Box2 box;
  for_corners(parted, rest, context, [&](const std::array<Corner, 3>& at) {
    for (const Corner& p : at) box.add(Point2{p.x, p.y});
  });
  if (box.empty()) box.add(Point2{0, 0});
  return difference_layers(parted, c, step, box, context);
}

RasterLayers difference_layers(const PartedCells& parted, const Comparison& c, double step, const Box2& within,
                               const Context& context) {
  const MeasuredCells rest = in_order(measured_cells(c));
  const MapGrid grid(within, rest.offset, step);
  PixelAdder adder(grid.pixels, largest_height(c, rest));
  for_corners(parted, rest, context, [&](const std::array<Corner, 3>& at) { adder.add(at); });
  const PixelSums sums = adder.sums();
  RasterLayers layers = layers_of(grid, sums, rest.offset[2], c);
  if (is_even(c)) add_level(layers, grid, sums, even_level(*c.uncertainty.lod, sums));
  return layers;
}

std::string raster_style(const Comparison& c, const MapOptions& look) {
  constexpr int steps = 8;  // each way
  const Palette palette(look.palette, look.flip != paints_excess_red(c.unit));
  const double limit = colour_limit(c, look);
  std::string items;
  for (int k = -steps; k <= steps; ++k) {
    const double t = static_cast<double>(k) / steps;
    items += fmt::format("          <item value=\"{0}\" label=\"{0:.4g}\" color=\"{1}\" alpha=\"255\"/>\n", t * limit,
                         hex(palette(t)));
  }
  return fmt::format(
      "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
      "<qgis version=\"3.22\" styleCategories=\"Symbology\">\n"
      "  <pipe>\n"
      "    <rasterrenderer type=\"singlebandpseudocolor\" band=\"1\" opacity=\"1\" alphaBand=\"-1\" "
      "classificationMin=\"{0}\" classificationMax=\"{1}\" nodataColor=\"\">\n"
      "      <rastershader>\n"
      "        <colorrampshader colorRampType=\"INTERPOLATED\" classificationMode=\"1\" clip=\"0\" "
      "minimumValue=\"{0}\" maximumValue=\"{1}\" labelPrecision=\"4\">\n{2}"
      "        </colorrampshader>\n"
      "      </rastershader>\n"
      "    </rasterrenderer>\n"
      "  </pipe>\n"
      "</qgis>\n",
      -limit, limit, items);
}

}  // namespace isopach
