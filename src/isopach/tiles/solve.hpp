// solve_tile: what of a comparison the points of one tile decide (part.hpp).
#pragma once
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/compare/options.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/tiles/part.hpp"

namespace isopach {

/// A scan in a tile.
struct TileScan {
  HeightField field;     ///< of the points in the square, in the frame of the pair
  Array<double> spread;  ///< by node, as stages::MergedSpread; empty: none
  bool is_raster = false;
  Array<Index> points;  ///< by node: of how many points it was made; empty: not known
  /// Hull of all nodes of the scan, in whatever tile, counter-clockwise and without three corners on a line: what lies
  /// beyond it of the other scan need not go up. Empty: not known.
  std::vector<Point2> hull;
};

struct TileInput {
  Frame frame;     ///< of the pair
  OpenBox square;  ///< curve_square of the tile
  std::array<TileScan, 2> scan;
};

struct SolvedTile {
  Part part;
  FinalCells cells;
};

/// UsageError, naming the option, for a comparison that tiles do not make.
void check_tiled(const CompareOptions& options);

/// A scan without nodes in the tile is empty. Cost O(n log n). Test: tests/tiles/join_test.cpp.
[[nodiscard]] SolvedTile solve_tile(TileInput input, const CompareOptions& options, const Context& context);

}  // namespace isopach
