// Named point sets, from harmless to hostile. Each is a function of (n, seed) alone; some return fewer than n points
// (grids: whole rows; circles: as many integer points as there are) and two of them hold duplicates on purpose.
#pragma once
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "isopach/geom/vec.hpp"

namespace isopach::test {

using Points = std::vector<Point2>;

Points uniform(std::size_t n, std::uint64_t seed);          ///< in the unit square
Points sorted_by_x(std::size_t n, std::uint64_t seed);      ///< the same, in ascending x
Points grid(std::size_t n, std::uint64_t seed);             ///< integers in row order: every cell is a tie
Points rotated_grid(std::size_t n, std::uint64_t seed);     ///< grid turned by 30°: every cell a tie or nearly
Points near_degenerate(std::size_t n, std::uint64_t seed);  ///< grid, each coordinate moved by −1, 0 or 1 ulp
Points horizontal(std::size_t n, std::uint64_t seed);       ///< collinear, one y
Points vertical(std::size_t n, std::uint64_t seed);         ///< collinear, one x
Points diagonal(std::size_t n, std::uint64_t seed);         ///< collinear exactly: integers on y = 3x
Points nearly_diagonal(std::size_t n, std::uint64_t seed);  ///< y = x/3 rounded: collinear but for the last bit
Points few_lines(std::size_t n, std::uint64_t seed);        ///< integers on 3 horizontal lines and one vertical
Points cocircular(std::size_t n, std::uint64_t seed);       ///< integer points on one circle: exact ties
Points concentric(std::size_t n, std::uint64_t seed);       ///< integer points on many circles round the origin
Points clustered(std::size_t n, std::uint64_t seed);        ///< 10 bells of very different width
Points scan_lines(std::size_t n, std::uint64_t seed);       ///< zigzag lines, rounded to 0.01, 1 % duplicates
Points far_outlier(std::size_t n, std::uint64_t seed);      ///< unit square and one point 10⁶ away
Points utm(std::size_t n, std::uint64_t seed);              ///< 1 km² at (6e5, 5e6), millimetres
Points thin_strip(std::size_t n, std::uint64_t seed);       ///< 1000 × 1
Points huge(std::size_t n, std::uint64_t seed);             ///< in a square of side 10⁶
Points tiny(std::size_t n, std::uint64_t seed);             ///< in a square of side 10⁻⁶
Points coarse_lattice(std::size_t n, std::uint64_t seed);   ///< random integers: duplicates, ties, collinear runs

struct Family {
  std::string name;
  Points (*make)(std::size_t n, std::uint64_t seed);
  bool collinear = false;  ///< all points of it lie on one line, exactly
};
inline void PrintTo(const Family& family, std::ostream* out) { *out << family.name; }

/// All of the above.
[[nodiscard]] const std::vector<Family>& families();

/// Sorted lexicographically, equal points once.
[[nodiscard]] Points distinct(Points points);

}  // namespace isopach::test
