// The middle one of values, and what a median of absolute deviations says of their standard deviation.
#pragma once
#include <algorithm>
#include <cstddef>
#include <iterator>

namespace isopach {

/// Standard deviations of a normal distribution in its median absolute deviation.
inline constexpr double mad_to_sigma = 1.4826;

/// The element that as many are less than as greater (of an even number: the upper one), 0 of none; reorders `values`.
/// O(n). Test: Median.* in tests/base/median_test.cpp.
template <class Values>
[[nodiscard]] double median(Values& values) {
  if (values.empty()) return 0;
  const auto middle = std::next(values.begin(), static_cast<std::ptrdiff_t>(values.size() / 2));
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace isopach
