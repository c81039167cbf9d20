// Contours of d on the measured cells.
#pragma once
#include <vector>

#include "isopach/compare/measured_cells.hpp"

namespace isopach {

/// Frame coordinates; what is higher lies on the left. Closed lines end where they begin.
struct ContourLine {
  double level = 0;
  std::vector<Point2> xy;
};

/// The lines d = k · step for all whole k, 0 among them: exact on each cell, where d is linear, and joined over the
/// sides that cells share. Where d is equal to a level over an area, that area is taken for higher: a line is its
/// border to what is lower alone. A function of the cells, not of their order. UsageError, naming `option`, for more
/// than 10 000 levels. Cost O(cells + n log n) in the corners of the lines. Oracle:
/// tests/compare/contour_lines_test.cpp (d at the corners; lengths in closed form; ends on the border alone).
[[nodiscard]] std::vector<ContourLine> contour_lines(const MeshView& mesh, double step, const std::string& option,
                                                     const Context& context);

}  // namespace isopach
