// Numbers that depend on coordinates alone: names of points and cells for draws that are the same in whatever order,
// and under whatever number, they come. Not random by themselves: feed them to a RandomStream.
#pragma once
#include <bit>
#include <cstdint>

#include "isopach/geom/vec.hpp"

namespace isopach {

[[nodiscard]] inline std::uint64_t hash_of(double x, std::uint64_t so_far = 0) {
  const std::uint64_t h = (so_far ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15;  // + 0.0: −0 is 0
  return h ^ (h >> 29);
}
[[nodiscard]] inline std::uint64_t hash_of(const Point2& p, std::uint64_t so_far = 0) {
  return hash_of(p.y, hash_of(p.x, so_far));
}

}  // namespace isopach
