// Point sets of the benchmark: each a function of (n, seed) alone, in the order in which it would come from a file.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach::bench {

using Points = Array<Point2>;

[[nodiscard]] Points uniform(std::size_t n, std::uint64_t seed);     ///< unit square, random order
[[nodiscard]] Points scan_lines(std::size_t n, std::uint64_t seed);  ///< 1000 × 1000, scan order, 0.01 steps, 1 % twice
[[nodiscard]] Points grid(std::size_t n, std::uint64_t seed);        ///< integers, row order; whole rows
[[nodiscard]] Points clustered(std::size_t n, std::uint64_t seed);   ///< 100 bells, sigma 1e-4 to 3e-2, random order
[[nodiscard]] Points rotated_grid(std::size_t n, std::uint64_t seed);  ///< grid turned by 30 degrees
[[nodiscard]] Points utm(std::size_t n, std::uint64_t seed);           ///< 1 km² at (6e5, 5e6), millimetres
[[nodiscard]] Points strip(std::size_t n, std::uint64_t seed);         ///< 1000 × 1
[[nodiscard]] Points outlier(std::size_t n, std::uint64_t seed);       ///< uniform, and one point 1e6 extents away
[[nodiscard]] Points sorted_by_x(std::size_t n, std::uint64_t seed);   ///< uniform, ascending x
[[nodiscard]] Points few_lines(std::size_t n, std::uint64_t seed);     ///< on ten straight lines
[[nodiscard]] Points doubled(std::size_t n, std::uint64_t seed);       ///< uniform, 1 % of the points twice

struct Family {
  std::string name;
  Points (*make)(std::size_t n, std::uint64_t seed);
};
[[nodiscard]] const std::vector<Family>& main_families();   ///< those with a target of their own
[[nodiscard]] const std::vector<Family>& cliff_families();  ///< those that must not be much slower than uniform

/// Heights of a hilly surface over (0, 1)²; epoch 2 lies partly above and partly below epoch 1.
[[nodiscard]] Cloud surface_scan(std::size_t n, std::uint64_t seed, int epoch);

}  // namespace isopach::bench
