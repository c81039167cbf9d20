// join_tiles: the comparison of the whole from what its tiles found and passed up (docs/method/tiles.md).
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/compare/displacement.hpp"
#include "isopach/measure/parted_cells.hpp"
#include "isopach/tiles/part.hpp"

namespace isopach {

/// By scan and tile, at each node that was passed up: the height of the other surface there, NaN where there is no
/// difference (stages::compared_nodes). At nodes that their tile knows more of it is not to be asked.
using HeightsOfOther = std::array<std::vector<Array<double>>, 2>;

struct TilesToJoin {
  std::vector<Part> parts;  ///< of all tiles that hold a point, in the order of the curve
  /// Final cells of each, with first_node as nodes of T are counted from tile to tile.
  std::vector<PartedCellsPart> cells;
  std::array<bool, 2> is_raster{false, false};
  HeightsOfOther* heights = nullptr;  ///< to be filled; null: nobody asks
  /// Called with all cells, once `c` is what it becomes; may be empty.
  std::function<void(const PartedCells& cells)> look;
};

/// The nodes passed up are triangulated once more. With the certified triangles of the tiles, the triangles of these
/// nodes whose disc lies in no single square are those of the whole (theorem 4), so everything that tiles left open is
/// found by the same functions as in compare(), on a few nodes.
/// `c`: a comparison of which options, frame, inputs and unit are known. Measures, domain, border, folds, detail and
/// counts of triangles become those of compare() on all points, to the last bit; visited_… stay 0, and c.cells are
/// those that were left open alone. Errors as compare(). Cost O(n log n) of what was passed up, and two looks at each
/// final cell. Oracle: compare(), tests/tiles/join_test.cpp. Gives what plain_displacement() of the whole does.
std::optional<Displacement> join_tiles(TilesToJoin tiles, Comparison& c, const Context& context);

}  // namespace isopach
