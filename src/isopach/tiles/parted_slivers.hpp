// Border slivers (compare/slivers.hpp) of cells in parts. Internal to tiles/.
#pragma once
#include <array>
#include <type_traits>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/measure/parted_cells.hpp"

namespace isopach {

/// What is known of the cells that are in no part.
struct RestOfCells {
  const Array<unsigned char>& counted;  ///< by triangle: whether it is a cell of T
  std::vector<std::size_t> number;      ///< by node: on the curve, among all nodes of T
};

/// f(view, cell, numbers of its corners) for the whole cells in a range: those of parts, and triangles of the rest.
template <class F>
void for_numbered(const PartedCells& cells, const RestOfCells& rest, std::size_t begin, std::size_t end, F&& f) {
  cells.visit(begin, end, [&](const auto& view, std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i)
      if constexpr (std::is_same_v<std::decay_t<decltype(view)>, CellPart>) {
        const std::array<Index, 3>& v = view.triangles[i];
        f(view, i, std::array<std::size_t, 3>{view.first_node + v[0], view.first_node + v[1], view.first_node + v[2]});
      } else {
        const std::array<Index, 3> v = view.corners(i);
        f(view, i, std::array<std::size_t, 3>{rest.number[v[0]], rest.number[v[1]], rest.number[v[2]]});
      }
  });
}

/// Sets what stages::describe_slivers does of T as a whole. Cells with long edges are kept by their nodes for it, 40
/// bytes each. Oracle: that function.
void describe_slivers(const PartedCells& cells, const RestOfCells& rest, Comparison& c, const Context& context);

}  // namespace isopach
