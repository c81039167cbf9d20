// noise: what options.uncertainty asks for. σ of the points becomes σ of the nodes (NodeSigmas); with what T1 and T2
// know of interpolation it is known in both surfaces (Noise), so that T1 and T2 may go; levels, weights and volumes are
// asked of that, over the overlay and over T.
#pragma once
#include <array>
#include <optional>
#include <string>

#include "isopach/compare/comparison.hpp"
#include "isopach/measure/changes/change_nodes.hpp"
#include "isopach/measure/uncertainty/registration.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/pair.hpp"

namespace isopach::stages {

/// Standard deviation of the height of each node. By `mean`, m merged points of σ_i have √(Σ σ_i²) / m; by any other
/// rule the node has the largest of its points (the least that is certainly enough). A function of the set of points.
/// Errors, naming `option` (e.g. "@sigma1"): no such attribute, a raster that cannot be read or does not reach a
/// point, a value that is no standard deviation.
[[nodiscard]] Array<double> sigma_of_nodes(const CloudView& cloud, const Pose& pose, const HeightField& field,
                                           const SigmaSource& source, DuplicatePolicy policy, const std::string& option,
                                           const Context& context);

/// "lod95" at a confidence of 0.95, "lod99_9" at 0.999, "lod" where the level was given.
[[nodiscard]] std::string lod_field_name(const UncertaintyOptions& options);

/// Refuses options that contradict one another or mean nothing, naming them.
void check_uncertainty(const UncertaintyOptions& options);

/// σ by node of each scan; empty: none is given.
using NodeSigmas = std::array<Array<double>, 2>;
/// As options.uncertainty gives them. Errors as of sigma_of_nodes.
[[nodiscard]] NodeSigmas sigmas_of_nodes(const CloudView& a, const CloudView& b, const Pair& pair,
                                         const CompareOptions& options, const Context& context);

/// What is known of noise over the exact overlay, where it is asked for.
struct OverlayNoise {
  std::optional<Detected> detected;                   ///< the significant part
  std::optional<std::array<NodeWeights, 2>> weights;  ///< of the nodes in the volumes
  std::optional<VolumeMotions> motions;               ///< of the volumes with the pose
};

/// What is known of noise at the nodes of both scans, in both surfaces.
class Noise {
 public:
  /// `pair`: located, with what the borders keep.
  Noise(NodeSigmas sigmas, const Pair& pair, const CompareOptions& options, const Context& context);

  /// Whether anything is to be known; otherwise nothing below does anything or takes memory.
  [[nodiscard]] bool asked() const;

  /// Levels of detection at the input points.
  void level_points(const Pair& pair, PointFields& of_a, PointFields& of_b) const;

  /// The level of detection over the overlay: at the vertices of c.overlay_surface, if it is kept, into c.overlay_lod;
  /// and where the measures are over the overlay, what else is known there.
  [[nodiscard]] OverlayNoise over(const OverlayCells& cells, const Pair& pair, Comparison& c) const;

  /// Everything into c.uncertainty and c.cells.lod. `nodes`: the ids of the nodes of T.
  void describe(const UnitedNodes& nodes, const OverlayNoise& over, Comparison& c) const;

  /// Standard deviations of the volumes of the objects of the list, where there is a model. Errors of the scans are
  /// taken to first order, the outline as it is.
  void describe_changes(const UnitedNodes& nodes, const CellView& cells, const ChangeLevel& level,
                        FoundChanges& found) const;

 private:
  [[nodiscard]] bool has_sigmas() const;
  [[nodiscard]] bool has_model() const;
  [[nodiscard]] bool has_covariance() const { return covariance_.has_value(); }
  [[nodiscard]] double shift_at(std::size_t scan, Index node) const;
  [[nodiscard]] std::optional<double> constant_level() const;
  [[nodiscard]] double deviations() const { return normal_deviations(options_.uncertainty.confidence); }
  [[nodiscard]] Array<double> in_other(std::size_t scan, const Array<double>& of_other) const;
  [[nodiscard]] Array<double> deviations_of_d(const UnitedNodes& nodes) const;
  [[nodiscard]] VolumeTriple variance_of(std::size_t scan, const NodeWeights& weights) const;
  [[nodiscard]] std::optional<Detected> level_overlay(const OverlayCells& cells, const Pair& pair, Comparison& c) const;
  [[nodiscard]] VolumeTriple deviation_by_motion(const VolumeTriple& area, const OverlayNoise& over,
                                                 const Comparison& c) const;
  void add_variances(std::size_t scan, const UnitedNodes& nodes, const std::vector<ChangeWeight>& of_t,
                     std::vector<double>& variance) const;
  void describe_levels(const UnitedNodes& nodes, const OverlayNoise& over, Comparison& c) const;
  void describe_volumes(const UnitedNodes& nodes, const OverlayNoise& over, Comparison& c) const;

  const CompareOptions& options_;
  const Context& context_;
  NodeSigmas sigma_;
  std::array<Array<Point2>, 2> xy_;           // for correlated noise alone
  std::array<Array<Stencil>, 2> in_other_;    // of each node of a scan, in the other
  std::optional<PoseCovariance> covariance_;  // of the registration, frame coordinates
  Array<double> shift_;                       // what it means for the height at each node of B
};

/// The null differences at the nodes of T; empty where none are asked for. Says that the noise floor is too high where
/// most nodes of one scan lie on nodes of the other: two rasters on one grid, a scan and its edited copy. What both
/// hold alike at the same places is in no difference, but in the floor.
[[nodiscard]] NullDifference unite_unchanged(NullDifferences unchanged, const UnitedNodes& nodes, Comparison& c);

}  // namespace isopach::stages
