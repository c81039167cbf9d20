// Part: what a tile found of a comparison, and what it passes up because it cannot know it alone
// (docs/method/tiles.md).
//
// A tile is a square of the curve's quadtree with all points of both scans in it. A triangle of its triangulations is
// *certified*, a triangle of the whole's, if its closed disc lies in the open square: nobody else has points there.
// What follows from certified triangles alone is final: for most cells of T both heights, and that they lie well inside
// what both scans sampled. Final cells are kept beside (CellPart); everything else goes up by its nodes, and is found
// again from these alone (join.hpp). No buffer is read, no point twice.
#pragma once
#include <array>
#include <cstdint>

#include "isopach/base/array.hpp"
#include "isopach/base/fixed_sum.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/geom/disc.hpp"
#include "isopach/measure/parted_cells.hpp"
#include "isopach/measure/volume/detail.hpp"

namespace isopach {

/// What is known of a certified triangle that is passed up.
enum Known : unsigned char {
  border_known = 1,  ///< the border keeps it
  area_known = 2,    ///< it is in no fold either, and its area is in the sums of the part
  detail_known = 4   ///< … and so is what it adds to ρ_dV if its scan is the coarser one
};

/// Three nodes, counter-clockwise, the least first.
using Corners = std::array<Index, 3>;

/// One scan of a tile.
struct ScanPart {
  // Nodes that are passed up, in curve order.
  Array<Point2> xy;
  Array<double> z;
  Array<double> spread;        ///< largest difference of height of the points of each; empty: no points were merged
  Array<Index> in_t;           ///< number of each among the nodes of T of the tile
  Array<unsigned char> asked;  ///< whether it is open if the node is covered by another layer
  Array<Corners> certified;    ///< the certified triangles between them
  Array<unsigned char> known;  ///< bits of Known of each

  // What is settled.
  std::uint64_t nodes = 0;      ///< all nodes of the tile
  std::uint64_t triangles = 0;  ///< certified, passed up or not
  FixedSum border_area;         ///< of triangles with border_known
  DetailOfScan detail;          ///< … with area_known; sums of those with detail_known
  Cleaning cleaning;            ///< of the points of the tile
  LayerCheck layers;            ///< what its nodes tell

  // Where it is known of how many points nodes were made.
  Array<Index> points;         ///< of nodes passed up: points they were made of that are not among `compared`; or empty
  std::uint64_t compared = 0;  ///< points with a difference
};

struct Part {
  OpenBox square;
  std::array<ScanPart, 2> scan;
  std::uint64_t nodes = 0;    ///< of T of the tile
  std::uint64_t cells = 0;    ///< certified triangles of T
  std::uint64_t joining = 0;  ///< of these, those of the interface
  Array<Corners> open;        ///< certified cells that are not final: nodes passed up, of B behind those of A
};

/// Final cells of a tile: the arrays of a CellPart.
struct FinalCells {
  Array<Point2> xy;      ///< all nodes of T of the tile, so that their numbers say where on the curve they are
  Array<double> z1, z2;  ///< at a node of the other scan NaN where the tile does not know it: at no corner of a cell
  Array<Corners> triangles;
  Array<std::array<Index, 2>> points;  ///< by node: of how many points of either scan, where changes are asked for

  [[nodiscard]] CellPart view(std::size_t first_node) const { return {xy, z1, z2, triangles, first_node, points}; }
};

}  // namespace isopach
