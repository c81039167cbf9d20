// How QGIS shows the vector layers: .qml files beside them, in the colours of the map. Read by name: contours.qml is
// the style of contours.geojson, contours.gpkg and contours.fgb. Loaded by QGIS 3.22: tests/cli/qgis_test.py.
#pragma once
#include <string>

#include "isopach/report/report.hpp"

namespace isopach {

/// Lines by their d: gained, lost, no difference, darker the larger |d| is.
[[nodiscard]] std::string contours_style(const Comparison& c, const MapOptions& look);

/// Objects by whether they are gained or lost.
[[nodiscard]] std::string changes_style(const Comparison& c, const MapOptions& look);

/// Tiles of a job by their state.
[[nodiscard]] std::string tile_states_style();

/// What was compared, filled; what each scan covers, as lines.
[[nodiscard]] std::string outlines_style(const Comparison& c, const MapOptions& look);

}  // namespace isopach
