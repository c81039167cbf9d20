// Nominal meshes (STL, CAD): their facets are the surface itself and their corners no samples of it. A facet of a scan
// lies on the inner side of what is curved and is raised to it (match/surface/surface.hpp); a facet of a nominal mesh
// must not be, and its corners, which lie on its ridges alone, must not count as points of a scan.
//
// Files cannot tell the two apart: scans come as STL, too. The other scan can. Its points lie on the facets of a
// nominal mesh, with the same spread everywhere; they lie above the facets of a scan where these are curved, and spread
// more in the middle of them where the surface has detail that the corners miss, or less where the corners carry noise.
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/match/motion.hpp"
#include "isopach/match/surface/surface.hpp"

namespace isopach {

/// How much of the rise of the facets of a surface the nodes of another one show: 1 if they lie on what is curved, 0 if
/// they lie on the facets.
struct RiseShown {
  double share = 1;
  double error = 1;         ///< standard error, from the spread between patches of neighbouring nodes
  double excess = 0;        ///< variance in the middle of facets less that near their corners, by the mean square rise
  double excess_error = 0;  ///< standard error, likewise
  std::size_t patches = 0;  ///< that tell; 0: nothing is known
};

/// Least squares of the heights of `nodes` over the facets of `target` on the rise there, within patches of
/// neighbouring nodes (as many as some facets hold), each about its mean: what the motion may be off is nearly the same
/// over a patch. Nodes that differ from the facet and from the raised facet by more than noise are left out. `motion`
/// takes `nodes` to `target`, or back if `inverse`. The same bits for any number of threads. Cost: a localisation of
/// the nodes. Test: Nominal.*, tests/match/nominal_test.cpp.
[[nodiscard]] RiseShown rise_shown(const MatchSurface& nodes, const MatchSurface& target, const Motion& motion,
                                   bool inverse, const Context& context);

/// The share is 0 to within one half by three standard errors, and the heights spread evenly. A share below 0 tells of
/// a scan as well: noise of a corner lifts the facet and bends it, and the nodes stay behind.
[[nodiscard]] bool is_nominal(const RiseShown& shown);
/// The share may be 0. A free scale blurs it: it leads where raised facets fit.
[[nodiscard]] bool could_be_nominal(const RiseShown& shown);

/// Whether a file may hold a nominal mesh: it has faces.
[[nodiscard]] bool may_be_nominal(const CloudView& cloud);

/// Points on the faces of a mesh, about `count`, as many to each unit of area; none of its corners. Random by `seed`
/// and the corners of each face alone: the same points for any order of the faces. Faces that are none, whose corners
/// lie on a line or are not finite, get none. Cost O(faces + count). Test: Nominal.PointsOnFaces.
[[nodiscard]] Cloud points_on_faces(const CloudView& mesh, std::size_t count, std::uint64_t seed);

/// From now on the facets are the surface: no rise. Without `with_nodes` the nodes are none of a scan: no weight.
void take_as_nominal(MatchSurface& s, bool with_nodes);

}  // namespace isopach
