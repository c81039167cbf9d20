// folds: where a scan is no height field, because a layer of it lies under another: overhangs, undersides, vegetation.
//
// The Delaunay triangulation of such a place joins points of both layers by spikes that stand for no surface. Rule, on
// each scan alone and on what its footprint keeps:
//   1. At a node, h is its spacing (its third-shortest edge in the plane) and r how much the heights of neighbours on
//      one layer differ (the second-smallest step to a neighbour; the median of these over the node and its
//      neighbours). An edge is torn if its ends lie farther apart in height than 2 h and 4 r of either end: steeper
//      than the spacing can carry, and more than the layer itself does from node to node.
//   2. A node is covered if neighbours that lie above it over torn edges surround it in the plane (no half-plane
//      through the node holds them all), or if such neighbours below it do.
//   3. It is surely covered if that holds with 8 r in the place of 4 r, and if these neighbours are all it has or lie
//   in
//      two runs or more around it, others between them: the layers lie among each other. Nodes at a cliff, at the
//      corner of a block or in a gorge three spacings wide are not, however ragged the sampling.
//   4. Covered nodes within two edges of one another belong together; such a group counts if two of it are surely
//      covered: one point alone is an outlier.
//   5. Folded are the triangles with a corner at a node of such a group or at a neighbour of one.
// A node whose merged points lie as far apart in height as the ends of an edge of rule 3 is surely covered, too.
//
// Not seen: layers closer than h or r allows (a fold fades out towards its crease), and single spikes. Seen as folds
// though they are none: pits, ridges and posts no wider than one or two spacings and steeper than rule 1.
#pragma once
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/base/fixed_sum.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/geom/vec.hpp"
#include "isopach/overlay/border.hpp"

namespace isopach {

inline constexpr double torn_spacings = 2;
inline constexpr double torn_steps = 4, surely_torn_steps = 8;

struct Folds {
  Array<unsigned char> folded;  ///< one flag per real triangle of the footprint; empty if none is
  double area = 0;              ///< of those triangles, in the plane
  FixedSum area_sum;            ///< the same, before it is rounded
  [[nodiscard]] bool any() const { return !folded.empty(); }
  [[nodiscard]] bool holds(Index triangle) const { return !folded.empty() && folded[triangle] != 0; }
};

/// Of a triangulation that is part of a larger one (tiles/): by node whether it is asked about; the others are known
/// not to be covered. Default: all of one that is whole.
struct AskedNodes {
  std::span<const unsigned char> flags = {};  ///< by node; empty: all
  double area_bound = 0;                      ///< as AskedTriangles::area_bound
};

/// `spread`: by node, the largest difference of height of the points that it was merged from; empty if none was. A
/// function of the set of nodes and their heights: no order, number of threads or unit enters, and turning all heights
/// upside down changes nothing. Degenerate: without a real triangle there are no folds. Cost O(nodes); on an even
/// surface little more than one look at each edge. Oracle: the definition, node by node,
/// tests/overlay/folds_test.cpp.
[[nodiscard]] Folds find_folds(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                               std::span<const double> spread, const Footprint& footprint, const Context& context,
                               const AskedNodes& asked = {});

/// By node whether rules 1 to 3 say that it is covered, in a scan of which nothing is removed. Right for nodes of which
/// the neighbours' neighbours have all of their triangles. `asked` as above. Cost as find_folds.
[[nodiscard]] Array<unsigned char> nodes_covered(const Triangulation& t, std::span<const Point2> xy,
                                                 std::span<const double> z, std::span<const double> spread,
                                                 const AskedNodes& asked, const Context& context);

/// The footprint without the folds; its areas stay those of the border alone.
[[nodiscard]] Footprint without(const Footprint& footprint, const Folds& folds);

}  // namespace isopach
