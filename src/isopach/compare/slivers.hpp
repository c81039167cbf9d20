// Border slivers: long thin cells along the border of the scans, which bridge gaps between the outermost points.
//
// A sliver is a cell of the scans with an edge over five times the median of a sample, reached from the rim of the
// domain through such cells.
#pragma once
#include <vector>

#include "isopach/compare/comparison.hpp"
#include "isopach/measure/volume/totals.hpp"

namespace isopach::stages {

/// Cells are sampled by their first node: those of which its number on the curve is a multiple of this.
[[nodiscard]] Index sliver_step(std::size_t cells);

/// From the squares of the longest edges of a sample (reordered): of a sliver it is above this.
[[nodiscard]] double sliver_limit2(std::vector<double>& longest2);

/// Square of the longest edge of a cell.
[[nodiscard]] double longest_edge2(const CellView& cells, std::size_t i);

/// Cells of the scans that a polygon does not count as a border: the flags before it cut, and those of which a border
/// leaves a part.
[[nodiscard]] Array<unsigned char> cells_of_scans(const CellView& cells, const Comparison& c);

/// Adds what the domain holds of slivers, which ascend.
void add_slivers(const CellView& cells, const std::vector<Index>& slivers, VolumeSums& sums);

/// Their shares of the domain and of its absolute volume; warns where they carry much of it.
void note_slivers(const VolumeSums& sums, Comparison& c);

/// All of these for T as a whole.
void describe_slivers(const CellView& cells, Comparison& c);

}  // namespace isopach::stages
