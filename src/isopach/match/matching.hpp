// Matching: everything one matching found.
#pragma once
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "isopach/compare/comparison.hpp"
#include "isopach/match/options.hpp"
#include "isopach/match/verdict/verdict.hpp"

namespace isopach {

/// One accepted state of the search, the start included.
struct MatchStep {
  double rho = 0;    ///< objective measure, currents: its value; icp: NaN
  double rms = 0;    ///< of the residuals that take part
  double share = 1;  ///< of the common area (icp: of the pairs) that takes part
};

/// How well two scans lie on one another, by one and the same comparison before and after; NaN: not asked for.
struct Fit {
  double rho = std::numeric_limits<double>::quiet_NaN(), rms = rho, coverage = rho;
};

struct Matching {
  MatchOptions options;
  Pose pose;         ///< T_fixed_moving, input coordinates
  double scale = 1;  ///< of the pose; 1 unless it was free
  InputSummary moving, fixed;
  std::string unit = "unknown";  ///< of lengths
  int iterations = 0;
  bool converged = false;
  std::string reason;  ///< why the search stopped, in words
  std::vector<MatchStep> history;
  Fit before, after;
  std::optional<Comparison> comparison_before, comparison_after;  ///< if options.keep_comparisons
  double overlap = 1;                                             ///< share that was fitted
  bool nominal_moving = false, nominal_fixed = false;  ///< facets taken as the surface itself, see nominal.hpp
  /// 6×6, row-major: rotation (rad) about x, y, z of the input axes through `centre`, then translation (unit). NaN in
  /// the rows and columns of what the scans do not determine; 0 in those that were not free.
  std::array<double, 36> covariance{};
  /// Motions that the scans do not determine, left as they were at the start: turns (rad), then shifts, as covariance.
  std::vector<std::array<double, 6>> undetermined;
  Point3 centre{0, 0, 0};                    ///< of the rotations that the covariance speaks of, fixed coordinates
  std::vector<std::string> weak_directions;  ///< motions that the scans hardly determine, in words
  Array<unsigned char> stable;               ///< per point of MOVING: 1 if it was fitted (stable), 0 if not
  std::optional<Verdict> verdict;            ///< unless options.check_pose is off
  Array<PointVerdict> agreement;             ///< per point of MOVING, if options.label_points
  std::vector<std::string> warnings;
  Timing timing;
};

}  // namespace isopach
