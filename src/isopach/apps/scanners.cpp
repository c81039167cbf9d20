#include "isopach/apps/scanners.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "isopach/apps/patches.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/field/filter.hpp"
#include "isopach/match/match.hpp"

namespace isopach {
namespace {

constexpr std::size_t fewest_patches = 8;
constexpr double lost_share = 0.5;  // of the energy of a detail: an error below it leaves the detail seen
constexpr double rounding = 1e-9;   // of a length: the reference itself holds two of its own spacings

Cloud moved(const CloudView& scan, const Pose& pose) {
  Cloud out;
  out.path = scan.path, out.format = scan.format, out.unit = scan.unit, out.vertical_unit = scan.vertical_unit;
  out.crs = scan.crs;
  for (const AttributeView& a : scan.attributes) out.attributes.push_back({a.name, a.values.copy()});
  out.points.resize(scan.points.size());
  for_each_index(out.points.size(), [&](std::size_t i) { out.points[i] = pose.apply(scan.points[i]); });
  return out;
}

void add_new(std::vector<std::string>& all, const std::vector<std::string>& more) {
  for (const std::string& w : more)
    if (std::find(all.begin(), all.end(), w) == all.end()) all.push_back(w);
}

/// One scan against the reference; the heights of the scan at the points of the reference, NaN where there are none.
Scanner against(const CloudView& scan, const CloudView& reference, const ScannersOptions& o,
                Array<double>& at_reference, Scanners& all, const Context& context) {
  Scanner s;
  s.pose = o.match.start;
  if (o.align) {
    MatchOptions wanted = o.match;
    wanted.compare.check_layers = false;  // the comparison does
    const Matching m = match(scan, reference, wanted, context);
    if (!slides_alone(m)) require_trust(m, "@align: " + cloud_name(scan));
    s.verdict = m.verdict;
    s.pose = m.pose;
    s.converged = m.converged;
    add_new(all.warnings, m.warnings);
  }
  CompareOptions options = o.match.compare;
  options.pose = s.pose;
  const Comparison c = compare(reference, scan, options, context);
  add_new(all.warnings, c.warnings);
  all.reference = c.a;
  all.unit = c.unit;
  s.input = c.b;
  s.rho = c.measures.rho;
  s.rho_dv = c.detail ? c.detail->rho : std::numeric_limits<double>::quiet_NaN();
  s.coverage = c.coverage;
  s.residuals = point_residuals(scan, s.pose, c.frame, options.project, c.fields_b.dz_signed, context);
  s.spacing = std::sqrt(c.domain_area / std::max<double>(1, static_cast<double>(s.residuals.count)));
  HeightField object = project(reference, Pose{}, c.frame, options.project, context);
  const MatchSurface surface = make_surface(std::move(object.xy), std::move(object.z), c.frame.curve,
                                            options.border == BorderRule::trim, options.max_edge, context);
  s.spot = find_spot(project(scan, s.pose, c.frame, options.project, context), surface, s.spacing, o.reference_sigma,
                     context);
  if (s.spot.width == 0) {                                         // all points, not a choice of them
    const double own = o.reference_sigma * o.reference_sigma / 2;  // interpolated within triangles: half the variance
    s.spot.noise = std::sqrt(std::max(0.0, s.residuals.noise * s.residuals.noise - own));
  }
  at_reference = c.fields_a.dz_signed;
  return s;
}

/// The nodes of the reference that both scans cover.
std::vector<DetailSample> samples_of(const CloudView& reference, const std::array<Array<double>, 2>& d,
                                     const ScannersOptions& o, const Context& context) {
  const ProjectOptions& project_options = o.match.compare.project;
  const Frame frame = choose_frame(reference, reference, Pose{}, project_options, context);
  const HeightField field = project(reference, Pose{}, frame, project_options, context);
  Array<double> of_node[2];
  for (std::size_t k = 0; k < 2; ++k) {
    of_node[k].assign(field.xy.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < d[k].size(); ++i) {
      const Index node = field.node_of_point[i];
      if (node == no_index || !std::isfinite(d[k][i])) continue;
      const double own = frame.to_field(reference.points[i]).z;
      of_node[k][node] = own + d[k][i];  // the surface of the scan there: the same for all points of a node
    }
  }
  std::vector<DetailSample> samples;
  for (std::size_t i = 0; i < field.xy.size(); ++i)
    if (std::isfinite(of_node[0][i]) && std::isfinite(of_node[1][i]))
      samples.push_back({field.xy[i], field.z[i], {of_node[0][i], of_node[1][i]}});
  return samples;
}

struct Energy {
  Sum reference;
  std::array<Sum, 2> shared, error;
  std::size_t stretches = 0;
};

/// Whether nodes that follow one another on the curve lie together. Where the curve leaves the scan and comes back
/// elsewhere they do not. n cells in a row of a Hilbert curve lie within √(6 n) of their side; here twice the area.
/// The cell is that of all nodes, or of these where they are sparser.
bool compact(const std::vector<DetailSample>& samples, std::size_t begin, std::size_t end, double cell) {
  Box2 box{samples[begin].xy, samples[begin].xy};
  std::vector<double> steps;
  for (std::size_t i = begin + 1; i < end; ++i) {
    const Point2 &p = samples[i - 1].xy, &q = samples[i].xy;
    steps.push_back((q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y));
    box.min = {std::min(box.min.x, q.x), std::min(box.min.y, q.y)};
    box.max = {std::max(box.max.x, q.x), std::max(box.max.y, q.y)};
  }
  const double width = box.max.x - box.min.x, depth = box.max.y - box.min.y;
  const double area = static_cast<double>(end - begin) * std::max(cell, median(steps));
  return width * width + depth * depth <= 12 * area;
}

void add_patch(const std::vector<DetailSample>& samples, std::size_t begin, std::size_t run, Energy& energy) {
  PatchValues<2> xy = PatchValues<2>::Zero();
  PatchValues<3> heights = PatchValues<3>::Zero();  // reference, first scan, second scan
  for (int k = 0; k < patch; ++k)
    for (std::size_t i = begin; i < begin + run; ++i) {
      const DetailSample& s = samples[i + static_cast<std::size_t>(k) * run];
      xy.row(k) += Eigen::RowVector2d(s.xy.x, s.xy.y);
      heights.row(k) += Eigen::RowVector3d(s.reference, s.scan[0], s.scan[1]);
    }
  xy /= static_cast<double>(run), heights /= static_cast<double>(run);
  take_off_quadratic(xy, heights);
  energy.reference.add(heights.col(0).squaredNorm());
  for (int scan = 0; scan < 2; ++scan) {
    const auto shown = heights.col(scan + 1);
    energy.shared[static_cast<std::size_t>(scan)].add(heights.col(0).dot(shown));
    energy.error[static_cast<std::size_t>(scan)].add((shown - heights.col(0)).squaredNorm());
  }
  energy.stretches += patch;
}

}  // namespace

std::vector<DetailScale> detail_scales(const std::vector<DetailSample>& samples, double cell) {
  std::vector<DetailScale> scales;
  for (std::size_t run = 1; run * patch * fewest_patches <= samples.size(); run *= 4) {
    Energy energy;
    for (std::size_t begin = 0; begin + run * patch <= samples.size(); begin += run * patch)
      if (compact(samples, begin, begin + run * patch, cell)) add_patch(samples, begin, run, energy);
    if (energy.stretches < patch * fewest_patches) continue;
    DetailScale s;
    s.length = 2 * std::sqrt(cell * static_cast<double>(run));
    s.stretches = energy.stretches;
    const auto n = static_cast<double>(energy.stretches);
    const double whole = energy.reference.value();
    s.reference = std::sqrt(whole / n);
    for (std::size_t k = 0; k < 2; ++k) {
      s.gain[k] = whole > 0 ? energy.shared[k].value() / whole : 0;
      s.error[k] = std::sqrt(energy.error[k].value() / n);
      s.seen[k] = energy.error[k].value() < lost_share * whole;
    }
    scales.push_back(s);
  }
  return scales;
}

void forget_what_points_cannot_hold(std::vector<DetailScale>& detail, const std::array<double, 2>& spacing) {
  for (DetailScale& s : detail)
    for (std::size_t k = 0; k < 2; ++k)
      if (s.length < 2 * spacing[k] * (1 - rounding)) s.seen[k] = false;
}

namespace {

Scanners run(const CloudView& a, const CloudView& b, const CloudView& reference, const ScannersOptions& options,
             const Context& context) {
  Scanners all;
  all.options = options;
  if (!(options.reference_sigma >= 0) || !std::isfinite(options.reference_sigma))
    throw UsageError("@reference-sigma: is no standard deviation: a number of 0 or more");
  stages::Clock clock(all.timing, context);
  std::array<Array<double>, 2> at_reference;
  clock.start("scan_a");
  all.scan[0] = against(a, reference, options, at_reference[0], all, context);
  clock.start("scan_b");
  all.scan[1] = against(b, reference, options, at_reference[1], all, context);

  clock.start("compare");
  CompareOptions compare_options = options.match.compare;
  compare_options.pose = {};
  all.comparison = compare(moved(a, all.scan[0].pose), moved(b, all.scan[1].pose), compare_options, context);
  const Comparison& c = all.comparison;
  all.rho = c.measures.rho;
  all.bias = c.measures.difference.mean;
  all.rho_dv = c.detail ? c.detail->rho : std::numeric_limits<double>::quiet_NaN();
  all.coarser = c.detail && c.detail->coarser_is_b ? "B" : "A";

  clock.start("detail");
  const std::vector<DetailSample> samples = samples_of(reference, at_reference, options, context);
  all.detail = detail_scales(samples, c.domain_area / std::max<double>(1, static_cast<double>(samples.size())));
  forget_what_points_cannot_hold(all.detail, {all.scan[0].spacing, all.scan[1].spacing});
  for (std::size_t k = 0; k < 2; ++k)
    for (auto s = all.detail.rbegin(); s != all.detail.rend(); ++s)
      if (s->seen[k]) all.scan[k].resolved = s->length;
  clock.stop();
  add_new(all.warnings, c.warnings);
  for (std::size_t k = 0; k < 2; ++k)
    if (!all.scan[k].converged)
      all.warnings.push_back(fmt::format("the matching of {} to the reference did not converge", k == 0 ? "A" : "B"));
  return all;
}

}  // namespace

Scanners scanners(const CloudView& a, const CloudView& b, const CloudView& reference, const ScannersOptions& options,
                  const Context& context) {
  Scanners result;
  run_with_threads(context, [&] { result = run(a, b, reference, options, context); });
  return result;
}

}  // namespace isopach
