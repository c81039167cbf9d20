// accuracy(reconstruction, reference): how well a reconstruction agrees with a reference scan, after alignment: bias,
// scatter, largest deviation, and how much of the reference is there (docs/use/accuracy.md).
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/apps/point_residuals.hpp"
#include "isopach/distance/distance.hpp"
#include "isopach/match/matching.hpp"

namespace isopach {

/// What the alignment may do. none: both are in one system already; scale: also a uniform scale.
enum class Align { none, rigid, scale };

struct AccuracyOptions {
  MatchOptions match;  ///< start, freedom and fit of the alignment; match.compare: scans, border, unit
  Align align = Align::rigid;
  double within = 0;  ///< > 0: also the share of the reference that is met to within this, unit of heights
};

struct Completeness {
  double reference_area = 0;     ///< what the reference's sampling supports
  double share = 0;              ///< of it, over which the reconstruction is known, too; folds of either count
  std::optional<double> within;  ///< share of it without folds where d along the normal is at most options.within
};

struct Accuracy {
  AccuracyOptions options;
  std::string unit = "unknown";
  std::optional<Matching> matching;  ///< unless Align::none
  Pose pose;                         ///< T_reference_reconstruction
  double scale = 1;                  ///< of the pose
  Comparison comparison;  ///< A: the reference, B: the reconstruction after the pose; d = reconstruction − reference
  Measures normal;        ///< of the same cells, along the normal of the surface: what the headline tells
  PointResiduals
      points;           ///< of the points of the reconstruction about the surface of the reference, along the direction
  Distances distances;  ///< A, B likewise: to the closest surface point, Hausdorff
  Completeness completeness;
  std::vector<std::string> warnings;
  Timing timing;
};

/// match, compare, distance. An alignment takes up what it is free to: a constant offset along the direction is no bias
/// after it. Errors: as of these three. An alignment that does not converge is a result (matching->converged
/// false); one that is neither trusted nor accepted is an Error (see require_trust).
/// Test: tests/apps/accuracy_test.cpp.
[[nodiscard]] Accuracy accuracy(const CloudView& reconstruction, const CloudView& reference,
                                const AccuracyOptions& options, const Context& context);

/// Area where −limit <= d <= limit: cells are cut along the lines d = ±limit. Cost O(cells).
[[nodiscard]] double area_within(const CellView& cells, double limit, const Context& context);

}  // namespace isopach
