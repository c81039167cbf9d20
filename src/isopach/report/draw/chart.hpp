// Charts of lines as SVG for reports: no script, colours that colour-blind readers can tell apart, text that can be
// read aloud.
#pragma once
#include <string>
#include <vector>

#include "isopach/geom/vec.hpp"

namespace isopach {

struct ChartSeries {
  std::string name;
  std::vector<Point2> points;  ///< in the order of the line; a gap where a coordinate is NaN
  bool dots = false;           ///< dots instead of a line
};

struct Chart {
  std::string title, x_label, y_label;
  std::vector<ChartSeries> series;
  bool equal_scales = false;  ///< x and y are lengths of one unit: a path in a plane
};

/// A figure, HTML. Empty where no point is finite.
[[nodiscard]] std::string chart_svg(const Chart& chart);

}  // namespace isopach
