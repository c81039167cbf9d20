// bend: how far volumes whose d is linear on each cell of T may lie from those of two surfaces that bend in between.
#pragma once
#include "isopach/measure/measures.hpp"
#include "isopach/overlay/smooth.hpp"

namespace isopach {

/// Volumes that the cells leave out or put in, over the domain.
struct BendError {
  Volume correction;  ///< best estimate of the true volume less that of the cells
  double bound = 0;   ///< none of the four volumes is off by more, with a probability of 99 %
};

/// ∫ max(±d, 0) of d = s2 − s1 less that of the cells of T, where d is linear. A cell is cut into 16; d is asked for at
/// their corners, and its zero line cuts each in closed form. 16 against 4 tell what even they leave out.
/// Where T has more than `most_cells` cells in the domain, as many are drawn, one in each stretch of equal area (along
/// the cells' order, which is that of the plane), so that a cell counts by its area; the spread of neighbouring draws
/// gives the standard error ([Cochran1977]: selection with probability proportional to size,
/// collapsed strata). bound = |correction| + |left out| + 2.58 standard errors of both.
/// Exchanging the surfaces exchanges above and below to the last bit; the same bits for any number of threads.
/// Cost O(cells) to draw, and 12 heights of each surface for each cell drawn.
/// Oracle: tests/measure/bend_test.cpp (dense quadrature by brute force).
[[nodiscard]] BendError bend_error(const CellView& cells, const SmoothSurface& s1, const SmoothSurface& s2,
                                   const Context& context, std::size_t most_cells = 16384);

}  // namespace isopach
