// Nominal meshes (STL, CAD): their facets are the surface itself and their corners no samples of it. A facet of a scan
// lies on the inner side of what is curved and is raised to it (match/surface.hpp); a facet of a nominal mesh must not
// be, and its corners, which lie on its ridges alone, must not count as points of a scan.
//
// Files cannot tell the two apart: scans come as STL, too. The other scan can: its points lie on the facets, or above
// them where these are curved.
#pragma once
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/match/motion.hpp"
#include "isopach/match/surface.hpp"

namespace isopach {

/// How much of the rise of the facets of a surface the nodes of another one show: 1 if they lie on what is curved, 0 if
/// they lie on the facets.
struct RiseShown {
  double share = 1;
  double error = 1;         ///< standard error, from the spread between patches of neighbouring nodes
  std::size_t patches = 0;  ///< that tell; 0: nothing is known
};

/// Least squares of the heights of `nodes` over the facets of `target` on the rise there, within patches of
/// neighbouring nodes (as many as some facets hold), each about its mean: what the motion may be off is nearly the same
/// over a patch. Nodes that differ from the facet and from the raised facet by more than noise are left out. `motion`
/// takes `nodes` to `target`, or back if `inverse`. The same bits for any number of threads. Cost: a localisation of
/// the nodes. Test: Nominal.*, tests/match/nominal_test.cpp.
[[nodiscard]] RiseShown rise_shown(const MatchSurface& nodes, const MatchSurface& target, const Motion& motion,
                                   bool inverse, const Context& context);

/// Nearer to 0 than to 1 by three standard errors.
[[nodiscard]] bool is_nominal(const RiseShown& shown);
/// Neither nearer to 0 nor to 1 by as much. A free scale does that: it has led where raised facets fit.
[[nodiscard]] bool is_undecided(const RiseShown& shown);

/// Whether a file may hold a nominal mesh: it has faces.
[[nodiscard]] bool may_be_nominal(const Cloud& cloud);

/// Points on the faces of a mesh, about `count`, as many to each unit of area; none of its corners. Random by `seed`
/// and the corners of each face alone: the same points for any order of the faces. Faces that are none, whose corners
/// lie on a line or are not finite, get none. Cost O(faces + count). Test: Nominal.PointsOnFaces.
[[nodiscard]] Cloud points_on_faces(const Cloud& mesh, std::size_t count, std::uint64_t seed);

/// From now on the facets are the surface: no rise. Without `with_nodes` the nodes are none of a scan: no weight.
void take_as_nominal(MatchSurface& s, bool with_nodes);

}  // namespace isopach
