// Errors of matched poses in the standard deviations that the matching states, over scans made here: random samples of
// one surface with errors of their own, MOVING turned and shifted by a known motion.
#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "isopach/match/match.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {

struct PosePairs {
  std::size_t moving_points = 1500, fixed_points = 1500;
  double moving_from = 0;  ///< MOVING covers x from here on, over 1
  double noise = 0.004;
  /// What a scan errs by besides, from (place, random numbers of the scan).
  std::function<std::function<double(const Point2&)>(Random&)> errors;
  std::function<double(const Point2&)> change;  ///< what MOVING has changed by
  MatchOptions options;
};

/// Hills on the unit square and around, slopes of some 0.3.
inline double many_hills(const Point2& p) {
  return 0.05 * std::sin(11 * p.x) * std::cos(9 * p.y) + 0.03 * std::sin(5 * p.x + 7 * p.y + 1) +
         0.02 * std::sin(17 * p.x - 8 * p.y + 2) + 0.01 * std::sin(4 * p.x + 23 * p.y);
}

struct PosePulls {
  double rms = 0;        ///< of error over stated deviation, six a pair
  double rms_shift = 0;  ///< of the three shifts alone
  double rms_error = 0;  ///< of the shifts themselves, unit of the scans
  int without = 0;       ///< pairs without a whole covariance
};

namespace pulls {

inline Cloud scan(const PosePairs& p, bool is_moving, Random& random) {
  const auto errors = p.errors ? p.errors(random) : [](const Point2&) { return 0.0; };
  Cloud cloud;
  const double from = is_moving ? p.moving_from : 0;
  for (std::size_t i = 0; i < (is_moving ? p.moving_points : p.fixed_points); ++i) {
    const Point2 q{from + random.uniform(), random.uniform()};
    const double changed = is_moving && p.change ? p.change(q) : 0;
    cloud.points.push_back({q.x, q.y, many_hills(q) + changed + errors(q) + p.noise * random.bell()});
  }
  return cloud;
}

/// Turn (rad) and shift of the centre that `m` is off `away`, undone.
inline std::array<double, 6> errors_of(const Matching& m, const Pose& away) {
  const Pose both = chained(m.pose, away);
  // `away` is undone up to the error: the centre, in coordinates of FIXED, is where it was before.
  const Point3 now = both.apply(m.centre);
  return {(both.m[9] - both.m[6]) / 2, (both.m[2] - both.m[8]) / 2, (both.m[4] - both.m[1]) / 2,
          now.x - m.centre.x,          now.y - m.centre.y,          now.z - m.centre.z};
}

}  // namespace pulls

inline PosePulls pose_pulls(const PosePairs& p, int pairs, std::uint64_t seed) {
  PosePulls found;
  double squares = 0, of_shifts = 0, errors = 0;
  for (int k = 0; k < pairs; ++k) {
    Random random(seed + static_cast<std::uint64_t>(k));
    const Cloud fixed = pulls::scan(p, false, random), moving = pulls::scan(p, true, random);
    const Pose away = turn_and_shift({random.bell(), random.bell(), random.bell()}, 0.4, middle_of(moving),
                                     {0.005 * random.bell(), 0.005 * random.bell(), 0.005 * random.bell()});
    MatchOptions options = p.options;
    options.judge = false, options.compare.check_layers = false;
    const Matching m = match(posed(moving, away), fixed, options, {});
    const auto error = pulls::errors_of(m, away);
    bool whole = true;
    for (std::size_t i = 0; i < 6; ++i) {
      if (!(m.covariance[7 * i] > 0)) {
        whole = false;
        continue;
      }
      const double square = error[i] * error[i] / m.covariance[7 * i];
      squares += square / (6 * pairs);
      if (i >= 3) of_shifts += square / (3 * pairs), errors += error[i] * error[i] / (3 * pairs);
    }
    if (!whole) ++found.without;
  }
  found.rms = std::sqrt(squares), found.rms_shift = std::sqrt(of_shifts), found.rms_error = std::sqrt(errors);
  return found;
}

}  // namespace isopach::test
