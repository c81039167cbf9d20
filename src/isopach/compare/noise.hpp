// noise: what options.uncertainty asks for, on the way through a comparison. σ of the points becomes σ of the nodes;
// what T1 and T2 know of interpolation is kept before they go; weights, levels and volumes come when T is there.
#pragma once
#include "isopach/compare/comparison.hpp"
#include "isopach/measure/registration.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/overlay.hpp"

namespace isopach::stages {

/// Standard deviation of the height of each node. By `mean`, m merged points of σ_i have √(Σ σ_i²) / m; by any other
/// rule the node has the largest of its points (the least that is certainly enough). A function of the set of points.
/// Errors, naming `option` (e.g. "--sigma1"): no such attribute, a raster that cannot be read or does not reach a
/// point, a value that is no standard deviation.
[[nodiscard]] Array<double> sigma_of_nodes(const Cloud& cloud, const Pose& pose, const HeightField& field,
                                           const SigmaSource& source, DuplicatePolicy policy, const std::string& option,
                                           const Context& context);

/// "lod95" at a confidence of 0.95, "lod99_9" at 0.999, "lod" where the level was given.
[[nodiscard]] std::string lod_field_name(const UncertaintyOptions& options);

/// Refuses options that contradict one another or mean nothing, naming them.
void check_uncertainty(const UncertaintyOptions& options);

class Noise {
 public:
  Noise(const CompareOptions& options, const Context& context) : options_(options), context_(context) {}

  /// Whether anything is to be known of noise; otherwise nothing below does anything or takes memory.
  [[nodiscard]] bool asked() const;

  void take_sigmas(const Cloud& a, const Cloud& b, const HeightField& field_a, const HeightField& field_b);

  /// While T1, T2 and the locations are there.
  void take_meshes(const OverlayMesh& m1, const OverlayMesh& m2, const Frame& frame);

  /// Levels of detection at the input points.
  void level_points(const HeightField& a, const HeightField& b, PointFields& of_a, PointFields& of_b) const;

  /// The level of detection over the overlay: at the vertices of c.overlay_surface, if it is kept, into c.overlay_lod;
  /// the significant part, where the measures are over the overlay. `clip`: null for all of it.
  void level_overlay(const Overlay& overlay, const OverlayMesh& m1, const OverlayMesh& m2, const Clip* clip,
                     Comparison& c);

  /// For measures over the overlay: weights of the nodes.
  void take_overlay(const Overlay& overlay, const OverlayMesh& m1, const OverlayMesh& m2, const Clip* clip);

  void take_union(const UnitedNodes& nodes);

  /// Everything into c.uncertainty and c.cells.lod, once the measures are there.
  void describe(Comparison& c);

 private:
  [[nodiscard]] bool has_sigmas() const;
  [[nodiscard]] bool has_model() const;
  [[nodiscard]] bool has_covariance() const { return covariance_.has_value(); }
  [[nodiscard]] double shift_at(std::size_t scan, Index node) const;
  [[nodiscard]] std::optional<double> constant_level() const;
  [[nodiscard]] double deviations() const { return normal_deviations(options_.uncertainty.confidence); }
  [[nodiscard]] Array<double> deviations_of_d(std::size_t nodes) const;
  [[nodiscard]] VolumeTriple variance_of(std::size_t scan, const NodeWeights& weights) const;
  void describe_volumes(Comparison& c);

  const CompareOptions& options_;
  const Context& context_;
  std::array<Array<double>, 2> sigma_;        // per node of each scan
  std::array<Array<Point2>, 2> xy_;           // for correlated noise alone
  std::array<Array<Stencil>, 2> in_other_;    // of each node of a scan, in the other
  std::array<Array<Index>, 2> node_of_;       // per node of T its node of each scan
  std::optional<PoseCovariance> covariance_;  // of the registration, frame coordinates
  Array<double> shift_;                       // what it means for the height at each node of B
  std::optional<std::array<NodeWeights, 2>> overlay_weights_;
  std::optional<VolumeMotions> overlay_motions_;
  std::optional<Detected> overlay_detected_;
};

/// Says that the noise floor is too high where most nodes of one scan lie on nodes of the other: two rasters on one
/// grid, a scan and its edited copy. What both hold alike at the same places is in no difference, but in the floor.
void warn_of_shared_nodes(const UnitedNodes& nodes, Comparison& c);

}  // namespace isopach::stages
