// The section of both surfaces along a line, as table and chart.
#pragma once
#include <span>
#include <string>

#include "isopach/report/report.hpp"

namespace isopach {

/// profile.csv: s (way along the line), x, y, z_a, z_b, d, and lod where there is a level of detection. A row at every
/// corner of the line and at every side of a cell that it crosses: between two rows everything is linear. Heights are
/// empty in a row where the line leaves what was measured. `line` in input coordinates. Oracle:
/// tests/report/layers_test.cpp.
[[nodiscard]] std::string profile_csv(const Comparison& c, std::span<const Point2> line, const Context& context);

/// profile.svg: both surfaces, and d with the level of detection. UsageError where the line crosses nothing that was
/// measured.
[[nodiscard]] std::string profile_svg(const Comparison& c, std::span<const Point2> line, const Context& context);

}  // namespace isopach
