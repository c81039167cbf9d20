// uncertainty: standard deviations of above, below and net, from those of the input heights under a named model.
//
// Every height on either surface is a linear combination of input heights (barycentric, see stencils.hpp), so
// net = Σ w2_q z2_q − Σ w1_q z1_q with weights that depend on the places of the nodes alone: exact, and with them the
// variance, whatever the covariance of the heights. above and below are not linear; their weights are the derivatives
// at the measured heights, the same integrals over the part where d > 0 or d < 0: exact to first order (the delta
// method), right where the noise is small against d. Where it is not, above and below are also biased: a normal error
// of deviation τ on d = 0 makes E max(d, 0) = τ/√(2π), and less wherever d differs from 0. `rectification_bias` is
// that bound, integrated.
//
// Models. independent: no two nodes share their error. correlated: two nodes of a scan at distance r share it with
// correlation c(r) [Rolstad2009]; scans are independent of each other. registration: the
// noise of one of those, and an unknown motion of B against A on top: a shift along the direction, the same everywhere,
// or a whole pose with its covariance (registration.hpp).
#pragma once
#include <array>
#include <optional>
#include <span>
#include <string>

#include "isopach/cloud/raster_values.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/uncertainty/detection.hpp"
#include "isopach/overlay/stencils.hpp"

namespace isopach {

enum class UncertaintyModel { none, independent, correlated, registration };
/// c(r), with L the range: spherical 1 − 1.5 r/L + 0.5 (r/L)³, 0 from L on; exponential exp(−3 r/L); gaussian
/// exp(−3 (r/L)²): both have fallen to 5 % at L.
enum class CorrelationShape { spherical, exponential, gaussian };

/// Where the standard deviation of the heights of one scan comes from.
struct SigmaSource {
  enum class Kind { none, constant, attribute, raster } kind = Kind::none;
  double value = 0;                                   ///< constant: in the unit of heights
  std::string name;                                   ///< attribute of the points, or path of the raster
  std::optional<RasterValues> raster = std::nullopt;  ///< in x and y of the input
};

/// How well the pose of B is known, as isopach match says it: turns (rad) about x, y, z of the input axes through
/// `centre`, in coordinates of A, then shifts along x, y, z.
struct PoseCovariance {
  std::array<double, 36> matrix{};  ///< 6×6, row-major
  Point3 centre{0, 0, 0};
};

struct UncertaintyOptions {
  UncertaintyModel model = UncertaintyModel::none;
  SigmaSource sigma1, sigma2;    ///< of A and B; default: not known
  double confidence = 0.95;      ///< of intervals and of the level of detection, between 0 and 1
  double lod = 0;                ///< > 0: the level of detection, unit of heights; 0: from the sigmas
  double correlation_range = 0;  ///< > 0: unit of x and y
  CorrelationShape correlation = CorrelationShape::spherical;
  double registration_error = 0;  ///< > 0: standard deviation of a shift of B along the direction, unit of heights
  std::optional<PoseCovariance> registration_covariance;  ///< instead: of the whole pose
  std::string registration_source;  ///< where the covariance comes from, for reports: a file, "match"
};

/// One number for each of the three volumes.
struct VolumeTriple {
  double net = 0, above = 0, below = 0;
};

/// What a comparison says of its uncertainty. What was not asked for is not there: nothing is ever ±0 for want of data.
struct Uncertainty {
  std::optional<double> lod;                     ///< level of detection; where it varies, its mean by area
  bool lod_is_given = false;                     ///< by the user, not from the sigmas
  std::optional<Detected> detected;              ///< where |d| > level of detection
  std::optional<VolumeTriple> sigma;             ///< standard deviations of the volumes under the model
  std::optional<double> sigma_net_registration;  ///< the part of sigma->net that the registration alone makes
  double deviations = 0;  ///< normal_deviations(confidence): net ± deviations · sigma is the interval
  std::optional<double> rectification_bias;  ///< above and below are too large by this each, at most (see above)
};

/// What each node of one scan counts in the volumes: |∂volume/∂z| in units of area. `net` adds up to the area.
using NodeWeights = Array<VolumeTriple>;

/// Weights of the nodes of T: the integrals of their hat functions over the domain, over d > 0 and over d < 0. One pass
/// over the triangles in their order. Cost O(triangles). Oracle: tests/compare/noise_test.cpp (derivatives by
/// differences).
[[nodiscard]] NodeWeights weights_of_cells(const CellView& cells, const Context& context);
/// The same for what the heights of one scan alone do: on its border they are those of the side of the border.
[[nodiscard]] NodeWeights weights_at_borders(NodeWeights of_cells, const CellView& cells, std::size_t scan);

/// Hands the weights of the nodes of T on to the nodes of one scan that make its height there: `own[i]` is the node of
/// the scan that node i of T is, or no_index; then `other[i]` is its node of the other scan, which `stencil` locates in
/// this one. In the order of T.
[[nodiscard]] NodeWeights weights_of_scan(const NodeWeights& of_cells, std::span<const Index> own,
                                          std::span<const Index> other, std::span<const Stencil> stencil,
                                          std::size_t nodes);

/// Weights of the nodes of both scans over the cells of the exact overlay of m1 and m2. Made in parallel, added in the
/// order of the cells. Cost O(cells). Oracle: as above.
[[nodiscard]] std::array<NodeWeights, 2> weights_of_overlay(const OverlayCells& cells, const OverlayMesh& m1,
                                                            const OverlayMesh& m2, const Context& context);

/// c(r) for a range > 0.
[[nodiscard]] double correlation(CorrelationShape shape, double range, double r);

/// Variance of the three volumes by errors of one scan that are independent: Σ w² σ².
[[nodiscard]] VolumeTriple independent_variance(const NodeWeights& weights, std::span<const double> sigma);

/// … that are correlated: Σ Σ w_p w_q σ_p σ_q c(|p − q|). Nodes are gathered in squares of an eighth of the range, each
/// a point mass at its centre of weight; inside a square the mean correlation of a square counts, and each node wholly
/// with itself. Squares further apart than 1 (spherical), 2.5 (exponential) or 1.6 (gaussian) ranges count nothing,
/// which leaves out at most 0.5 % of the variance. Within 1 % of the double sum in all tests. Never below the
/// independent variance. Cost O(n log n + 700 squares), in parallel, memory 40 bytes a square. Oracle:
/// tests/compare/noise_test.cpp (the double sum over all pairs).
[[nodiscard]] VolumeTriple correlated_variance(const NodeWeights& weights, std::span<const double> sigma,
                                               std::span<const Point2> xy, CorrelationShape shape, double range,
                                               const Context& context);

}  // namespace isopach
