// thin_surface: the cells of a comparison with fewer nodes, for a page that people look at, and how far it is off.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/compare/comparison.hpp"

namespace isopach {

/// Whole numbers that stand for values: value = low + step · number.
struct Quantised {
  double low = 0, step = 0;  ///< step 0: all are `low`
  Array<std::uint32_t> numbers;
  [[nodiscard]] double at(std::size_t i) const { return low + step * numbers[i]; }
};

/// A surface of the comparison's own nodes and of corners of its clipped cells, with both heights at them. Values are
/// quantised: what the errors are of is what a reader of the numbers gets.
struct ThinSurface {
  Quantised x, y, z, d;                   ///< frame coordinates; z: of A; d = B − A
  Quantised lod;                          ///< level of detection; no numbers where there is none
  Array<std::array<Index, 3>> triangles;  ///< counter-clockwise, in the order of their least nodes
  std::size_t nodes_of_cells = 0;         ///< what it was made from
  bool is_whole = false;                  ///< all of these nodes and the cells themselves: nothing is left out
  double area = 0, above = 0, below = 0;  ///< of the thinned surface: to be set beside those of the comparison
  /// Largest and root of mean squared difference of d, and of z, at the nodes of the comparison in its domain.
  double d_error = 0, d_rms = 0, z_error = 0;
  [[nodiscard]] std::size_t nodes() const { return x.numbers.size(); }
};

/// Chooses at most `most` nodes (at least 100): those where the objects among the changes are largest, those of the
/// least and the largest d in squares of a grid, then, in rounds, those at which the surface so far is worst; their
/// triangulation is Delaunay's. Comparisons of no more nodes keep them all, with their cells. A triangle belongs to the
/// domain if its centroid does. The same for any number of threads. Cost: a triangulation of `most` nodes and a
/// localisation of all a round. Oracle: tests/report/thin_test.cpp (errors by trying every triangle).
[[nodiscard]] ThinSurface thin_surface(const Comparison& c, std::size_t most, const Context& context);

}  // namespace isopach
