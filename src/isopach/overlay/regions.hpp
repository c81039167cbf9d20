// regions: parts of the plane that cells are clipped to: polygons with holes, pixels of a mask.
//
// A region is a set of trapezoids (geom/trapezoids.hpp), a cell a convex polygon. Cutting a convex polygon along a line
// parts it in two that together are the whole, so nothing is lost or counted twice, and where regions overlap what is
// left of a cell after the first is cut by the next. Sides of the cells' nodes are exact orientations with the vertices
// of the regions; crossings are computed in doubles, for the integral alone.
//
// Over all regions lies one flat grid. A square knows the trapezoids that reach into it, and the regions that cover it
// as a whole: most cells lie in such squares and are not cut.
#pragma once
#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "isopach/base/types.hpp"
#include "isopach/geom/trapezoids.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// A corner of a cell with both surfaces at it.
struct Corner {
  double x, y, z1, z2;
  [[nodiscard]] double d() const { return z2 - z1; }
};

/// A convex polygon, counter-clockwise.
struct ConvexCell {
  static constexpr unsigned capacity = 24;
  unsigned corners = 0;
  std::array<Corner, capacity> at;

  ConvexCell() {}
  ConvexCell(const ConvexCell& other) { *this = other; }
  ConvexCell& operator=(const ConvexCell& other) {  // of the corners that there are alone
    corners = other.corners;
    std::copy_n(other.at.begin(), corners, at.begin());
    return *this;
  }
  ~ConvexCell() = default;

  void add(const Corner& c) { at[corners++] = c; }
  [[nodiscard]] Box2 box() const;
  [[nodiscard]] double area() const;
};

/// f(area, first, second, third) for the triangles of a fan from the first corner; those without area are left out.
template <class F>
void for_triangles(const ConvexCell& cell, F&& f) {
  const Corner& o = cell.at[0];
  for (unsigned k = 2; k < cell.corners; ++k) {
    const Corner &p = cell.at[k - 1], &q = cell.at[k];
    const double area = 0.5 * ((p.x - o.x) * (q.y - o.y) - (p.y - o.y) * (q.x - o.x));
    if (area > 0) f(area, o, p, q);
  }
}

/// The part where `height` of a corner, linear in x, y, z1 and z2, is not negative.
template <class Height>
[[nodiscard]] ConvexCell cut(const ConvexCell& cell, Height&& height) {
  ConvexCell kept;
  for (unsigned k = 0; k < cell.corners; ++k) {
    const Corner &p = cell.at[k], &q = cell.at[(k + 1) % cell.corners];
    const double hp = height(p), hq = height(q);
    if (hp >= 0) kept.add(p);
    if ((hp >= 0) == (hq >= 0)) continue;
    const double t = hp / (hp - hq);
    kept.add({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y), p.z1 + t * (q.z1 - p.z1), p.z2 + t * (q.z2 - p.z2)});
  }
  return kept;
}

/// A region as its edges: closed rings, even-odd.
struct Region {
  std::vector<Edge> edges;  ///< vertical ones too
  std::vector<Trapezoid> parts;
};

class Regions {
 public:
  /// `expected_cells`: about how many cells will be clipped; the grid has about half as many squares.
  Regions(std::vector<Region> regions, std::size_t expected_cells);

  [[nodiscard]] std::size_t size() const { return areas_.size(); }
  [[nodiscard]] bool empty() const { return areas_.empty(); }
  [[nodiscard]] double area(std::size_t region) const { return areas_[region]; }

  class Scratch;

  enum class Answer { none, all, some };
  /// How a cell lies in the union of the regions; `some`: `inside` and `outside` are its pieces (appended).
  /// Oracle: tests/overlay/regions_test.cpp (intersection areas of every pair by another library).
  Answer split(const ConvexCell& cell, Scratch& scratch, std::vector<ConvexCell>& inside,
               std::vector<ConvexCell>& outside) const;

  /// f(region, piece) for the parts of a cell in each of the regions, each region on its own, in their order. A region
  /// that covers the cell gets it as it is.
  template <class F>
  void for_pieces(const ConvexCell& cell, Scratch& scratch, F&& f) const;

 private:
  struct Part {
    Trapezoid shape;
    Box2 box;
    Index region;
  };
  struct Entry {
    Index part;
    bool covers;  // the region covers the whole square
  };
  struct Found {
    Index region, first, last;  // its parts in Scratch::parts
    bool covers;
  };

  /// The region that covers a box and is the only one near it, or no_index: no answer, but a quick one.
  [[nodiscard]] Index sole_cover(const Box2& box) const;
  void make_grid(const std::vector<Region>& regions, std::size_t expected_cells);
  [[nodiscard]] std::size_t column(double x) const;
  [[nodiscard]] std::size_t row(double y) const;
  void find(const Box2& box, Scratch& scratch) const;
  static bool cut_to(const Trapezoid& t, const ConvexCell& cell, ConvexCell& inside, std::vector<ConvexCell>* rest);
  Answer split_small(const ConvexCell& cell, Scratch& scratch, std::vector<ConvexCell>& inside,
                     std::vector<ConvexCell>& outside) const;

  std::vector<Part> parts_;
  std::vector<double> areas_;
  Box2 box_;
  std::size_t columns_ = 1, rows_ = 1;
  double width_ = 1, height_ = 1;  // of a square
  std::vector<std::size_t> first_;
  std::vector<Entry> entries_;
  std::vector<Index> sole_;  // by square: the region that covers it, if no other reaches into it
};

/// Buffers of one task.
class Regions::Scratch {
 private:
  friend class Regions;
  struct Hit {
    Index region, part;
    bool covers;
  };
  std::vector<Hit> hits;
  std::vector<Index> parts;
  std::vector<Found> found;
  std::vector<ConvexCell> left, next, rest;
};

template <class F>
void Regions::for_pieces(const ConvexCell& cell, Scratch& scratch, F&& f) const {
  const Box2 box = cell.box();
  if (const Index region = sole_cover(box); region != no_index) {
    f(region, cell);
    return;
  }
  find(box, scratch);
  ConvexCell piece;
  for (const Found& r : scratch.found) {
    if (r.covers) {
      f(r.region, cell);
      continue;
    }
    for (Index i = r.first; i < r.last; ++i)
      if (cut_to(parts_[scratch.parts[i]].shape, cell, piece, nullptr)) f(r.region, piece);
  }
}

}  // namespace isopach
