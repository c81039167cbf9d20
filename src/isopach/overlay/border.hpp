// border: which part of its hull a scan really sampled (its footprint), and which cells of T lie in both footprints.
//
// The Delaunay triangulation fills the convex hull: it bridges bays, gaps and holes by triangles that stand for no
// measurement. Rule `trim`, on each scan alone:
//   1. The spacing at a node is the length of its third-shortest edge, or that of its neighbour with the second-longest
//      such edge if that is less. (The third, not the first: on scan lines the two shortest run along the line. The
//      neighbours: an outlier is alone with its long edges, a node of a sparse part is not.)
//   2. The stretch of a triangle is its longest edge over the largest spacing at its three nodes: no unit, near 1 to 2
//      where sampling is even, whatever the density.
//   3. Removed: triangles stretched more than `gap_stretch`, wherever they lie (holes, gaps); then, from those and from
//      the hull inwards, neighbour by neighbour, triangles stretched more than `rim_stretch`.
// Two limits, so that neither has to be tuned: inside a random sample some triangles pass the lower one, but they are
// islands that nothing reaches; none passes the upper one (tested on 3·10⁵ nodes).
// `SizeLimits` remove triangles by longest edge and by circumradius as well, under either rule.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/base/fixed_sum.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach {

inline constexpr double rim_stretch = 3.5;
inline constexpr double gap_stretch = 7;

/// What a scan supports of its triangulation: the real triangles not removed.
struct Footprint {
  Array<unsigned char> removed;       ///< one flag per real triangle; empty if none is
  double area = 0, removed_area = 0;  ///< of those kept and of those removed
  FixedSum kept_sum, removed_sum;     ///< the same, before they are rounded
  Array<double> third2;               ///< squared_third_edges of the triangulation, where the rule has asked for them

  [[nodiscard]] bool is_whole() const { return removed.empty(); }
  [[nodiscard]] bool keeps(Index triangle) const { return removed.empty() || removed[triangle] == 0; }
};

/// Limits of a triangle's size, in the unit of x and y; 0 for none.
struct SizeLimits {
  double edge = 0;          ///< longest edge
  double circumradius = 0;  ///< alpha: those within it are the alpha shape [Edelsbrunner1983]
};

/// Of a triangulation that is a part of a larger one, or holds a part of it (tiles/): which of its real triangles are
/// asked about. The others are kept, no border spreads through them, and they count in no area. Default: all of one
/// that is whole.
struct AskedTriangles {
  std::span<const unsigned char> flags = {};  ///< by real triangle; empty: all
  double area_bound = 0;                      ///< of the areas of all that are added up; 0: of the box of the nodes
  FixedSum kept_elsewhere = {};               ///< area of those that are not asked about, here or in other parts

  [[nodiscard]] bool holds(std::size_t triangle) const { return flags.empty() || flags[triangle] != 0; }
};

/// The footprint by the rule above. `trim` false: the hull. Triangles beyond `limits` are removed under either; the
/// circumradius is computed in doubles, within 1e-12 of itself even for slivers. A function of the set of
/// nodes: no order, number of threads, unit or density enters. Degenerate: without a real triangle nothing is removed.
/// Cost O(nodes) in parallel, then O(removed). Oracle: the definition, node by node, tests/overlay/border_test.cpp.
[[nodiscard]] Footprint footprint(const Triangulation& t, std::span<const Point2> xy, bool trim,
                                  const SizeLimits& limits, const Context& context, const AskedTriangles& asked = {});

/// By real triangle whether no look beyond its neighbourhood is needed to know that the footprint keeps it: it is
/// stretched by rim_stretch at most, if `trim`, and within `limits`. Right for triangles of which the nodes, and their
/// neighbours, have all of their triangles. Cost O(nodes) in parallel.
[[nodiscard]] Array<unsigned char> plainly_kept(const Triangulation& t, std::span<const Point2> xy, bool trim,
                                                const SizeLimits& limits, const Context& context);

/// By node of a triangulation: the square of its third-shortest edge, of the longest where there are fewer. Cost
/// O(nodes).
[[nodiscard]] Array<double> squared_third_edges(const Triangulation& t, std::span<const Point2> xy);

/// Where a point lies: away from the footprint, on the rim of a removed triangle, or inside.
enum class Side : unsigned char { outside, rim, inside };

/// Nodes of one scan against the footprint of one scan (the other or the same), so that cells can be judged when the
/// triangulation is no more.
struct Margin {
  struct Gap {
    Index node;
    std::array<Point2, 3> corners;  ///< of a removed triangle that the node is on, counter-clockwise
  };
  Array<Side> side;       ///< by node
  std::vector<Gap> gaps;  ///< those at rim nodes, ascending by node

  [[nodiscard]] bool covers(Index node) const { return side[node] != Side::outside; }
};
struct Margins {
  Margin own;    ///< the scan's nodes in its own footprint
  Margin other;  ///< the other scan's nodes in it
};
/// `other_in_t`: the other scan's nodes located in t. Cost O(nodes).
[[nodiscard]] Margins margins(const Footprint& f, const Triangulation& t, std::span<const Point2> xy,
                              const Locations& other_in_t, const Context& context);

/// Whether cells of T that the border of a footprint does not run through (overlay/rim.hpp) lie in it. A cell does if
/// its three corners are in it (rim included) and from no corner on the rim the way to its centroid starts in a removed
/// triangle. For a cell that is a triangle of the scan this is that triangle's own flag.
class FootprintOfNodes {
 public:
  /// `own` and `other`: ids in their scan of the nodes of T, or no_index.
  FootprintOfNodes(const Margins& m, std::span<const Index> own, std::span<const Index> other)
      : m_(m), own_(own), other_(other) {}
  [[nodiscard]] Side side(Index node) const {
    return own_[node] != no_index ? m_.own.side[own_[node]] : m_.other.side[other_[node]];
  }
  [[nodiscard]] bool holds(const std::array<Index, 3>& cell, std::span<const Point2> xy) const;

 private:
  [[nodiscard]] bool leads_out(Index node, const Point2& from, const Point2& b, const Point2& c) const;

  const Margins& m_;
  std::span<const Index> own_, other_;
};

}  // namespace isopach
