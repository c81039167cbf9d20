// SurfaceTree: closest points on a triangulated surface, and where lines meet it.
//
// A balanced tree of boxes over the triangles, cut at the median of their centres along the longest side. Its shape is
// a function of the number of triangles, so it is flat arrays without pointers and the same for any number of threads.
// The boxes of long thin triangles that are oblique to the axes lie over one another, and a query would look into all
// of them: where many do, nodes have a second box that is turned along their triangles [Gottschalk1996].
#pragma once
#include <array>
#include <cstdint>
#include <limits>

#include "isopach/distance/mesh.hpp"
#include "isopach/distance/turned_box.hpp"

namespace isopach {

/// The closest point to p of one triangle, and the squared distance to it. Degenerate triangles are segments or points.
struct ClosestPoint {
  Point3 point{0, 0, 0};
  double distance2 = std::numeric_limits<double>::infinity();
};
[[nodiscard]] ClosestPoint closest_on_triangle(const Point3& p, const std::array<Point3, 3>& corners);

/// Closest point of a surface: the face that holds it, the one of least index where several do.
struct Closest {
  ClosestPoint at;
  Index face = no_index;
};

/// Where the line p + t·direction meets a surface: the crossing nearest to p. face == no_index: nowhere.
struct Crossing {
  double t = std::numeric_limits<double>::infinity();
  Index face = no_index;
};

/// What queries had to look at.
struct SearchCounts {
  std::uint64_t boxes = 0, triangles = 0;
};

class SurfaceTree {
 public:
  /// `mesh` is kept by reference and has faces. Cost O(n log n), parallel.
  explicit SurfaceTree(const Mesh& mesh);

  /// Exact up to the rounding of the distance to one triangle. Expected O(log n) for points near the surface, of
  /// slivers too; O(n) where n needles cross one another in space. Oracle: tests/distance/surface_tree_test.cpp (every
  /// triangle, in long double).
  [[nodiscard]] Closest closest(const Point3& p) const;
  /// The same; adds to `counts`.
  [[nodiscard]] Closest closest(const Point3& p, SearchCounts& counts) const;

  /// No line slips through between two triangles that share an edge: the side of a line on which an edge lies is
  /// computed alike for both [Woop2013]. A line within a triangle's plane does not meet it.
  [[nodiscard]] Crossing cross(const Point3& p, const Point3& direction) const;

  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  [[nodiscard]] std::array<Point3, 3> corners(Index face) const { return mesh_.corners(face); }

 private:
  struct Range {
    std::size_t begin, end;
  };
  struct TurnedNode : TurnedBox {
    Index least = no_index;  ///< of its faces
  };
  [[nodiscard]] Range range(std::size_t node, int level) const;
  Box3 build(std::size_t node, int level, const Array<Point3>& centres);
  [[nodiscard]] Box3 leaf_box(const Range& r) const;
  template <bool turned>
  [[nodiscard]] std::size_t overlap() const;
  void turn_boxes();
  template <bool turned, class Count>
  [[nodiscard]] Closest search_closest(const Point3& p, Count& count) const;
  template <bool turned>
  [[nodiscard]] Crossing search_crossing(const Point3& p, const Point3& direction) const;

  const Mesh& mesh_;
  int levels_ = 0;  ///< of inner nodes; node i has children 2i+1 and 2i+2
  Array<Index> order_;
  Array<std::array<Point3, 3>> corners_;  ///< in `order_`
  Array<Box3> boxes_;
  Array<Index> turned_of_;  ///< by node: its box in `turned_`, or no_index; empty where boxes do not overlap
  std::vector<TurnedNode> turned_;
};

}  // namespace isopach
