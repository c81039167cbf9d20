// search: the motion of the moving surface that minimises the measure, from coarse to fine.
//
// The measure is an L1 norm; near its minimum it is the sum of squares of its Huber form (quadratic within the noise),
// which iteratively reweighted Gauss-Newton steps minimise [Holland1977], damped as Levenberg-Marquardt
// where a step would raise it. Real change is kept out of the fit by bounded losses (Tukey's biweight) of each node and
// of the mean of each patch of nodes, entered from the Huber solution with a scale that the residuals give themselves.
// The basin is widened by smoothed, thinned copies of both surfaces, solved first.
#pragma once
#include <string>
#include <vector>

#include "isopach/match/matching.hpp"
#include "isopach/match/surface/residuals.hpp"

namespace isopach {

struct SearchResult {
  Motion motion;
  int iterations = 0;
  bool converged = false;
  std::string reason;
  std::vector<MatchStep> history;
  double overlap = 1;                        ///< share of the common area that was fitted
  std::array<double, 49> covariance{};       ///< of a twist about `centre`, frame axes; 0 along what was not searched
  std::vector<Twist> undetermined;           ///< twists about `centre` that the scans do not determine, frame axes
  Point3 centre{0, 0, 0};                    ///< frame coordinates
  double radius = 1;                         ///< by which a turn (rad) becomes a length, where the two are compared
  std::vector<std::string> weak_directions;  ///< in words, axes of the frame named by `axes`
  Array<unsigned char> stable;               ///< by node of the moving surface
};

/// `axes`: the names of the frame's axes in the words about weak directions. The frame coordinates of `moving` are
/// those of the start. Throws OverlapError where no node of one surface lies over the other.
[[nodiscard]] SearchResult search(const MatchSurface& moving, const MatchSurface& fixed, const MatchOptions& options,
                                  const std::array<std::string, 3>& axes, const Context& context);

}  // namespace isopach
