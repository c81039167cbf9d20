// Averaging away the random part of a difference where it hides the rest, and nowhere else.
#pragma once
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"

namespace isopach {

/// The values of nodes in curve order without what `variance` and `sample` say is random, piecewise constant where it
/// is. Wavelet shrinkage [Donoho1994] with the Haar basis of a binary tree over the nodes: a stretch of the
/// curve is a compact piece of the plane, so the difference of the means of two sibling stretches is kept if it is
/// above √(2 ln n) times its standard error, and set to zero if not. The standard error is that of independent values
/// of the given variances, times a factor for each level that makes it right for `sample`, one draw of the random part
/// (of which neighbours may be correlated). Values of weight 0 take no part. Without variance the values themselves.
/// Changing all signs changes all signs. Cost O(n). Test: tests/measure/shrinkage_test.cpp.
[[nodiscard]] Array<double> shrink(std::span<const double> value, std::span<const double> weight,
                                   std::span<const double> variance, std::span<const double> sample,
                                   const Context& context);

}  // namespace isopach
