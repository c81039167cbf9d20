#include "isopach/compare/noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "isopach/base/error.hpp"
#include "isopach/base/fixed_sum.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/compare/stages.hpp"

namespace isopach::stages {

namespace {

constexpr double least_shared = 0.5;  // of the nodes of the smaller scan: below, most of d is interpolated

void warn_of_shared_nodes(const UnitedNodes& nodes, Comparison& c) {
  std::size_t shared = 0, of_1 = 0, of_2 = 0;
  for (std::size_t i = 0; i < nodes.xy.size(); ++i) {
    const bool in_1 = nodes.of_1[i] != no_index, in_2 = nodes.of_2[i] != no_index;
    of_1 += in_1 ? 1 : 0, of_2 += in_2 ? 1 : 0, shared += in_1 && in_2 ? 1 : 0;
  }
  const double share =
      static_cast<double>(shared) / static_cast<double>(std::max<std::size_t>(1, std::min(of_1, of_2)));
  if (share < least_shared) return;
  c.warnings.push_back(fmt::format(
      "the noise floor is too high here, and what was taken off by it too much: {:.0f} % of the nodes of {} lie on "
      "nodes of the other scan, where nothing is interpolated and relief that both hold alike cancels: go by the raw "
      "numbers",
      100 * share, of_1 <= of_2 ? "A" : "B"));
}

}  // namespace

bool Noise::has_sigmas() const { return !sigma_[0].empty(); }
bool Noise::has_model() const { return options_.uncertainty.model != UncertaintyModel::none; }

bool Noise::asked() const {
  const UncertaintyOptions& o = options_.uncertainty;
  return o.lod > 0 || o.model != UncertaintyModel::none || o.sigma1.kind != SigmaSource::Kind::none;
}

std::string lod_field_name(const UncertaintyOptions& options) {
  if (options.lod > 0) return "lod";
  std::string name = fmt::format("lod{:.6g}", 100 * options.confidence);
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
}

void check_uncertainty(const UncertaintyOptions& o) {
  using Kind = SigmaSource::Kind;
  using Model = UncertaintyModel;
  const auto length = [](const char* option, double value) {
    if (!(value >= 0) || std::isinf(value))
      throw UsageError(fmt::format("{}: {} is no length, give one above 0", option, value));
  };
  length("@lod", o.lod);
  length("@correlation-range", o.correlation_range);
  length("@registration-error", o.registration_error);
  if (!(o.confidence > 0 && o.confidence < 1))
    throw UsageError(fmt::format("@confidence: {} is no probability between 0 and 1, e.g. 0.95", o.confidence));
  for (const auto& [option, source] : {std::pair{"@sigma1", &o.sigma1}, std::pair{"@sigma2", &o.sigma2}})
    if (source->kind == Kind::constant && (!(source->value >= 0) || std::isinf(source->value)))
      throw UsageError(fmt::format("{}: {} is no standard deviation, give one of 0 or more", option, source->value));
  const bool has_1 = o.sigma1.kind != Kind::none, has_2 = o.sigma2.kind != Kind::none;
  if (has_1 != has_2)
    throw UsageError(
        fmt::format("{0}: also give {1}, for what is known of one scan alone says nothing of the "
                    "difference ({1} 0 for one without noise)",
                    has_1 ? "@sigma1" : "@sigma2", has_1 ? "@sigma2" : "@sigma1"));
  if ((o.model == Model::independent || o.model == Model::correlated) && !has_1)
    throw UsageError("@uncertainty-model: needs the noise of both scans, @sigma1 and @sigma2");
  if (o.model == Model::correlated && !(o.correlation_range > 0))
    throw UsageError(
        "@uncertainty-model correlated: needs @correlation-range, the distance over which errors are "
        "alike");
  if (o.model == Model::registration && !(o.registration_error > 0) && !o.registration_covariance)
    throw UsageError(
        "@uncertainty-model registration: needs @registration-error, the standard deviation of the "
        "vertical shift between the scans or result.json of isopach match, or @match");
  if (o.registration_error > 0 && o.registration_covariance)
    throw UsageError("@registration-error: give a shift or a covariance of the pose, not both");
  if (o.registration_covariance) {
    const std::string fault = fault_of(*o.registration_covariance);
    if (!fault.empty())
      throw InputError(fmt::format("@registration-error: {}: no covariance of a pose: {}",
                                   o.registration_source.empty() ? "matrix" : o.registration_source, fault));
  }
  if (o.correlation_range > 0 && (o.model == Model::none || o.model == Model::independent))
    throw UsageError("@correlation-range: acts in @uncertainty-model correlated or registration alone");
  if (o.correlation_range > 0 && !has_1)
    throw UsageError("@correlation-range: needs the noise of both scans, @sigma1 and @sigma2");
  if ((o.registration_error > 0 || o.registration_covariance) && o.model != Model::registration)
    throw UsageError("@registration-error: acts in @uncertainty-model registration alone");
}

NullDifference unite_unchanged(NullDifferences unchanged, const UnitedNodes& nodes, Comparison& c) {
  if (!c.options.noise_floor) return {};
  warn_of_shared_nodes(nodes, c);
  return unite(unchanged, nodes);
}

NodeSigmas sigmas_of_nodes(const CloudView& a, const CloudView& b, const Pair& pair, const CompareOptions& options,
                           const Context& context) {
  const UncertaintyOptions& o = options.uncertainty;
  if (o.sigma1.kind == SigmaSource::Kind::none) return {};
  const DuplicatePolicy policy = options.project.duplicates;
  NodeSigmas sigma;
  sigma[0] = sigma_of_nodes(a, Pose{}, pair.scan[0].field, o.sigma1, policy, "@sigma1", context);
  sigma[1] = sigma_of_nodes(b, options.pose, pair.scan[1].field, o.sigma2, policy, "@sigma2", context);
  return sigma;
}

Noise::Noise(NodeSigmas sigmas, const Pair& pair, const CompareOptions& options, const Context& context)
    : options_(options), context_(context), sigma_(std::move(sigmas)) {
  if (const auto& given = options_.uncertainty.registration_covariance) {
    covariance_ = in_frame(*given, pair.frame);
    shift_ = height_deviations(pair.mesh(1), *covariance_, context_);
  }
  const auto stencils_of = [&](std::size_t k) {
    const Scan &own = pair.scan[k], &other = pair.scan[1 - k];
    return stencils(pair.seen[k].at, own.field.xy, other.t, other.field.xy, context_);
  };
  if (has_sigmas() || has_covariance()) in_other_[0] = stencils_of(0);
  if (!has_sigmas()) return;
  in_other_[1] = stencils_of(1);
  if (!(options_.uncertainty.correlation_range > 0)) return;
  for (std::size_t k = 0; k < 2; ++k) xy_[k].assign(pair.scan[k].field.xy.begin(), pair.scan[k].field.xy.end());
}

// Standard deviation of d by the registration at a node of a scan.
double Noise::shift_at(std::size_t scan, Index node) const {
  if (!has_covariance()) return options_.uncertainty.registration_error;
  return scan == 1 ? shift_[node] : in_other_[0][node].apply(shift_);
}

// Where it is the same everywhere.
std::optional<double> Noise::constant_level() const {
  const UncertaintyOptions& o = options_.uncertainty;
  if (o.lod > 0) return o.lod;
  if (!has_sigmas() || has_covariance()) return std::nullopt;
  std::array<double, 2> sigma{};
  for (std::size_t scan = 0; scan < 2; ++scan) {
    const auto [least, most] = std::minmax_element(sigma_[scan].begin(), sigma_[scan].end());
    if (*least != *most) return std::nullopt;
    sigma[scan] = *least;
  }
  return deviations() * std::hypot(std::hypot(sigma[0], sigma[1]), o.registration_error);
}

void Noise::level_points(const Pair& pair, PointFields& of_a, PointFields& of_b) const {
  const UncertaintyOptions& o = options_.uncertainty;
  if (!(o.lod > 0) && !has_sigmas()) return;
  const double k = deviations();
  const auto fill = [&](std::size_t scan, const HeightField& field, PointFields& fields) {
    fields.lod_name = lod_field_name(o);
    fields.lod.resize(fields.dz_signed.size());
    for_each_index(fields.lod.size(), [&](std::size_t i) {
      const Index node = field.node_of_point[i];
      if (std::isnan(fields.dz_signed[i]) || node == no_index)
        fields.lod[i] = std::numeric_limits<double>::quiet_NaN();
      else if (o.lod > 0)
        fields.lod[i] = o.lod;
      else
        fields.lod[i] = k * std::hypot(std::hypot(sigma_[scan][node], in_other_[scan][node].apply(sigma_[1 - scan])),
                                       shift_at(scan, node));
    });
  };
  fill(0, pair.scan[0].field, of_a);
  fill(1, pair.scan[1].field, of_b);
}

// Per node of a scan, what the other one has there.
Array<double> Noise::in_other(std::size_t scan, const Array<double>& of_other) const {
  Array<double> values(in_other_[scan].size());
  for_each_index(values.size(), [&](std::size_t i) { values[i] = in_other_[scan][i].apply(of_other); });
  return values;
}

std::optional<Detected> Noise::level_overlay(const OverlayCells& cells, const Pair& pair, Comparison& c) const {
  const bool measured = options_.surface == Surface::overlay, kept = options_.keep_overlay;
  if (const auto level = constant_level()) {
    if (kept) c.overlay_lod.assign(c.overlay_surface.xy.size(), *level);
    if (!measured) return std::nullopt;
    return detect(cells, *level, context_);
  }
  if (!has_sigmas() || !(measured || kept)) return std::nullopt;
  // Deviations take the place of heights: per node their own, and the other scan's interpolated there.
  const auto overlay_of = [&](const std::array<Array<double>, 2>& own, const std::array<Array<double>, 2>& other) {
    const auto mesh = [&](std::size_t k) {
      const Scan& s = pair.scan[k];
      return OverlayMesh{s.t, s.field.xy, own[k], pair.seen[k].at, other[k], s.kept};
    };
    return Overlay(mesh(0), mesh(1), context_);
  };
  const std::array<Array<double>, 2> sigma_there{in_other(0, sigma_[1]), in_other(1, sigma_[0])};
  std::vector<Overlay> deviations{overlay_of(sigma_, sigma_there)};
  std::array<Array<double>, 2> shift, shift_there;
  if (has_covariance()) {  // B moves, A does not
    shift[0].assign(pair.scan[0].field.z.size(), 0), shift[1] = shift_;
    shift_there[0] = in_other(0, shift_), shift_there[1].assign(pair.scan[1].field.z.size(), 0);
    deviations.push_back(overlay_of(shift, shift_there));
  }
  const OverlayLevel level{deviations, has_covariance() ? 0 : options_.uncertainty.registration_error,
                           this->deviations()};
  if (kept) c.overlay_lod = level_at_vertices(level, cells.domain, context_);
  if (!measured) return std::nullopt;
  return detect(cells, level, context_);
}

OverlayNoise Noise::over(const OverlayCells& cells, const Pair& pair, Comparison& c) const {
  OverlayNoise known;
  known.detected = level_overlay(cells, pair, c);
  if (options_.surface != Surface::overlay) return known;
  if (has_model()) known.weights = weights_of_overlay(cells, pair.mesh(0), pair.mesh(1), context_);
  if (has_covariance()) known.motions = volume_motions(cells, covariance_->centre, context_);
  return known;
}

// Per node of T, by noise and registration. The deviation of an interpolated height is taken as the interpolated
// deviation: its upper bound, reached when the nodes of a triangle err alike.
Array<double> Noise::deviations_of_d(const UnitedNodes& nodes) const {
  Array<double> result(nodes.of_1.size());
  for_each_index(result.size(), [&](std::size_t i) {
    if (!has_sigmas() && !has_covariance()) {  // a shift alone
      result[i] = options_.uncertainty.registration_error;
      return;
    }
    const Index i1 = nodes.of_1[i], i2 = nodes.of_2[i];
    double s1 = 0, s2 = 0;
    if (has_sigmas()) {
      s1 = i1 != no_index ? sigma_[0][i1] : in_other_[1][i2].apply(sigma_[0]);
      s2 = i2 != no_index ? sigma_[1][i2] : in_other_[0][i1].apply(sigma_[1]);
    }
    result[i] = std::hypot(std::hypot(s1, s2), i2 != no_index ? shift_at(1, i2) : shift_at(0, i1));
  });
  return result;
}

VolumeTriple Noise::variance_of(std::size_t scan, const NodeWeights& weights) const {
  const UncertaintyOptions& o = options_.uncertainty;
  if (o.model == UncertaintyModel::independent || !(o.correlation_range > 0))
    return independent_variance(weights, sigma_[scan]);
  return correlated_variance(weights, sigma_[scan], xy_[scan], o.correlation, o.correlation_range, context_);
}

// How far the volumes may be off by the registration; `area` is that of the cells, and of those above and below.
VolumeTriple Noise::deviation_by_motion(const VolumeTriple& area, const OverlayNoise& over, const Comparison& c) const {
  const double shift = options_.uncertainty.registration_error;
  if (!has_covariance()) return {shift * area.net, shift * area.above, shift * area.below};
  const VolumeMotions m = over.motions ? *over.motions : volume_motions(c.cells.view(), covariance_->centre, context_);
  const auto deviation = [&](const MotionGradient& g) { return std::sqrt(isopach::variance(g, *covariance_)); };
  return {deviation(m.net), deviation(m.above), deviation(m.below)};
}

void Noise::describe_volumes(const UnitedNodes& nodes, const OverlayNoise& over, Comparison& c) const {
  const NodeWeights of_cells = weights_of_cells(c.cells.view(), context_);
  VolumeTriple variance{};
  Sum net, above, below, bias;
  for (const VolumeTriple& w : over.weights ? (*over.weights)[0] : of_cells)
    net.add(w.net), above.add(w.above), below.add(w.below);
  const std::array<const Array<Index>*, 2> node_of{&nodes.of_1, &nodes.of_2};
  for (std::size_t scan = 0; has_sigmas() && scan < 2; ++scan) {
    const VolumeTriple v = variance_of(
        scan, over.weights ? (*over.weights)[scan]
                           : weights_of_scan(weights_at_borders(of_cells, c.cells.view(), scan), *node_of[scan],
                                             *node_of[1 - scan], in_other_[1 - scan], sigma_[scan].size()));
    variance.net += v.net, variance.above += v.above, variance.below += v.below;
  }
  const VolumeTriple moved = deviation_by_motion({net.value(), above.value(), below.value()}, over, c);
  c.uncertainty.sigma = {std::hypot(std::sqrt(variance.net), moved.net),
                         std::hypot(std::sqrt(variance.above), moved.above),
                         std::hypot(std::sqrt(variance.below), moved.below)};
  if (options_.uncertainty.model == UncertaintyModel::registration) c.uncertainty.sigma_net_registration = moved.net;
  const Array<double> deviation = deviations_of_d(nodes);
  for (std::size_t i = 0; i < of_cells.size(); ++i) bias.add(of_cells[i].net * deviation[i]);
  c.uncertainty.rectification_bias = bias.value() / std::sqrt(2 * std::numbers::pi);
}

void Noise::describe_levels(const UnitedNodes& nodes, const OverlayNoise& over, Comparison& c) const {
  Uncertainty& u = c.uncertainty;
  const CellView cells = c.cells.view();
  c.cells.lod = deviations_of_d(nodes);
  for_each_index(c.cells.lod.size(), [&](std::size_t i) { c.cells.lod[i] *= u.deviations; });
  u.detected = over.detected ? *over.detected : detect(cells, c.cells.lod, context_);
  const auto [least, most] = std::minmax_element(c.cells.lod.begin(), c.cells.lod.end());
  const double box = bounds_of(cells).area;
  FixedSum sum{FixedScale{box, *most}}, area{FixedScale{box}};
  for_common(cells, [&](const CommonCell& cell) {
    const double share = cell.cell().area;
    const auto lod = cell.at_corners(c.cells.lod);
    sum.add(share * ((lod[0] + lod[1] + lod[2]) / 3));
    area.add(share);
  });
  u.lod = *least == *most ? *least : std::clamp(sum.value() / area.value(), *least, *most);
}

void Noise::describe(const UnitedNodes& nodes, const OverlayNoise& over, Comparison& c) const {
  if (!asked()) return;
  const UncertaintyOptions& o = options_.uncertainty;
  Uncertainty& u = c.uncertainty;
  u.deviations = deviations();
  if (o.lod > 0) {
    u.lod = o.lod;
    u.lod_is_given = true;
    c.cells.lod.assign(c.cells.xy.size(), o.lod);
    u.detected = over.detected ? *over.detected : detect(bounded_cells(c), o.lod, context_);
  } else if (has_sigmas()) {
    describe_levels(nodes, over, c);
  }
  if (has_model()) {
    describe_volumes(nodes, over, c);
  } else if (has_sigmas()) {
    c.warnings.emplace_back(
        "@sigma1 and @sigma2 without @uncertainty-model give a level of detection, but no standard deviation of the "
        "volumes: add @uncertainty-model independent, or correlated with @correlation-range");
  }
}

}  // namespace isopach::stages
