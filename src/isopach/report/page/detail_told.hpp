// Whether people are told ρ_dV. It stands in result.json always.
#pragma once
#include "isopach/compare/comparison.hpp"

namespace isopach {

/// From this ratio of the numbers of points over the common area on there is detail that the finer scan alone can hold:
/// its points are a tenth closer.
inline constexpr double different_densities = 1.25;

/// Where it was asked for, or where the scans are of different density over what they share. Between equally dense
/// scans there is no detail that one alone can hold, and ρ_dV is ρ with some of the noise averaged out. False where
/// there is no ρ_dV. Test: tests/report/detail_told_test.cpp.
[[nodiscard]] bool tells_detail(const Comparison& c);

}  // namespace isopach
