// THE PAGE: the algorithm A_ρ, one stage a line.
//
// [Dyshkant2013], section 3.2; measure: equation (7). See docs/method/method.md.
#include "isopach/compare/compare.hpp"

#include <optional>
#include <utility>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/check.hpp"
#include "isopach/compare/currents.hpp"
#include "isopach/compare/domain.hpp"
#include "isopach/compare/noise.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/compare/weighting.hpp"
#include "isopach/delaunay/spanning_tree.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/measure/bend.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"
#include "isopach/overlay/localise_by_interface.hpp"
#include "isopach/overlay/smooth.hpp"

namespace isopach {

namespace {

Comparison run(const Cloud& cloud_a, const Cloud& cloud_b, const CompareOptions& options, const Context& context,
               ScanMeshes* meshes) {
  Comparison c;
  c.options = options;
  check(options);
  stages::check_units(cloud_a, cloud_b, options, c);
  stages::check_currents_units(cloud_a, cloud_b, c);
  stages::Clock clock(c.timing, context);

  clock.start("project");
  c.frame = choose_frame(cloud_a, cloud_b, options.pose, options.project, context);
  HeightField a, b;
  both([&] { a = project(cloud_a, Pose{}, c.frame, options.project, context); },
       [&] { b = project(cloud_b, options.pose, c.frame, options.project, context); });
  stages::describe_inputs(cloud_a, cloud_b, a, b, c, context);
  const stages::AreaOfInterest area(options, !cloud_a.crs.empty() ? cloud_a.crs : cloud_b.crs,
                                    2 * (a.xy.size() + b.xy.size()), c, context);
  const stages::MergedSpreads spreads = stages::merged_spreads(cloud_a, cloud_b, a, b, c);
  stages::Noise noise(options, context);
  noise.take_sigmas(cloud_a, cloud_b, a, b);
  stages::Weighting weighting(options, context);
  weighting.take_points(cloud_a, cloud_b, a, b, c);

  clock.start("delaunay");  // 1. T1, T2: O(n log n)
  Triangulation t1, t2;
  both([&] { t1 = triangulate(a.xy, c.frame.curve, context); },
       [&] { t2 = triangulate(b.xy, c.frame.curve, context); });

  Locations a_in_2, b_in_1;
  stages::Common common;
  if (options.locate == LocateMethod::tree) {
    clock.start("spanning_tree");  // 2. from the Delaunay edges: O(n)
    SpanningTree tree1, tree2;
    both([&] { tree1 = spanning_tree(t1, a.xy, context); }, [&] { tree2 = spanning_tree(t2, b.xy, context); });

    clock.start("localise");  // 3. theorem 1
    both([&] { a_in_2 = localise(a.xy, tree1, t2, b.xy, context); },
         [&] { b_in_1 = localise(b.xy, tree2, t1, a.xy, context); });
  } else if (options.locate == LocateMethod::order) {
    clock.start("localise");  // 3. along the curve instead: no tree
    both([&] { a_in_2 = localise_in_order(a.xy, t2, b.xy, context); },
         [&] { b_in_1 = localise_in_order(b.xy, t1, a.xy, context); });
  } else {
    clock.start("merge");  // 5. first: T needs no locations when it is made from scratch
    common = stages::triangulate_common(a, b, c.frame, context);

    clock.start("localise");  // 3. theorem 3: no tree
    MutualLocations found = localise_by_interface(common.nodes, common.t, t1, a.xy, t2, b.xy, context);
    a_in_2 = std::move(found.of_1_in_2), b_in_1 = std::move(found.of_2_in_1);
  }

  // 4. interpolation, as a part of "localise"
  Array<double> f2_at_a, f1_at_b;
  const bool bends = options.interpolation == Interpolation::cubic;
  std::optional<SmoothSurface> smooth_1, smooth_2;  // they live as long as T1, T2, a and b
  if (bends)
    both([&] { f2_at_a = smooth_2.emplace(t2, b.xy, b.z, context).at(a_in_2, a.xy, context); },
         [&] { f1_at_b = smooth_1.emplace(t1, a.xy, a.z, context).at(b_in_1, b.xy, context); });
  else
    both([&] { f2_at_a = interpolate(a_in_2, a.xy, t2, b.xy, b.z, context); },
         [&] { f1_at_b = interpolate(b_in_1, b.xy, t1, a.xy, a.z, context); });

  clock.start("border");  // what of its hull each scan supports
  stages::describe_meshes(t1, t2, a, b, a_in_2, b_in_1, c);
  stages::Borders borders = stages::find_borders(t1, t2, a, b, a_in_2, b_in_1, spreads, c, context);
  if (area.clip() != nullptr) stages::clip_borders(t1, t2, a, b, *area.clip(), borders, c, context);
  if (meshes != nullptr) *meshes = stages::meshes_of(c, a, b, t1, t2, borders);
  const stages::NodesLeftOut left_out = stages::nodes_in_folds(borders);
  c.fields_a = stages::point_fields(cloud_a, Pose{}, c.frame, a, borders.measured_2().other, f2_at_a, -1, left_out.a);
  c.fields_b =
      stages::point_fields(cloud_b, options.pose, c.frame, b, borders.measured_1().other, f1_at_b, +1, left_out.b);

  const OverlayMesh mesh_1{t1, a.xy, a.z, a_in_2, f2_at_a, borders.kept_1};
  const OverlayMesh mesh_2{t2, b.xy, b.z, b_in_1, f1_at_b, borders.kept_2};
  noise.take_meshes(mesh_1, mesh_2, c.frame);
  weighting.take_meshes(mesh_1, mesh_2);
  noise.level_points(a, b, c.fields_a, c.fields_b);

  clock.start("detail");  // ρ_dV: T1, T2 and their locations are enough
  stages::measure_detail(mesh_1, mesh_2, area.clip(), c, context);
  if (options.measure == MeasureKind::currents) {  // equations (4) and (5), of T1 and T2
    clock.start("currents");
    stages::measure_currents(mesh_1, mesh_2, area.clip(), c, context);
  }

  if (options.surface != Surface::common) {  // 6. for the exact overlay, while T1 and T2 are there
    clock.start("overlay");
    const Overlay overlay(mesh_1, mesh_2, context);
    stages::measure_overlay(overlay, area, c, context);
    noise.level_overlay(overlay, mesh_1, mesh_2, area.clip(), c);
    if (options.surface == Surface::overlay) {
      noise.take_overlay(overlay, mesh_1, mesh_2, area.clip());
      if (weighting.asked()) weighting.take_overlay(overlay, mesh_1, mesh_2, area.clip());
    }
  }

  NullDifferences unchanged;
  if (options.noise_floor) {  // from T1 and T2, each alone
    clock.start("noise_floor");
    unchanged = null_differences(mesh_1, mesh_2, context);
  }

  clock.start("merge");
  if (options.locate == LocateMethod::tree)  // 5. theorem 2: T1 and T2 become T
    common = stages::merge_common(bends ? t1 : std::move(t1), bends ? t2 : std::move(t2), a, b, a_in_2, b_in_1, c.frame,
                                  context);
  if (!bends) t1 = {}, t2 = {};
  for (Array<Index>* done : {&a.node_of_point, &b.node_of_point, &a_in_2.id, &b_in_1.id}) Array<Index>().swap(*done);
  if (options.locate == LocateMethod::order)  // 5. the same from scratch
    common = stages::triangulate_common(a, b, c.frame, context);
  noise.take_union(common.nodes);
  weighting.take_union(common.nodes);
  NullDifference unchanged_at_nodes;
  if (options.noise_floor) {
    unchanged_at_nodes = unite(std::exchange(unchanged, {}), common.nodes);
    stages::warn_of_shared_nodes(common.nodes, c);
  }
  c.cells = stages::make_cells(std::move(common), bends ? a : std::move(a), bends ? b : std::move(b), a_in_2, b_in_1,
                               borders, f2_at_a, f1_at_b, area.clip(), c);

  clock.start("measure");  // 6. equation (7), cell by cell
  area.clip_cells(c, context);
  const CellView cells = c.cells.view();
  if (options.surface != Surface::overlay) {
    c.measures = measure(cells, context, options.percentiles);
    area.fill_budget(c, context);
  }
  stages::describe_domain(cells, borders, c);
  if (bends) c.measures.error_estimate = bend_error(cells, *smooth_1, *smooth_2, context).bound / c.domain_area;
  noise.describe(c);
  weighting.describe(c);
  if (options.noise_floor) c.noise_floor = noise_floor(cells, unchanged_at_nodes, c.measures.volume, context);
  clock.stop();
  return c;
}

}  // namespace

void check(const CompareOptions& options) {
  stages::check_options(options);
  stages::check_uncertainty(options.uncertainty);
  stages::check_weight(options);
  stages::check_currents(options);
}

Comparison compare(const Cloud& a, const Cloud& b, const CompareOptions& options, const Context& context) {
  Comparison result;
  run_with_threads(context.threads, [&] { result = run(a, b, options, context, nullptr); });
  return result;
}

Comparison compare(const Cloud& a, const Cloud& b, const CompareOptions& options, const Context& context,
                   ScanMeshes& meshes) {
  Comparison result;
  run_with_threads(context.threads, [&] { result = run(a, b, options, context, &meshes); });
  return result;
}

}  // namespace isopach
