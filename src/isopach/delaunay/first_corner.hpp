// The corner that a triangle is written from where an answer must not depend on how its triangulation was made.
#pragma once
#include <array>

#include "isopach/base/types.hpp"

namespace isopach {

/// The same corners in the same sense of rotation, the one with the least index first: the first on the curve. What
/// rounds is then a function of the nodes alone, in whichever slot a triangle lies and whichever corner it begins with.
[[nodiscard]] inline std::array<Index, 3> from_first_corner(const std::array<Index, 3>& v) {
  const std::size_t k = v[1] < v[0] ? (v[2] < v[1] ? 2 : 1) : (v[2] < v[0] ? 2 : 0);
  return {v[k], v[k == 2 ? 0 : k + 1], v[k == 0 ? 2 : k - 1]};
}

}  // namespace isopach
