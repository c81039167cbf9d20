// budget: sums by region, all regions in one pass over the cells.
#pragma once
#include <vector>

#include "isopach/measure/source.hpp"

namespace isopach {

/// Of the part of the domain in one region.
struct RegionSums {
  double area = 0;
  Volume volume;
};

/// One row a region, in their order; regions may overlap, each counts on its own. Cells that a region covers count as
/// they are, the others by their pieces. Exact sums (base/fixed_sum.hpp). Cost O(cells + pieces). Oracle:
/// tests/measure/source_test.cpp (every triangle clipped with every polygon by another library).
[[nodiscard]] std::vector<RegionSums> budget(const CellView& cells, const Regions& regions, const Context& context);
[[nodiscard]] std::vector<RegionSums> budget(const OverlayCells& cells, const Regions& regions, const Context& context);

}  // namespace isopach
