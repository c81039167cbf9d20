// From a start to the symmetry plane: match and turn until it stands still; where no face vouches for it, both sides
// have to.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/apps/asymmetry.hpp"
#include "isopach/apps/mirror.hpp"

namespace isopach {

struct FoundPlane {
  Upright place;                      ///< the scan upright before it, from the coordinates of the points
  SymmetryPlane plane;                ///< twist, glide and standard deviations alone
  std::optional<PoseEvidence> sides;  ///< unless a face vouches for the plane
  int iterations = 0;
  bool converged = false;
  std::string reason;  ///< why the search stopped
  std::vector<std::string> warnings;
  double overlap = 1;  ///< share of the area that was taken for symmetric and fitted
};

/// Matches the points to their mirror image and turns them upright before the plane, until it stands still (five
/// rounds at most). `towards`: from side to side. Errors: OverlapError where the plane lies across the direction of
/// projection, or nothing overlaps.
[[nodiscard]] FoundPlane refined_plane(const Array<Point3>& points, const Upright& start, const Point3& towards,
                                       const AsymmetryOptions& o, const Context& context);

/// As refined_plane, and looked at by what both sides show (symmetry_check.hpp). A plane that they do not agree about
/// is given up for one found among all motions in space, if they agree about that. Throws exit 5 where they agree about
/// neither, unless o.accept_doubt. σ is that of the jackknife where this is clearly larger. `path`: for messages.
/// Test: test_a_crop_just_beyond_the_plane of tests/cli/asymmetry_test.py.
[[nodiscard]] FoundPlane agreed_plane(const Array<Point3>& points, const Upright& start, const Point3& towards,
                                      const AsymmetryOptions& o, const std::string& path, const Context& context);

}  // namespace isopach
