// Picture: what map and view show of a comparison whose cells lie in parts and are too many to be drawn.
#pragma once
#include <optional>

#include "isopach/measure/parted_cells.hpp"
#include "isopach/report/report.hpp"

namespace isopach {

/// Means over squares as cells: a node at the middle of each square of which half or more was measured, and triangles
/// between squares that lie side by side; of ground narrower than squares a node for each square it touches. Drawn in
/// place of the cells themselves; no number is made of it.
struct Picture {
  Cells cells;
  double side = 0;  ///< of the squares, in the unit of x and y
};

/// As fine as a map of look.width pixels shows, of what both scans may share or of look.extent; no square holds less
/// than a node on average. The same for any tiling. Cost: one look at the cells, some 200 bytes a square, of which
/// there are at most a million for a map of 1600 pixels. Test: tests/cli/tile_pages_test.py.
[[nodiscard]] Picture picture_of(const PartedCells& cells, const Comparison& c, const MapOptions& look,
                                 const Context& context);

/// "drawn by means over squares of 2.5 m".
[[nodiscard]] std::string drawn_by(const Picture& picture, const Comparison& c);

}  // namespace isopach
