// Squares of the curve's quadtree that hold few enough points each: the tiles.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace isopach {

/// All points of which keys begin with `prefix`, of 2 · level bits.
struct TileSquare {
  int level = 0;
  std::uint64_t prefix = 0;
  std::array<std::uint64_t, 2> points{0, 0};  ///< of A, of B

  [[nodiscard]] std::uint64_t all() const { return points[0] + points[1]; }
  /// Where it begins on the curve.
  [[nodiscard]] std::uint64_t first_key() const { return level == 0 ? 0 : prefix << (64 - 2 * level); }
};

/// Squares of different levels that share no point, in any order, joined four by four as long as a square holds at most
/// `most` points; those without points are left out. In the order of the curve. Cost O(n log n).
[[nodiscard]] std::vector<TileSquare> joined_squares(std::vector<TileSquare> squares, std::uint64_t most);

}  // namespace isopach
