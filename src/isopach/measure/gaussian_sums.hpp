// GaussianSums: weighted moments about every node under a Gaussian kernel, by boxes. Internal to gaussian_filter.cpp.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/base/types.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// With (u, v) = (p_j − p_i) / width, g = exp(−u² − v²) and weights w: sums over j of w g times
/// 1, u, v, u², uv, v², then of w z g times 1, u, v. Degree 0 fills the first of each only.
struct GaussianMoments {
  double a00 = 0, a10 = 0, a01 = 0, a20 = 0, a11 = 0, a02 = 0, z00 = 0, z10 = 0, z01 = 0;
};

/// Nodes sorted into square boxes one kernel width wide; those `reach` boxes away are left out (exp(−25)).
class GaussianBoxes {
 public:
  static constexpr std::int64_t reach = 5;

  /// Nodes of weight 0 take part as places to evaluate at only if `weight` > 0 there: others are left out.
  GaussianBoxes(std::span<const Point2> xy, std::span<const double> weight, double width);

  struct Box {
    std::int64_t row, column;
    std::size_t begin, end;  ///< into nodes
  };
  std::vector<Box> boxes;  ///< occupied ones, by row, then column
  Array<Index> nodes;      ///< by box; in the order of the input within it
  Array<Point2> at;        ///< of nodes[k]: place in its box, from −1 to 1 each way
  std::int64_t rows = 0, columns = 0;

  /// Occupied boxes of a row with columns in [first, last].
  [[nodiscard]] std::span<const Box> in_row(std::int64_t row, std::int64_t first, std::int64_t last) const;
};

enum class GaussianMethod { automatic, direct, boxes };

/// Moments at every node of `boxes`, in the order of boxes.nodes. `weight` and `weighted_z` are by input id.
[[nodiscard]] Array<GaussianMoments> gaussian_moments(const GaussianBoxes& boxes, std::span<const double> weight,
                                                      std::span<const double> weighted_z, unsigned degree,
                                                      GaussianMethod method, const Context& context);

}  // namespace isopach
