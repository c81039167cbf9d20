// Inside currents.cpp and currents_gradient.cpp: how a pair of cubes is summed, what that costs and what it misses.
#pragma once
#include "isopach/measure/currents/currents_cubes.hpp"

namespace isopach::currents_parts {

/// How a pair is summed: between the nodes of both grids at once, axis by axis, or place by place with a grid in place
/// of the sources where it has fewer.
struct Plan {
  bool by_grids = false;
  bool grid_from = false, grid_to = false;
};
/// `sources_from`, `sources_to`: how many of the sources take part.
[[nodiscard]] Plan plan(const Cube& from, std::size_t sources_from, const Cube& to, std::size_t sources_to);

/// The kernel of a pair of cubes at its largest, and the most that a plan can miss of it.
struct PairError {
  double largest, missed;
};
[[nodiscard]] PairError pair_error(const Cube& from, const Cube& to, const Plan& plan, const Vector& offset);

/// exp_minus of the differences along one side between two grids, and its derivative by the place of `to`.
struct AxisMatrix {
  std::size_t from = 0, to = 0;
  std::vector<double> value, slope;  ///< [a · to + b]
};
[[nodiscard]] std::array<AxisMatrix, 3> axis_matrices(const Cube& from, const Cube& to, const Vector& offset,
                                                      bool with_slopes);

/// out = Σ over the nodes of one grid of in · m₀ m₁ m₂, at the nodes of another: x is the fastest axis. `room`:
/// scratch.
struct TensorRoom {
  std::vector<double> first, second;
};
void contract(const double* in, const std::array<AxisMatrix, 3>& axes,
              const std::array<const std::vector<double>*, 3>& matrices, std::vector<double>& out, TensorRoom& room);

/// kernel[i] = exp(−|to_i − at|²) for the places of a range; `at` in the coordinates of `to`.
void kernels(const Range& to, const Vector& at, double* kernel);

}  // namespace isopach::currents_parts
