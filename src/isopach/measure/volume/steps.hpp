// for_cells in steps between which a run can be stopped: one item of an overlay may have thousands of cells.
#pragma once
#include <algorithm>

#include "isopach/base/context.hpp"
#include "isopach/measure/parted_cells.hpp"

namespace isopach {

/// for_cells over a block, in the same order. Throws Interrupted once the user asked to stop.
template <class Source, class F>
void for_cells_in_steps(const Source& cells, std::size_t begin, std::size_t end, const Context& context, F&& f) {
  constexpr std::size_t step = 64;
  for_views(cells, begin, end, [&](const auto& view, std::size_t first, std::size_t last) {
    for (std::size_t from = first; from < last; from += step) {
      context.check();
      for_cells(view, from, std::min(last, from + step), f);
    }
  });
}

}  // namespace isopach
