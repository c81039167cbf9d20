// Reports: JSON, map, PLY, HTML from a Comparison. Computes nothing that is not in it already.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/simulate/scene.hpp"

namespace isopach {

/// result.json (schema isopach.compare/1): keys in the order of CONTRACT.md, no NaN, shortest round-trip numbers,
/// two-space indent. `outputs` are the files written beside it.
[[nodiscard]] std::string comparison_json(const Comparison& c, const std::vector<std::string>& outputs);

struct MapOptions {
  std::string title;                 ///< default: names of A and B
  std::string palette = "blue-red";  ///< see palettes(); diverging, centred on 0
  bool flip = false;                 ///< swap the two ends
  int width = 1600;                  ///< pixels
};

/// Names of the palettes, the default first.
[[nodiscard]] std::vector<std::string> palettes();

/// difference.png: hillshade of surface A under the diverging colours of d, scale bar, colour bar with the histogram
/// along it, units, title. No display needed.
void write_map(const std::string& path, const Comparison& c, const MapOptions& options, const Context& context);

/// difference.ply: the cells in the domain, input coordinates, z of surface B, `dz` per vertex (binary, doubles).
void write_cells(const std::string& path, const Comparison& c, const Context& context);

/// The same of the exact overlay, which the comparison must have kept (CompareOptions::keep_overlay).
void write_overlay_cells(const std::string& path, const Comparison& c, const Context& context);

/// points_a.ply / points_b.ply: the input points with dz_signed and dz_abs (NaN where undefined).
void write_points(const std::string& path, const Cloud& cloud, const PointFields& fields, const Context& context);

/// report.html: one file that opens from disk without a network: map, numbers with units and one-line explanations,
/// histogram, parameters, warnings; with `truth`, the truth beside the result. `map_png` is the path of the map
/// (already written; empty = no map), `json` the text of comparison_json: every number on the page is read from it,
/// `look` the palette of the map, for the histogram.
void write_html(const std::string& path, const Comparison& c, const std::string& map_png, const std::string& json,
                const std::optional<Truth>& truth, const Context& context, const MapOptions& look = {});

}  // namespace isopach
