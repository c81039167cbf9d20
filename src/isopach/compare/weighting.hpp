// weighting: what options.weight asks for. Values of the points become values of the nodes (NodeWeight), and with what
// T1 and T2 know of interpolation values in both surfaces (Weighting), of which the integrals are asked.
#pragma once
#include <optional>

#include "isopach/compare/comparison.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/pair.hpp"

namespace isopach::stages {

/// Refuses a weight that contradicts another option.
void check_weight(const CompareOptions& options);

/// Refuses a formula or a raster that is named but whose function or values are not there.
void check_read(const WeightSource& source);

/// The mean of the values of the points of each node, whatever their order. Errors, naming --weight and `file`: a value
/// below 0 or not finite.
[[nodiscard]] Array<double> attribute_of_nodes(const CloudView& cloud, const AttributeView& attribute,
                                               const HeightField& field, const std::string& file);

/// What options.weight names, looked at before any work: the values of an attribute at the nodes of its scan, or a
/// raster.
struct NodeWeight {
  Point3 origin{};  ///< frame coordinates + origin = along the axes of the frame, unshifted
  std::optional<RasterValues> raster;
  std::size_t scan = 1;  ///< whose attribute
  Array<double> own;
};
/// A node of several points has the mean of their values. Errors, naming --weight: no such attribute, a value below 0
/// or not finite, a formula or a raster that was named but not read, a raster with another direction than z.
[[nodiscard]] NodeWeight weight_of_nodes(const CloudView& a, const CloudView& b, const Pair& pair, Comparison& c);

/// The weight in both surfaces.
class Weighting {
 public:
  /// `pair`: located.
  Weighting(NodeWeight weight, const Pair& pair, const CompareOptions& options, const Context& context);

  /// Whether there is a weight; otherwise nothing below does anything or takes memory.
  [[nodiscard]] bool asked() const { return options_.weight.kind != WeightSource::Kind::none; }

  /// The weighted measures over the overlay.
  [[nodiscard]] WeightedMeasures over(const OverlayCells& cells, const Pair& pair) const;

  /// The attribute at the nodes of T; empty where the weight is none.
  [[nodiscard]] Array<double> at(const UnitedNodes& nodes) const;

  /// The weighted measures into c.weighted: those over the overlay, or else over T, for which `at_nodes` is at().
  void describe(const Array<double>& at_nodes, const std::optional<WeightedMeasures>& over_overlay,
                Comparison& c) const;

 private:
  [[nodiscard]] bool is_attribute() const { return options_.weight.kind == WeightSource::Kind::attribute; }
  [[nodiscard]] Weight weight() const;

  const CompareOptions& options_;
  const Context& context_;
  NodeWeight weight_;
  Array<double> at_other_;  // attribute at the nodes of the other scan
};

}  // namespace isopach::stages
