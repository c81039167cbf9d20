// weighting: what options.weight asks for, on the way through a comparison. Values of the points become values of the
// nodes; what T1 and T2 know of interpolation is used before they go; the integrals come when the cells are there.
#pragma once
#include <optional>

#include "isopach/compare/comparison.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/overlay.hpp"

namespace isopach::stages {

/// Refuses a weight that contradicts another option, and a formula that is none.
void check_weight(const CompareOptions& options);

/// The mean of the values of the points of each node, whatever their order. Errors, naming --weight and `file`: a value
/// below 0 or not finite.
[[nodiscard]] Array<double> attribute_of_nodes(const Cloud& cloud, const Attribute& attribute, const HeightField& field,
                                               const std::string& file);

class Weighting {
 public:
  Weighting(const CompareOptions& options, const Context& context) : options_(options), context_(context) {}

  /// Whether there is a weight; otherwise nothing below does anything or takes memory.
  [[nodiscard]] bool asked() const { return options_.weight.kind != WeightSource::Kind::none; }

  /// The values of the attribute, or of the raster. A node of several points has the mean of their values. Errors,
  /// naming --weight: no such attribute, a value below 0 or not finite, a raster that cannot be read, or with another
  /// direction than z.
  void take_points(const Cloud& a, const Cloud& b, const HeightField& field_a, const HeightField& field_b,
                   Comparison& c);

  /// While T1, T2 and the locations are there.
  void take_meshes(const OverlayMesh& m1, const OverlayMesh& m2);

  /// For measures over the overlay. `clip`: cuts its cells; may be nothing.
  void take_overlay(const Overlay& overlay, const OverlayMesh& m1, const OverlayMesh& m2, const Clip* clip);

  void take_union(const UnitedNodes& nodes);

  /// The weighted measures into c.weighted, over options.surface; over T for `both`.
  void describe(Comparison& c) const;

 private:
  [[nodiscard]] bool is_attribute() const { return options_.weight.kind == WeightSource::Kind::attribute; }
  [[nodiscard]] Weight weight() const;

  const CompareOptions& options_;
  const Context& context_;
  Point3 origin_{};  // frame coordinates + origin = along the axes of the frame, unshifted
  std::optional<RasterValues> raster_;
  bool of_b_ = true;              // whose attribute
  Array<double> own_, at_other_;  // attribute at the nodes of its scan, and of the other one
  Array<double> at_union_;
  std::optional<WeightedMeasures> of_overlay_;
};

}  // namespace isopach::stages
