// MatchOptions: every option of a matching with its default, unit and reason. Names are those of the command line.
#pragma once
#include "isopach/compare/options.hpp"
#include "isopach/geom/rigid.hpp"

namespace isopach {

/// What is minimised. measure: ρ between the two triangulated surfaces; icp_point, icp_plane: the paper's (1) and (3);
/// icp_gicp: plane to plane [Segal2009]; currents: (5).
enum class Objective { measure, icp_point, icp_plane, icp_gicp, currents };

/// Whether it is of pairs of nearest points, and not of surfaces.
[[nodiscard]] constexpr bool of_pairs(Objective objective) {
  return objective == Objective::icp_point || objective == Objective::icp_plane || objective == Objective::icp_gicp;
}

/// Which motions are allowed, about and along the projection direction (axes of the pair's frame).
struct Freedom {
  bool shift_x = true, shift_y = true, shift_z = true;
  bool turn_x = true, turn_y = true;  ///< tilts
  bool turn_z = true;                 ///< rotation about the projection direction
  bool scale = false;                 ///< uniform; off unless asked for
};

/// MatchOptions::tolerance where it is 0, unless noise ends the search before.
inline constexpr double default_match_tolerance = 1e-8;

/// Objectives of pairs alone: which pairs of nearest points take part, and how much.
struct IcpOptions {
  /// Weight of a pair. tukey: falls from 1 to 0 with the residual (Tukey's biweight, width from the median), so that
  /// real change does not pull; uniform: all alike, the plain sums (1) and (3).
  enum class Weights { tukey, uniform } weights = Weights::tukey;
  double reject_distance = 3;             ///< longest pair, in medians of all pairs' lengths; 0: any
  bool reject_distance_absolute = false;  ///< reject_distance is a length in the unit of the scans
  double reject_normal = 45;              ///< degrees, largest angle between the two normals; 0: any
  bool reject_boundary = true;            ///< no pair with a point on the boundary of FIXED
  bool one_to_one = false;                ///< of the pairs with one point of FIXED only the shortest
  bool symmetric = false;                 ///< also pairs sought from FIXED in MOVING; E is the sum of both

  friend bool operator==(const IcpOptions&, const IcpOptions&) = default;
};

struct MatchOptions {
  CompareOptions compare;  ///< scans, border and measure as in a comparison; compare.pose is not used
  Objective objective = Objective::measure;
  Pose start;           ///< T_fixed_moving to start from, input coordinates; default identity
  bool coarse = false;  ///< look for a start first, from any rotation about the axis; `start` is not used
  Freedom freedom;
  double overlap = 0;  ///< share of the common area that is fitted, in (0, 1]; 0: chosen from the data
  int max_iterations = 100;
  double tolerance = 0;  ///< step below which it has converged, as a share of the extent; 0: 1e-8, or a tenth
                         ///< of the standard deviation that noise gives the step (a fiftieth below 20000 nodes)
  bool judge = true;     ///< compare before and after; false saves about half of the time
  bool keep_comparisons = false;  ///< for maps: both comparisons are part of the result
  bool check_pose = true;         ///< a verdict on the pose; where it is doubted, a coarse search by itself
  bool accept_doubt = false;      ///< the user knows of change: a pose that is not trusted is taken as it is
  bool label_points = false;      ///< Matching::agreement of every point of MOVING
  IcpOptions icp;                 ///< objectives of pairs: which of them take part
  double sigma = 0;               ///< currents: width of the kernel, unit of the scans; 0: 5 mean edges
};

}  // namespace isopach
