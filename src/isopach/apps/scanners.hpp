// scanners(a, b, reference): two scanners that scanned one object, against a reference of it and against each other:
// noise and bias of each, which details of the object each of them resolves (docs/use/scanners.md).
#pragma once
#include <array>
#include <string>
#include <vector>

#include "isopach/apps/point_residuals.hpp"
#include "isopach/apps/spot.hpp"
#include "isopach/match/matching.hpp"

namespace isopach {

struct ScannersOptions {
  MatchOptions match;          ///< of each scan to the reference; match.compare: scans, border, unit
  bool align = true;           ///< match each scan to the reference first
  double reference_sigma = 0;  ///< noise of the reference, standard deviation: taken off that of the scanners
};

/// How much of the reference's detail of one size a scan shows. Detail: the means over a compact stretch of nodes of
/// the reference, less the quadratic surface through 16 neighbouring ones. Of the energy of waves twice as long it
/// holds 10 %, of waves four times as long 0.3 %; a plane instead would leave 60 % and 7 %.
struct DetailScale {
  double length = 0;              ///< twice the side of a stretch: the wavelength that it can hold
  double reference = 0;           ///< rms of the detail of the reference
  std::array<double, 2> gain{};   ///< by scan: Σ r s / Σ r², 1 where it shows the detail as it is
  std::array<double, 2> error{};  ///< by scan: rms of s − r
  std::array<bool, 2> seen{};  ///< by scan: Σ (s − r)² is less than half of Σ r², and its points can hold `length`
  std::size_t stretches = 0;   ///< that the numbers stand on
};

struct Scanner {
  InputSummary input;
  Pose pose;  ///< T_reference_scan
  bool converged = true;
  std::optional<Verdict> verdict;  ///< on the pose; unless it was given
  PointResiduals residuals;        ///< of its points about the reference
  Spot spot;                       ///< over which it averages; its noise, without that of the reference
  double rho = 0, rho_dv = 0;      ///< against the reference; rho_dv NaN where there is none
  double coverage = 0, spacing = 0;
  double resolved = 0;  ///< the shortest DetailScale::length that is seen; 0: none
};

struct Scanners {
  ScannersOptions options;
  std::string unit = "unknown";
  std::array<Scanner, 2> scan;
  InputSummary reference;
  double rho = 0, rho_dv = 0, bias = 0;  ///< b against a; bias: mean of b − a
  std::string coarser;                   ///< "A" or "B", by rho_dv
  std::vector<DetailScale> detail;       ///< from fine to coarse; of the nodes that both scans cover
  Comparison comparison;                 ///< of a (A) and b (B), both moved to the reference
  std::vector<std::string> warnings;
  Timing timing;
};

/// Each scan is matched to the reference and compared with it; then they are compared with each other. The reference is
/// taken for the truth but for reference_sigma. Errors: as of match and compare. Test: tests/apps/scanners_test.cpp.
[[nodiscard]] Scanners scanners(const CloudView& a, const CloudView& b, const CloudView& reference,
                                const ScannersOptions& options, const Context& context);

/// Heights of the reference and of both scans at nodes of the reference, in the order of the curve.
struct DetailSample {
  Point2 xy;
  double reference;
  std::array<double, 2> scan;
};
/// Stretches of 1, 4, 16, … nodes as long as there are at least 8 patches of 16 stretches; patches whose nodes do not
/// lie together are left out. `cell`: area a node stands for. `seen` by energy alone: see
/// forget_what_points_cannot_hold.
[[nodiscard]] std::vector<DetailScale> detail_scales(const std::vector<DetailSample>& samples, double cell);

/// Nothing shorter than two spacings of a scan's points is seen by it (Nyquist), however little is left of the detail.
/// Test: Scanners.ClaimsNoDetailFinerThanItsPointsHold.
void forget_what_points_cannot_hold(std::vector<DetailScale>& detail, const std::array<double, 2>& spacing);

}  // namespace isopach
