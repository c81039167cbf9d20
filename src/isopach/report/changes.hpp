// Changes as objects: table, outlines, and how they are drawn. All of these where c.changes is there.
#pragma once
#include <string>
#include <vector>

#include "isopach/report/report.hpp"

namespace isopach {

/// changes.csv: one line an object, the largest volume first, numbers as in result.json (null: empty).
[[nodiscard]] std::string changes_csv(const Comparison& c);

/// changes.geojson: one feature an object, with its outline in input coordinates and the numbers of changes.csv. The
/// CRS stands in it as GDAL and QGIS read it, where it is known by an EPSG number.
[[nodiscard]] std::string changes_geojson(const Comparison& c);

/// Outlines for a map; the largest objects have their numbers.
[[nodiscard]] std::vector<MapLine> change_lines(const Comparison& c);

/// How many objects are how large, as a figure in HTML; empty below three objects.
[[nodiscard]] std::string change_chart(const Comparison& c);

/// The objects in one sentence.
[[nodiscard]] std::string change_sentence(const Comparison& c);

}  // namespace isopach
