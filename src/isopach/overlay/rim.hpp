// rim: where the borders of footprints run through cells of T, and what they cut these into.
//
// A border is made of sides of T1 or T2, so its corners are nodes of T: none lies inside a cell. What runs through a
// cell runs straight across the whole of it, and cuts it into convex pieces. On a border the surface of its scan is
// known: it is linear between the two nodes, so no height from beyond the border enters.
#pragma once
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/overlay/border.hpp"
#include "isopach/overlay/regions.hpp"

namespace isopach {

/// What of a scan a border bounds, as bits: its hull, its footprint, its footprint without folds.
enum Extent : unsigned char { in_hull = 1, in_footprint = 2, in_single = 4 };
inline constexpr unsigned extents = 3;  ///< bits of a scan; those of B are shifted by as many

/// A side of a scan's triangulation with one of its extents on the left and not on the right.
struct BorderSide {
  Index from, to;    ///< nodes
  unsigned char of;  ///< Extent bits
};

/// The borders of one scan. `single`: the footprint without folds; null: the same as `f`. Cost O(triangles), in
/// parallel; O(hull) where nothing is removed.
[[nodiscard]] std::vector<BorderSide> border_sides(const Triangulation& t, const Footprint& f, const Footprint* single);

/// A border side that runs through a cell of T.
struct RimCrossing {
  Index cell, side;  ///< side: index into the list that was given
};

/// Where sides run through the inside of cells of T, by cell and then by side. Sides are of nodes of T. A side that is
/// a side of T crosses nothing. Walks by exact orientations; cost O(nodes) to find the starts, then O(cells crossed).
/// Oracle: all sides against all cells, tests/overlay/rim_test.cpp.
[[nodiscard]] std::vector<RimCrossing> crossings(const Triangulation& t, std::span<const Point2> xy,
                                                 std::span<const BorderSide> sides, const Context& context);

/// How far along p→q a place on that line lies: 0 at p, 1 at q; by the longer of both coordinates.
[[nodiscard]] inline double share_along(const Point2& p, const Point2& q, const Corner& at) {
  const bool by_x = std::fabs(q.x - p.x) >= std::fabs(q.y - p.y);
  return by_x ? (at.x - p.x) / (q.x - p.x) : (at.y - p.y) / (q.y - p.y);
}

/// A corner with, by scan, the ends of the side of its border that it lies on; no_index where it lies on none.
struct RimCorner : Corner {
  std::array<std::array<Index, 2>, 2> border{{{no_index, no_index}, {no_index, no_index}}};
  unsigned char sides = 0;  ///< bits of the sides of the cell that it lies on
};

/// A convex polygon in a cell of T, counter-clockwise, with both surfaces at its corners.
struct RimPiece {
  std::vector<RimCorner> corners;
  unsigned char in = 0;  ///< Extent bits of A and, shifted, of B that it lies in
};

/// A cell of T that borders run through.
struct RimCell {
  std::array<Index, 3> nodes;
  std::span<const RimCrossing> across;
  std::array<unsigned char, 3> outside{};  ///< extents that each corner is not in, nor on the border of
  unsigned char in = 0;                    ///< extents that the cell lies in as a whole
};

/// Cuts cells of T into the pieces that borders leave of them.
class RimCutter {
 public:
  /// `sides`: of both scans, as they were given to crossings().
  RimCutter(std::span<const Point2> xy, std::span<const double> z1, std::span<const double> z2,
            std::span<const BorderSide> sides)
      : xy_(xy), z_{z1, z2}, sides_(sides) {}

  /// Together the cell. The first corner of each is its least, by x and then y, so that pieces do not hang on how T is
  /// numbered. Heights: on a border that of its side; at a node of the cell that of the node; elsewhere on a side of
  /// the cell between the nearest of these two that are known. A hull holds what is left of all its sides; of a
  /// footprint two pieces on either side of one border are one inside, one outside, from a corner that is outside for
  /// certain, or else from beside one of the borders.
  const std::vector<RimPiece>& operator()(const RimCell& cell);

 private:
  void cut_along(const BorderSide& side, const RimCell& cell);
  void cut(const RimPiece& piece, const BorderSide& side, const RimCell& cell);
  [[nodiscard]] double height_over(const BorderSide& side, const Corner& c, const RimCell& cell) const;
  [[nodiscard]] RimCorner on_border(RimCorner c, const BorderSide& side) const;
  void settle_heights(const RimCell& cell);
  void settle_heights(const RimCell& cell, std::size_t k, std::size_t scan);
  [[nodiscard]] Point2 middle_across(const BorderSide& side, const RimCell& cell) const;
  [[nodiscard]] bool is_in(const Point2& p, unsigned char extent, const RimCell& cell) const;

  std::span<const Point2> xy_;
  std::array<std::span<const double>, 2> z_;
  std::span<const BorderSide> sides_;
  std::vector<RimPiece> pieces_, next_;
};

}  // namespace isopach
