// overlay: the planar overlay of T1 and T2, cell by cell (docs/method/overlay.md). A cell is the
// intersection of a triangle of T1 with a triangle of T2: a convex polygon of at most six corners, on which both
// surfaces are linear.
//
// Words. The mesh with more triangles is the outer one: its triangles are gone through, in order and in parallel; the
// other is the inner one, in which a flood finds the triangles that meet an outer triangle. A corner of a cell is a
// node of either mesh or the crossing of an edge of one with an edge of the other.
//
// Every decision is the sign of an orientation of three *nodes*; no constructed point enters a predicate. No sign is
// ever 0: the inner mesh is shifted by (ε, ε²), ε infinitesimal, so shared nodes, nodes on edges and collinear edges
// are told apart by comparing coordinates (symbolic perturbation after [Edelsbrunner1990]; a translation keeps
// the mesh as it is). The limit ε → 0 changes no integral; it only adds cells without area where the meshes touch.
// Coordinates of crossings are computed in doubles, relative to the outer triangle, for the integral alone.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/overlay/location.hpp"

namespace isopach {

/// One of the two surfaces. The arrays belong to the caller and stay alive while the overlay is used.
struct OverlayMesh {
  const Triangulation& t;
  std::span<const Point2> xy;
  std::span<const double> z;
  const Locations& in_other;                 ///< of each node in the other triangulation
  std::span<const double> other_z;           ///< height of the other surface at each node (see interpolate)
  std::span<const unsigned char> kept = {};  ///< one per real triangle: part of the domain; empty = all
};

/// What a corner of a cell is: an outer node (node, no_index), an inner node (no_index, node), or the crossing of a
/// side 0, 1, 2 of the outer triangle with a half-edge of the inner mesh.
struct OverlayCorner {
  Index outer, inner;
};

struct OverlayCell {
  Index t1, t2;      ///< the two triangles
  unsigned corners;  ///< 3 to 6, counter-clockwise
  unsigned sides;    ///< bit i: side i of the outer triangle is, in part, a side of the cell
  Point2 origin;     ///< x, y are relative to it: a corner of the outer triangle
  std::array<double, 6> x, y;
  std::array<double, 6> z1, z2;  ///< both surfaces at the corners
  std::array<OverlayCorner, 6> of;
  std::uint8_t crossings;  ///< bit i: corner i is a crossing

  [[nodiscard]] double d(unsigned corner) const { return z2[corner] - z1[corner]; }
};

/// The overlay as one mesh in which cells share their corners: every cell is fanned into triangles.
struct OverlaySurface {
  Array<Point2> xy;                       ///< nodes of both meshes and crossings, those of a cell only
  Array<double> z1, z2;                   ///< both surfaces there
  Array<std::array<Index, 3>> triangles;  ///< counter-clockwise
};

class Overlay {
 public:
  /// Finds where every outer triangle meets the inner mesh. Cost O(nodes), plus the cells at the rim of the inner hull.
  /// Only where no node of the outer mesh lies in the inner hull: O(h1 h2) at worst for hulls of h1, h2 edges that
  /// reach into the box of the other hull.
  Overlay(const OverlayMesh& m1, const OverlayMesh& m2, const Context& context);

  /// Work is handed out by item: [0, items()), each an outer triangle and the cells in it.
  [[nodiscard]] std::size_t items() const { return outer_.t.real + late_.size(); }

  /// A number that |z2 − z1| exceeds nowhere, from the ranges of both surfaces' heights. Cost O(nodes).
  [[nodiscard]] double bound_of_difference() const;
  /// Of the nodes of both meshes. Cost O(nodes).
  [[nodiscard]] Box2 box() const;
  /// Both ends of the side of an item's outer triangle that leaves its first corner on the curve.
  [[nodiscard]] std::array<Point2, 2> first_side(std::size_t item) const;

  /// About how many cells there are, from those of some hundred items spread evenly: exact for few items, else within
  /// some per cent where it is large. Long triangles that cross one another have up to all pairs. Cost: that of the
  /// cells counted, at most some millions.
  [[nodiscard]] double estimated_cells(const Context& context) const;

  class Scratch;

  /// The cells of an item, in an order that depends on the meshes alone; valid until `scratch` is used again. Cells in
  /// triangles that are not kept are left out. Cost O(cells). All cells of all items are the overlay: each once.
  /// Exchanging the meshes gives the same cells with z1 and z2 exchanged, to the last bit. Oracle:
  /// tests/overlay/overlay_test.cpp (all pairs of triangles clipped).
  [[nodiscard]] std::span<const OverlayCell> cells(std::size_t item, Scratch& scratch) const;

  /// All cells as one mesh, to be drawn or written; cells without area are left out. Cost and memory O(cells): about
  /// 1.2 kB a node of one mesh. Throws InputError if it has more corners than indices. Oracle:
  /// tests/overlay/overlay_surface_test.cpp.
  [[nodiscard]] OverlaySurface surface(const Context& context) const;

 private:
  struct Start {
    Index outer, inner;  // triangles with a common interior
  };
  // The inner triangle that a flood starts from, no_index: none; whether the two have a common area for certain, also
  // without the shift.
  struct Entry {
    Index inner;
    bool covers;
  };
  class Flood;

  [[nodiscard]] Index outer_of(std::size_t item) const {
    return item < outer_.t.real ? static_cast<Index>(item) : late_[item - outer_.t.real].outer;
  }
  [[nodiscard]] bool has_node_inside(Index outer_triangle) const;
  [[nodiscard]] Index start_of(Index outer_triangle) const;
  [[nodiscard]] Entry entry(std::size_t item) const;
  [[nodiscard]] Entry entry(Index outer_triangle, Index start) const;
  [[nodiscard]] Index first_in_corner(Index outer_triangle, unsigned corner) const;
  [[nodiscard]] Index beside_edge(Index outer_triangle, unsigned corner, HalfEdge edge) const;
  void find_hubs();
  void find_late(const Context& context);
  void spread(const Start& from, Scratch& scratch, std::vector<Start>& next) const;
  [[nodiscard]] std::vector<Start> at_the_rim(const Context& context) const;
  [[nodiscard]] std::vector<Start> without_nodes_inside() const;

  bool exchanged_;  // the outer mesh is mesh 2
  OverlayMesh outer_, inner_;
  Array<Index> start_;       // per outer node the inner triangle it lies in, or no_index
  std::vector<Start> late_;  // outer triangles without a node in the inner hull
  // Per inner node its triangles' number and one of them; empty where no hub lies on a node of the outer mesh.
  Array<Index> degree_, at_node_;
};

/// Buffers for one block of items.
class Overlay::Scratch {
 public:
  Scratch();
  ~Scratch();

 private:
  friend class Overlay;
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace isopach
