// find_wrinkles: the valleys of a surface that are long and narrow, each with its line, depth and length.
//
// A valley is a connected set of nodes that lie `depth` or more under the level (joined by sides of kept triangles).
// Its two ends are the nodes farthest apart along sides of triangles inside it; its line runs through the middle of
// what lies at like distance from one end. A wrinkle is a valley whose line is `length` or longer and three times as
// long as the valley is wide on average (area in the plane ÷ length); other valleys are pits. Two kinds are left out
// and counted, because their depth is no depth of a wrinkle: those along the rim of the kept triangles (or of a fold
// that was taken out of them), of whose nodes half or more lie on it, and those `steepest` times as deep on average as
// they are wide, which are steps or narrow folds of which a height field shows no walls.
#pragma once
#include <span>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

inline constexpr double steepest = 2;

struct WrinkleOptions {
  double depth = 0;   ///< under the level, unit of heights; 0: 3 × NMAD of the relief, see Wrinkles::depth
  double length = 0;  ///< along the surface, unit of x and y; 0: 10 × the spacing of the nodes, see Wrinkles::length
};

struct Wrinkle {
  double depth = 0;       ///< of its deepest node
  double mean_depth = 0;  ///< mean of the deepest nodes along the line, by length
  double length = 0;      ///< of the line, along the surface in space
  double width = 0;       ///< area ÷ length
  double area = 0;        ///< of the valley, in the plane: the nodes' shares
  double volume = 0;      ///< between the valley and the level
  Index deepest = no_index;
  Array<Point2> line;        ///< in the plane, from end to end
  Array<Index> nodes;        ///< of the valley
  Array<Index> step;         ///< of each node: which stretch of the line it belongs to
  std::vector<double> part;  ///< length of each stretch
};

struct Wrinkles {
  double depth = 0, length = 0;       ///< limits in force
  double spacing = 0;                 ///< √(area ÷ nodes)
  std::vector<Wrinkle> all;           ///< deepest first
  std::size_t pits = 0;               ///< valleys that are no wrinkles, of three nodes or more
  std::size_t at_rim = 0, steep = 0;  ///< long enough for wrinkles, but left out
};

/// 1.4826 × the median of |relief − its median| at the nodes with a share of the area: the spread without the wrinkles
/// themselves. 0 without such nodes.
[[nodiscard]] double nmad(std::span<const double> relief, std::span<const double> area);

/// `relief`: height over the level at each node; `z`: the surface itself, for lengths; `kept`: one flag per real
/// triangle (empty: all); `area`: each node's share of the kept triangles, 0 for nodes of none. The same for any number
/// of threads. Cost: O(n log n). Errors: UsageError for limits that are negative or not finite. Oracle: grooves of
/// known depth and length, and the definition by exhaustive search, tests/measure/wrinkles_test.cpp.
[[nodiscard]] Wrinkles find_wrinkles(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                                     std::span<const double> relief, std::span<const unsigned char> kept,
                                     std::span<const double> area, const WrinkleOptions& options,
                                     const Context& context);

/// Depth along the line of a wrinkle in another relief at the same nodes (NaN where there is none): the deepest and the
/// mean, as for the wrinkle itself; of what lies over the level, 0. NaN where a relief is missing all along.
struct LineDepth {
  double depth, mean_depth;
};
[[nodiscard]] LineDepth depth_along(const Wrinkle& wrinkle, std::span<const double> relief_at_nodes);

}  // namespace isopach
