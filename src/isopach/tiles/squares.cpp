#include "isopach/tiles/squares.hpp"

#include <algorithm>

namespace isopach {

std::vector<TileSquare> joined_squares(std::vector<TileSquare> squares, std::uint64_t most) {
  std::erase_if(squares, [](const TileSquare& s) { return s.all() == 0; });
  std::sort(squares.begin(), squares.end(),
            [](const TileSquare& a, const TileSquare& b) { return a.first_key() < b.first_key(); });
  // Depth first along the curve: the squares behind `from` that lie in one larger square are the last ones.
  int deepest = 0;
  for (const TileSquare& s : squares) deepest = std::max(deepest, s.level);
  for (int level = deepest; level > 0; --level) {
    std::vector<TileSquare> joined;
    for (std::size_t i = 0; i < squares.size();) {
      const std::uint64_t parent = squares[i].first_key() >> (64 - 2 * (level - 1)) % 64;
      const auto in_parent = [&](const TileSquare& s) {
        return level == 1 || s.first_key() >> (64 - 2 * (level - 1)) == parent;
      };
      std::size_t end = i;
      TileSquare all{level - 1, level == 1 ? 0 : parent, {0, 0}};
      bool is_whole = squares[i].level >= level;
      for (; end < squares.size() && in_parent(squares[end]); ++end) {
        all.points[0] += squares[end].points[0], all.points[1] += squares[end].points[1];
        is_whole = is_whole && squares[end].level == level;
      }
      if (is_whole && all.all() <= most)
        joined.push_back(all);
      else
        joined.insert(joined.end(), squares.begin() + static_cast<std::ptrdiff_t>(i),
                      squares.begin() + static_cast<std::ptrdiff_t>(end));
      i = end;
    }
    squares = std::move(joined);
  }
  return squares;
}

}  // namespace isopach
