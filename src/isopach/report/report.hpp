// Reports: JSON, map, PLY, HTML from a Comparison. Computes nothing that is not in it already.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/simulate/scene.hpp"

namespace isopach {

struct Image;
struct Matching;

/// result.json (schema isopach.compare/1): keys in the order of docs/schema/compare-1.json, no NaN, shortest round-trip
/// numbers, two-space indent. `outputs` are the files written beside it.
[[nodiscard]] std::string comparison_json(const Comparison& c, const std::vector<std::string>& outputs);

/// histogram.csv: a line "d_from,d_to,area" a bin, numbers in shortest round-trip form. The outermost bins also hold
/// what lies beyond them.
[[nodiscard]] std::string histogram_csv(const Comparison& c);

/// budget.csv: one line a polygon, numbers as in result.json (null: empty), names quoted where they need it.
[[nodiscard]] std::string budget_csv(const Comparison& c);

/// Words on a map that shows another field than B − A. Empty: those of a comparison.
struct MapWords {
  std::string headline;      ///< the line of numbers under the title
  std::string where;         ///< the line under it
  std::string above, below;  ///< at the ends of the colour bar
  std::string zero;          ///< beside the colour of 0
  std::string left_out;      ///< beside the colour of what is scanned but has no value
  std::string note;          ///< what the colours mean, at the foot
  std::string across, up;    ///< names of the axes; empty: those of the input
  std::string drawn;         ///< on the page: of what map and view are drawn, where that is not the cells
};

/// A line drawn over the map, with a label at its beginning.
struct MapLine {
  Array<Point2> xy;  ///< frame coordinates
  std::string label;
};

/// A PNG that somebody gives, decoded and on white, and as PNG again: nothing of the file itself gets into a page.
struct Logo {
  std::shared_ptr<const Image> image;  ///< null: none
  std::string png;
};
/// InputError naming `path` for bytes that are no PNG, damaged, more than largest_logo, or wider or higher than
/// widest_logo.
[[nodiscard]] Logo logo_of(std::string_view bytes, const std::string& path);
inline constexpr std::size_t largest_logo = 1'000'000;  ///< bytes
inline constexpr int widest_logo = 2000;                ///< pixels

struct MapOptions {
  std::string title;                 ///< default: names of A and B
  std::string palette = "blue-red";  ///< see palettes(); diverging, centred on 0
  bool flip = false;                 ///< swap the two ends
  int width = 1600;                  ///< pixels
  /// Of the surface that people turn in the page, see report/view/view.hpp; 0: none; default: what a page of 5 MB has
  /// room for.
  std::optional<std::size_t> vertices = {};
  MapWords words;
  std::vector<MapLine> lines;
  double range = 0;                 ///< > 0: colours from −range to +range; 0: as colour_limit says
  std::optional<Box2> extent = {};  ///< what the map shows, x and y of the input; default: what was compared
  std::string author, date;         ///< on map and page; date: of the run, YYYY-MM-DD
  Logo logo;                        ///< on map and page
};

/// Names of the palettes, the default first.
[[nodiscard]] std::vector<std::string> palettes();

/// difference.png, or difference.svg where the path ends so (text is text; the surface a picture within): hillshade of
/// surface A under the diverging colours of d, scale bar, colour bar with the histogram along it, units, title. No
/// display needed.
void write_map(const std::string& path, const Comparison& c, const MapOptions& options, const Context& context);

/// difference.ply: the cells in the domain, input coordinates, z of surface B, `dz` per vertex (binary, doubles), and
/// where there is a level of detection, this (`lod95`, `lod`) and `significant`: 1 where |dz| exceeds it, else 0.
void write_cells(const std::string& path, const Comparison& c, const Context& context);

/// The same of the exact overlay, which the comparison must have kept (CompareOptions::keep_overlay).
void write_overlay_cells(const std::string& path, const Comparison& c, const Context& context);

/// The fields of points_a and points_b: dz_signed, dz_abs, and with a level of detection this and `significant` (1 or
/// 0); NaN where undefined. Names fit LAS extra bytes.
[[nodiscard]] std::vector<Attribute> attributes_of(const PointFields& fields);

/// points_a.ply / points_b.ply: the input points with attributes_of(fields).
void write_points(const std::string& path, const CloudView& cloud, const PointFields& fields, const Context& context);

/// What a page shows beside the numbers of a comparison.
struct PageOptions {
  std::string map_png;           ///< path of the map, already written; empty: no map
  std::optional<Truth> truth;    ///< stands beside the result
  MapOptions look;               ///< the palette of the map, for the histogram, and its title
  const Matching* matched = {};  ///< how B was moved before, said under the headline; null: it was not
};

/// report.html: one file that opens from disk without a network: map, numbers with units and one-line explanations,
/// histogram, parameters, warnings. `json` is the text of comparison_json: every number on the page is read from it.
void write_html(const std::string& path, const Comparison& c, const std::string& json, const PageOptions& options,
                const Context& context);

}  // namespace isopach
