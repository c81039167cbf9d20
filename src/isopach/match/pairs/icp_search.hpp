// The loop of ICP over two oriented clouds in one frame: what icp() and the coarse start share.
#pragma once
#include <string>
#include <vector>

#include "isopach/match/matching.hpp"
#include "isopach/match/pairs/least_squares.hpp"

namespace isopach {

struct IcpState {
  Motion motion;
  PairInformation information;  ///< at `motion`
  Array<Link> links;            ///< forward pairs of the last step
  Array<Link> back;             ///< pairs from FIXED in MOVING, if they are sought
  std::vector<MatchStep> history;
  int iterations = 0;
  bool converged = false;
  std::string reason;
  double share = 0;  ///< of the queries whose pair takes part
};

/// Smallest eigenvalue of the normal matrix that the surfaces, and not their noise, are taken to have made.
[[nodiscard]] double information_floor(const OrientedCloud& moving, const OrientedCloud& fixed);

/// How the first level is solved. once: from the start, with all rejections. twice: also from where all pairs alike,
/// of any length, lead first, since rejections and weights that are taken from the pairs keep those that fit already
/// (the ring of a scanner on the ring of the other); of the two the one goes on where more of the surface fits.
/// none: the start is near; all points at once.
enum class FirstLevel { once, twice, none };

/// From `start`, first on every k-th point, at last on all. Throws OverlapError where hardly any pair is left. Cost:
/// O(log n) a point and step, less once the steps are small. Test: tests/match/icp_test.cpp.
[[nodiscard]] IcpState icp_search(const OrientedCloud& moving, const OrientedCloud& fixed, const Motion& start,
                                  const MatchOptions& options, FirstLevel first, const Context& context);

}  // namespace isopach
