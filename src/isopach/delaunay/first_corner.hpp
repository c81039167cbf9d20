// The corner that a triangle is written from where an answer must not depend on how its triangulation was made.
#pragma once
#include <array>

#include "isopach/base/types.hpp"

namespace isopach {

/// The same corners in the same sense of rotation, the one with the least index first: the first on the curve. What
/// rounds is then a function of the nodes alone, in whichever slot a triangle lies and whichever corner it begins with.
/// Without branches: which corner it is, nobody can predict.
[[nodiscard]] inline std::array<Index, 3> from_first_corner(const std::array<Index, 3>& v) {
  const std::array<Index, 5> round{v[0], v[1], v[2], v[0], v[1]};
  const auto second = static_cast<std::size_t>(v[1] < v[0]);
  const auto third = static_cast<std::size_t>(v[2] < v[0]) & static_cast<std::size_t>(v[2] < v[1]);
  const std::size_t k = 2 * third | (second & (third ^ 1));
  return {round[k], round[k + 1], round[k + 2]};
}

}  // namespace isopach
