// THE PAGE: the algorithm A_ρ, one stage a line.
//
// [Dyshkant2013], section 3.2; measure: equation (7). See docs/method/method.md.
#include "isopach/compare/compare.hpp"

#include <optional>
#include <utility>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/changes.hpp"
#include "isopach/compare/check.hpp"
#include "isopach/compare/currents.hpp"
#include "isopach/compare/domain.hpp"
#include "isopach/compare/noise.hpp"
#include "isopach/compare/slivers.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/compare/weighting.hpp"
#include "isopach/measure/volume/bend.hpp"
#include "isopach/overlay/pair.hpp"

namespace isopach {

namespace {

/// What the exact overlay of T1 and T2 says, beside what stands in the comparison already.
struct OverOverlay {
  stages::OverlayNoise noise;
  std::optional<WeightedMeasures> weighted;
};

OverOverlay measure_overlay(const Pair& pair, const stages::AreaOfInterest& area, const stages::Noise& noise,
                            const stages::Weighting& weighting, Comparison& c, const Context& context) {
  OverOverlay found;
  const Overlay overlay(pair.mesh(0), pair.mesh(1), context);
  const OverlayCells cells(overlay, area.domain());
  stages::measure_overlay(cells, area, c, context);
  found.noise = noise.over(cells, pair, c);
  if (c.options.surface == Surface::overlay && weighting.asked()) found.weighted = weighting.over(cells, pair);
  return found;
}

/// Measures over T, or what is known of it where they are over the overlay.
void measure_common(const stages::AreaOfInterest& area, const stages::Borders& borders,
                    const stages::SmoothSurfaces& smooth, const SumBounds& bounds, Comparison& c,
                    const Context& context) {
  area.cut_cells(c, context);
  CellView cells = c.cells.view();
  cells.bounds = bounds;
  if (c.options.surface != Surface::overlay) {
    c.measures = measure(cells, context, c.options.percentiles);
    area.fill_budget(c, context);
  }
  stages::describe_domain(borders, c);
  stages::describe_slivers(cells, c);
  if (smooth[0]) c.measures.error_estimate = bend_error(cells, *smooth[0], *smooth[1], context).bound / c.domain_area;
}

/// A comparison of which the options and the units are known to go together.
Comparison begin(const CloudView& cloud_a, const CloudView& cloud_b, const CompareOptions& options) {
  check(options);
  Comparison c;
  c.options = options;
  stages::check_units(cloud_a, cloud_b, options, c);
  stages::check_currents_units(cloud_a, cloud_b, c);
  return c;
}

Comparison run(const CloudView& cloud_a, const CloudView& cloud_b, const CompareOptions& options,
               const Context& context, Pair* scans) {
  Comparison c = begin(cloud_a, cloud_b, options);
  stages::Clock clock(c.timing, context);

  clock.start("project");
  Pair pair = project_pair(cloud_a, cloud_b, options.pose, options.project, context);
  c.frame = pair.frame;
  stages::check_changes(options, pair.frame);
  stages::describe_inputs(cloud_a, cloud_b, pair, c, context);
  const stages::AreaOfInterest area(c, context);
  const stages::MergedSpreads spreads = stages::merged_spreads(cloud_a, cloud_b, pair, options);
  stages::NodeSigmas sigmas = stages::sigmas_of_nodes(cloud_a, cloud_b, pair, options, context);
  stages::NodeWeight weight = stages::weight_of_nodes(cloud_a, cloud_b, pair, c);

  clock.start("delaunay");  // 1. T1, T2: O(n log n)
  triangulate(pair, context);

  stages::Common common = stages::locate(pair, options.locate, clock, context);                     // 2., 3.
  const stages::SmoothSurfaces smooth = stages::interpolate(pair, options.interpolation, context);  // 4.

  clock.start("border");  // what of its hull each scan supports
  stages::describe_meshes(pair, c);
  const stages::Borders borders = stages::find_borders(pair, spreads, area.domain(), c, context);
  if (scans != nullptr) *scans = stages::as_sampled(pair);
  const stages::Noise noise(std::move(sigmas), pair, options, context);
  const stages::Weighting weighting(std::move(weight), pair, options, context);
  stages::describe_points(cloud_a, cloud_b, pair, borders, c);
  noise.level_points(pair, c.fields_a, c.fields_b);
  const stages::PointCounts points = stages::points_of_nodes(pair, options);

  clock.start("detail");  // ρ_dV: T1, T2 and their locations are enough
  stages::measure_detail(pair, area.domain(), c, context);
  if (options.measure == MeasureKind::currents) {  // equations (4) and (5), of T1 and T2
    clock.start("currents");
    stages::measure_currents(pair, area.domain(), c, context);
  }
  OverOverlay over_overlay;
  if (options.surface != Surface::common) {  // 6. for the exact overlay, while T1 and T2 are there
    clock.start("overlay");
    over_overlay = measure_overlay(pair, area, noise, weighting, c, context);
  }
  NullDifferences unchanged;
  if (options.noise_floor) {  // from T1 and T2, each alone
    clock.start("noise_floor");
    unchanged = null_differences(pair.mesh(0), pair.mesh(1), context);
  }

  clock.start("merge");  // 5. theorem 2: T1 and T2 become T
  common = stages::unite_meshes(pair, std::move(common), options.locate, smooth[0].has_value(), context);
  const Array<double> weight_at_nodes = weighting.at(common.nodes);
  const NullDifference unchanged_at_nodes = stages::unite_unchanged(std::move(unchanged), common.nodes, c);
  c.cells = stages::make_cells(common, pair, borders, area.domain(), c, context);
  if (!noise.asked() && !options.changes.asked) common.nodes = {};

  clock.start("measure");  // 6. equation (7), cell by cell
  measure_common(area, borders, smooth, common.bounds, c, context);
  noise.describe(common.nodes, over_overlay.noise, c);
  weighting.describe(weight_at_nodes, over_overlay.weighted, c);
  stages::describe_changes(common.nodes, points, noise, c, context);
  if (options.noise_floor) c.noise_floor = noise_floor(c.cells.view(), unchanged_at_nodes, c.measures.volume, context);
  clock.stop();
  return c;
}

/// Whether a comparison takes less time than other threads need to wake up.
bool is_short(const CloudView& a, const CloudView& b, const CompareOptions& o) {
  constexpr std::size_t few_points = 10000;
  return a.points.size() + b.points.size() < few_points && o.surface == Surface::common && !o.noise_floor &&
         o.measure != MeasureKind::currents && o.weight.kind == WeightSource::Kind::none &&
         o.uncertainty.model == UncertaintyModel::none;
}

Comparison run_on_threads(const CloudView& a, const CloudView& b, const CompareOptions& options, const Context& context,
                          Pair* scans) {
  Comparison result;
  const auto work = [&] { result = run(a, b, options, context, scans); };
  if (is_short(a, b, options))
    run_alone(work);
  else
    run_with_threads(context, work);
  return result;
}

}  // namespace

void check(const CompareOptions& options) {
  stages::check_options(options);
  stages::check_uncertainty(options.uncertainty);
  stages::check_weight(options);
  stages::check_currents(options);
  stages::check_changes(options);
}

Comparison compare(const CloudView& a, const CloudView& b, const CompareOptions& options, const Context& context) {
  return run_on_threads(a, b, options, context, nullptr);
}

Comparison compare(const CloudView& a, const CloudView& b, const CompareOptions& options, const Context& context,
                   Pair& scans) {
  return run_on_threads(a, b, options, context, &scans);
}

}  // namespace isopach
