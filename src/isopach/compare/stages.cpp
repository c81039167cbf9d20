#include "isopach/compare/stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "isopach/base/median.hpp"
#include "isopach/base/memory.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/domain.hpp"
#include "isopach/delaunay/spanning_tree.hpp"
#include "isopach/measure/volume/totals.hpp"
#include "isopach/overlay/folds.hpp"
#include "isopach/overlay/hulls.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"
#include "isopach/overlay/localise_by_interface.hpp"
#include "isopach/overlay/merge.hpp"
#include "isopach/overlay/triangulate_union.hpp"

namespace isopach::stages {

namespace {

std::string name_of(const CloudView& cloud, const char* role) {
  return cloud.path.empty() ? std::string("scan ") + role : cloud.path;
}

bool is_pseudo_mercator(const std::string& crs) {
  return crs.find("3857") != std::string::npos || crs.find("Pseudo-Mercator") != std::string::npos ||
         crs.find("Popular Visualisation") != std::string::npos;
}

InputSummary summarise(const CloudView& cloud, const char* role, const Pose& pose, const HeightField& field) {
  InputSummary s = summarise_file(cloud, role);
  s.nodes = field.xy.size();
  s.cleaning = field.cleaning;
  s.bounds = reduce_blocks<Box3>(
      cloud.points.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Box3 box;
        const bool is_posed = !pose.is_identity();
        for (std::size_t i = begin; i < end; ++i)
          if (is_finite(cloud.points[i])) box.add(is_posed ? pose.apply(cloud.points[i]) : cloud.points[i]);
        return box;
      },
      [](Box3& total, const Box3& part) { total.add(part); });
  return s;
}

Array<Point2> hull_polygon(const Triangulation& t, std::span<const Point2> xy) {
  Array<Point2> polygon;
  for (const Index node : hull_nodes(t, xy)) polygon.push_back(xy[node]);
  return polygon;
}

// Cells that belong to what both scans sampled, but not to the domain.
FoldSummary left_out(const Comparison& c) { return c.options.folds == FoldRule::leave_out ? c.folds : FoldSummary{}; }

void warn_of_folds(Comparison& c) {
  constexpr double told = 0.02;
  if (!(c.folds.share > told)) return;
  const bool keeps = c.options.folds == FoldRule::keep;
  const double volume = c.measures.volume.absolute > 0 ? c.folds.volume.absolute / c.measures.volume.absolute : 0;
  c.warnings.push_back(fmt::format(
      "{:.2g} % of the area that both scans cover has several layers along the direction and is {}: another "
      "@direction, @crop or, of files with faces, @visible leaves one layer of it",
      100 * c.folds.share,
      keeps ? fmt::format("measured as it is triangulated, {:.2g} % of the absolute volume (@folds "
                          "leave-out leaves it out)",
                          100 * volume)
            : "left out of all figures (@folds keep measures it as it is triangulated)"));
}

// Of the union.
double area_of_both_footprints(const Borders& borders, const Comparison& c) {
  if (c.options.domain == DomainKind::hull) return c.domain_area;
  return borders.kept_area - (c.domain_area + left_out(c).area);
}

CurveNodes nodes_of(const Scan& s) { return {s.field.xy, s.field.keys}; }

// Without locations.
Common from_scratch(const Pair& pair, const Context& context) {
  Common common;
  common.nodes = unite(nodes_of(pair.scan[0]), nodes_of(pair.scan[1]));
  common.t = triangulate(common.nodes.xy, pair.frame.curve, context);
  return common;
}

// One flag per real triangle, as the overlay wants them; nothing where all are kept.
Array<unsigned char> kept_flags(const Footprint& f) {
  Array<unsigned char> kept(f.removed.size());
  for_each_index(kept.size(), [&](std::size_t i) { kept[i] = f.removed[i] == 0 ? 1 : 0; });
  return kept;
}

}  // namespace

void Clock::start(const std::string& stage) {
  stop();
  context_.step(stage, 0);
  stage_ = stage;
  since_ = Time::now();
}

void Clock::stop() {
  if (stage_.empty()) return;
  const double seconds = std::chrono::duration<double>(Time::now() - since_).count();
  timing_.stages.emplace_back(stage_, seconds);
  timing_.total += seconds;
  context_.step(stage_, 1);
  stage_.clear();
}

void check_options(const CompareOptions& options) {
  check_percentiles(options.percentiles);
  if (options.surface != Surface::common && options.domain == DomainKind::hull)
    throw UsageError(
        "@surface: the exact overlay ends where one of the surfaces does: leave @domain hull out, or take @surface "
        "common");
  if (options.surface != Surface::common && options.interpolation == Interpolation::cubic)
    throw UsageError(
        "@interpolation: the exact overlay is of two piecewise linear surfaces: take @surface common, or leave "
        "@interpolation cubic out");
  if (options.noise_floor && options.surface == Surface::overlay)
    throw UsageError(
        "@noise-floor: it is that of the common triangulation: take @surface common or both instead of overlay");
  if (options.noise_floor && options.interpolation != Interpolation::linear)
    throw UsageError("@noise-floor: it is that of linear interpolation: leave @interpolation cubic out");
  if (!(options.max_edge >= 0) || std::isinf(options.max_edge))
    throw UsageError(
        fmt::format("@max-edge: {} is no length, give one above 0 in the unit of x and y", options.max_edge));
  if (!(options.alpha >= 0) || std::isinf(options.alpha))
    throw UsageError(fmt::format("@alpha: {} is no radius, give one above 0 in the unit of x and y", options.alpha));
}

void check_units(const CloudView& a, const CloudView& b, const CompareOptions& options, Comparison& c) {
  for (const auto& [cloud, role] : {std::pair{&a, "A"}, std::pair{&b, "B"}}) {
    for (const std::string& note : cloud->notes) {  // readers that know the file's name have said it
      const std::string name = name_of(*cloud, role) + ": ";
      c.warnings.push_back(note.rfind(name, 0) == 0 ? note : name + note);
    }
    if (options.allow_crs) continue;
    if (cloud->unit == "deg")
      throw InputError(name_of(*cloud, role) +
                       ": x and y are degrees, so areas and volumes would mean nothing: project it to a metric CRS, or "
                       "pass @allow-crs");
    if (is_pseudo_mercator(cloud->crs))
      throw InputError(
          name_of(*cloud, role) +
          ": pseudo-Mercator stretches areas several times away from the equator: project it to a local CRS, "
          "or pass @allow-crs");
  }
  const auto differ = [](const std::string& p, const std::string& q, const std::string& none) {
    return p != none && q != none && p != q;
  };
  if (!options.allow_crs && options.unit.empty() && differ(a.unit, b.unit, "unknown"))
    throw InputError(name_of(b, "B") + ": its unit is " + b.unit + " but that of " + name_of(a, "A") + " is " + a.unit +
                     ": convert one, or say @unit to override both");
  if (!options.allow_crs && options.unit.empty() && differ(a.vertical_unit, b.vertical_unit, "unknown"))
    throw InputError(name_of(b, "B") + ": its heights are in " + b.vertical_unit + " but those of " + name_of(a, "A") +
                     " in " + a.vertical_unit + ": convert one, or say @unit to override both");
  if (differ(a.crs, b.crs, ""))
    c.warnings.push_back("the two files name their coordinate systems differently; they are compared as they stand");
  c.unit = !options.unit.empty() ? options.unit : (a.unit != "unknown" ? a.unit : b.unit);
  const std::string vertical = a.vertical_unit != "unknown" ? a.vertical_unit : b.vertical_unit;
  if (options.unit.empty() && c.unit != "unknown" && vertical != "unknown" && vertical != c.unit)
    c.warnings.push_back("heights are in " + vertical + " and x, y in " + c.unit + ": volumes are in " + vertical +
                         "·" + c.unit + "²");
}

InputSummary summarise_file(const CloudView& cloud, const char* role) {
  InputSummary s;
  s.role = role;
  s.path = cloud.path;
  s.format = cloud.format;
  s.unit = cloud.unit;
  s.vertical_unit = cloud.vertical_unit;
  s.crs = cloud.crs;
  s.points = cloud.points.size();
  return s;
}

void describe_inputs(const CloudView& cloud_a, const CloudView& cloud_b, const Pair& pair, Comparison& c,
                     const Context& context) {
  const HeightField &a = pair.scan[0].field, &b = pair.scan[1].field;
  c.a = summarise(cloud_a, "A", Pose{}, a);
  c.b = summarise(cloud_b, "B", c.options.pose, b);
  c.a.nodata = cloud_a.nodata;
  c.b.nodata = cloud_b.nodata;
  if (c.options.check_layers)
    both([&] { c.a.layered_share = layered_share(a, cloud_a, Pose{}, pair.frame, context); },
         [&] { c.b.layered_share = layered_share(b, cloud_b, c.options.pose, pair.frame, context); });
  warn_of_layers(c);
}

void warn_of_layers(Comparison& c) {
  for (const InputSummary* s : {&c.a, &c.b})
    if (s->layered_share > 0.02)
      c.warnings.push_back(
          fmt::format("{}: {:.0f} % of its area has several layers along the projection direction, so it is no height "
                      "field there: crop "
                      "it, choose another @direction, or filter by @class",
                      s->path.empty() ? "scan " + s->role : s->path, 100 * s->layered_share));
}

void describe_meshes(const Pair& pair, Comparison& c) {
  const Triangulation &t1 = pair.scan[0].t, &t2 = pair.scan[1].t;
  c.t1 = t1.real;
  c.t2 = t2.real;
  c.visited_1_in_2 = pair.seen[0].at.visited;
  c.visited_2_in_1 = pair.seen[1].at.visited;
  const Array<Point2> hull1 = hull_polygon(t1, pair.scan[0].field.xy), hull2 = hull_polygon(t2, pair.scan[1].field.xy);
  const double shared = shared_area(hull1, hull2);
  c.area_union = polygon_area(hull1) + polygon_area(hull2) - shared;
  if (c.options.domain != DomainKind::overlap) return;
  for (const auto& [t, s] : {std::pair{&t1, &c.a}, std::pair{&t2, &c.b}})
    if (t->real == 0)
      throw OverlapError((s->path.empty() ? "scan " + s->role : s->path) + ": " +
                         (t->nodes < 3 ? "fewer than 3 different points" : "all points lie on one line") +
                         ", so it covers no area to compare: use a scan of a surface, or @domain hull");
  if (!(shared > 0))
    throw OverlapError(
        "the scans do not overlap in the projection plane: check their coordinate systems, or match them first");
}

Common locate(Pair& pair, LocateMethod method, Clock& clock, const Context& context) {
  const Scan &a = pair.scan[0], &b = pair.scan[1];
  Common common;
  if (method == LocateMethod::tree) {
    clock.start("spanning_tree");  // from the Delaunay edges: O(n)
    std::array<SpanningTree, 2> trees;
    for_both([&](std::size_t k) { trees[k] = spanning_tree(pair.scan[k].t, pair.scan[k].field.xy, context); });

    clock.start("localise");  // theorem 1
    both([&] { pair.seen[0].at = localise(a.field.xy, trees[0], b.t, b.field.xy, context); },
         [&] { pair.seen[1].at = localise(b.field.xy, trees[1], a.t, a.field.xy, context); });
  } else if (method == LocateMethod::order) {
    clock.start("localise");  // along the curve instead: no tree
    both([&] { pair.seen[0].at = localise_in_order(a.field.xy, b.t, b.field.xy, context); },
         [&] { pair.seen[1].at = localise_in_order(b.field.xy, a.t, a.field.xy, context); });
  } else {
    clock.start("merge");  // T needs no locations when it is made from scratch
    common = from_scratch(pair, context);

    clock.start("localise");  // theorem 3: no tree
    MutualLocations found = localise_by_interface(common.nodes, common.t, a.t, a.field.xy, b.t, b.field.xy, context);
    pair.seen[0].at = std::move(found.of_1_in_2), pair.seen[1].at = std::move(found.of_2_in_1);
  }
  return common;
}

Common unite_meshes(Pair& pair, Common so_far, LocateMethod method, bool keep_meshes, const Context& context) {
  Common common = std::move(so_far);
  Scan &a = pair.scan[0], &b = pair.scan[1];
  for (Scan& s : pair.scan) Array<Index>().swap(s.field.node_of_point);  // what nobody asks for, before more is taken
  if (method != LocateMethod::interface) {
    common.nodes = unite(nodes_of(a), nodes_of(b));
    for (Scan& s : pair.scan) Array<std::uint64_t>().swap(s.field.keys);
    const auto make = method == LocateMethod::tree ? merge : triangulate_union;
    common.t = make({keep_meshes ? a.t : std::move(a.t), a.field.xy, &pair.seen[0].at},
                    {keep_meshes ? b.t : std::move(b.t), b.field.xy, &pair.seen[1].at}, common.nodes, pair.frame.curve,
                    context);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    Array<Index>().swap(pair.seen[k].at.id);
    if (keep_meshes) continue;
    pair.scan[k].t = {};
    Array<Point2>().swap(pair.scan[k].field.xy);
  }
  return common;
}

SmoothSurfaces interpolate(Pair& pair, Interpolation interpolation, const Context& context) {
  SmoothSurfaces smooth;
  for_both([&](std::size_t k) {
    const Scan &own = pair.scan[k], &other = pair.scan[1 - k];
    Seen& seen = pair.seen[k];
    if (interpolation == Interpolation::linear) {
      seen.z = isopach::interpolate(seen.at, own.field.xy, other.t, other.field.xy, other.field.z, context);
      return;
    }
    smooth[1 - k].emplace(other.t, other.field.xy, other.field.z, context);
    seen.z = smooth[1 - k]->at(seen.at, own.field.xy, context);
  });
  return smooth;
}

Borders find_borders(Pair& pair, const MergedSpreads& spreads, const Domain& domain, Comparison& c,
                     const Context& context) {
  const CompareOptions& options = c.options;
  const bool trim = options.border == BorderRule::trim, look = options.check_layers;
  const bool cuts = options.domain != DomainKind::hull;
  Borders borders;
  std::array<Footprint, 2> footprints;
  std::array<Folds, 2> folds;
  const auto margins_of = [&](const Footprint& f, std::size_t k) {
    return margins(f, pair.scan[k].t, pair.scan[k].field.xy, pair.seen[1 - k].at, context);
  };
  for_both([&](std::size_t k) {
    const HeightField& field = pair.scan[k].field;
    const Triangulation& t = pair.scan[k].t;
    const Asked& asked = pair.scan[k].asked;
    const double area = bounds_of(pair.frame).area;
    footprints[k] = footprint(t, field.xy, trim, {options.max_edge, options.alpha}, context,
                              {asked.border, area, asked.kept_elsewhere});
    borders.in[k] = margins_of(footprints[k], k);
    if (look && !spreads[k].is_raster)
      folds[k] = find_folds(t, field.xy, field.z, spreads[k].of_node, footprints[k], context, {asked.folds, area});
  });
  borders.kept_area = footprints[0].area + footprints[1].area;
  borders.removed_area = footprints[0].removed_area + footprints[1].removed_area;
  if (folds[0].any() || folds[1].any()) {
    c.folds.share_a = folds[0].any() ? folds[0].area / footprints[0].area : 0;
    c.folds.share_b = folds[1].any() ? folds[1].area / footprints[1].area : 0;
    borders.left_out = options.folds == FoldRule::leave_out;
    borders.single.emplace();
    for_both([&](std::size_t k) {
      Footprint single = without(footprints[k], folds[k]);
      (*borders.single)[k] = margins_of(single, k);
      if (cuts) borders.sides[k] = border_sides(pair.scan[k].t, footprints[k], &single);
      if (borders.left_out) footprints[k] = std::move(single);
      pair.scan[k].folded = std::move(folds[k].folded);
    });
  } else if (cuts) {
    for_both([&](std::size_t k) { borders.sides[k] = border_sides(pair.scan[k].t, footprints[k], nullptr); });
  }
  for (std::size_t k = 0; k < 2; ++k) pair.scan[k].kept = kept_flags(footprints[k]);
  if (!domain.is_everything()) cut_borders(pair, domain, borders, c, context);
  return borders;
}

void find_footprints(Pair& pair, const CompareOptions& options, const Context& context) {
  for_both([&](std::size_t k) {
    Scan& s = pair.scan[k];
    s.kept = kept_flags(
        footprint(s.t, s.field.xy, options.border == BorderRule::trim, {options.max_edge, options.alpha}, context));
  });
}

Array<unsigned char> compared_nodes(const Pair& pair, const Borders& borders, std::size_t k) {
  const Margin &in_other = borders.measured(1 - k).other, &own = borders.in[k].own;
  Array<unsigned char> compared(pair.scan[k].field.xy.size());
  for_each_index(compared.size(), [&](std::size_t i) {
    const auto node = static_cast<Index>(i);
    const bool in_fold = borders.left_out && own.side[node] != Side::outside &&  // with all of its triangles
                         (*borders.single)[k].own.side[node] == Side::outside;
    compared[i] = in_other.covers(node) && !in_fold ? 1 : 0;
  });
  return compared;
}

namespace {

std::size_t count_points(const HeightField& field, const Array<unsigned char>& of_node) {
  return reduce_blocks<std::size_t>(
      field.node_of_point.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        std::size_t count = 0;
        for (std::size_t i = begin; i < end; ++i)
          count += field.node_of_point[i] != no_index && of_node[field.node_of_point[i]] != 0 ? 1 : 0;
        return count;
      },
      [](std::size_t& total, std::size_t count) { total += count; });
}

}  // namespace

void describe_points(const CloudView& cloud_a, const CloudView& cloud_b, const Pair& pair, const Borders& borders,
                     Comparison& c) {
  const auto describe = [&](std::size_t k, const CloudView& cloud, const Pose& pose, PointFields& f) {
    const HeightField& field = pair.scan[k].field;
    const Array<unsigned char> compared = compared_nodes(pair, borders, k);
    c.compared_points[k] = count_points(field, compared);
    if (!c.options.keep_points) return;
    f.dz_signed.resize(cloud.points.size());
    for_each_index(cloud.points.size(), [&](std::size_t i) {
      const Index node = field.node_of_point[i];
      if (node == no_index || compared[node] == 0) {
        f.dz_signed[i] = std::numeric_limits<double>::quiet_NaN();
        return;
      }
      const Point3 p = pose.is_identity() ? cloud.points[i] : pose.apply(cloud.points[i]);
      const double height = pair.frame.to_field(p).z, other = pair.seen[k].z[node];
      f.dz_signed[i] = k == 0 ? other - height : height - other;
    });
  };
  describe(0, cloud_a, Pose{}, c.fields_a);
  describe(1, cloud_b, c.options.pose, c.fields_b);
}

namespace {

// Says, before it begins, where the overlay is out of proportion to the scans, and refuses what memory does not hold.
void announce_size(const Overlay& overlay, Comparison& c, const Context& context) {
  constexpr double many = 3e6, many_a_node = 100;
  constexpr double bytes_a_cell = 250;  // of the overlay as one mesh, while it is made
  const double cells = overlay.estimated_cells(context);
  const double memory = bytes_a_cell * cells;
  if (const std::uint64_t usable = usable_memory(); c.options.keep_overlay && memory > static_cast<double>(usable))
    throw InputError(fmt::format(
        "the overlay of the two scans has about {:.0f} million cells, and to keep them needs about {}, of which {} "
        "can be used: leave them out with @no-cells, or use @surface common",
        1e-6 * cells, bytes_in_words(static_cast<std::uint64_t>(memory)), bytes_in_words(usable)));
  if (cells < many || cells < many_a_node * static_cast<double>(c.a.nodes + c.b.nodes)) return;
  context.step(fmt::format("overlay of about {:.0f} million cells", 1e-6 * cells), 0);
  c.warnings.push_back(fmt::format(
      "the overlay of the two scans has about {:.0f} million cells, {:.0f} for each node, because long thin triangles "
      "of both cross one another: @surface common takes a small part of the time, and @max-edge leaves such "
      "triangles out",
      1e-6 * cells, cells / static_cast<double>(c.a.nodes + c.b.nodes)));
}

}  // namespace

void measure_overlay(const OverlayCells& cells, const AreaOfInterest& area, Comparison& c, const Context& context) {
  announce_size(cells.overlay, c, context);
  if (c.options.surface == Surface::both)
    c.overlay = sum_up(cells, context);
  else
    c.measures = measure(cells, context, c.options.percentiles);
  if (c.options.keep_overlay) c.overlay_surface = surface_of(cells, context);
  if (c.options.surface == Surface::overlay) area.fill_budget(cells, c, context);
}

void measure_detail(const Pair& pair, const Domain& domain, Comparison& c, const Context& context) {
  const std::optional<SumBounds> bounds = pair.frame.box.empty() ? std::nullopt : std::optional(bounds_of(pair.frame));
  c.detail = detail_measure(pair.mesh(0), pair.mesh(1), c.options.domain == DomainKind::hull, domain, context, bounds);
  check_detail(domain, c);
}

void check_detail(const Domain& domain, const Comparison& c) {
  if (!c.detail && c.options.measure == MeasureKind::dV)
    throw OverlapError(
        fmt::format("@measure dV: no triangle of the coarser scan lies in the area of the finer one{}: leave @measure "
                    "out, or take scans that share more area",
                    !domain.is_everything() ? " and of @include, @exclude and @mask" : ""));
}

void describe_domain(const Borders& borders, Comparison& c) {
  constexpr double least_single = 0.01;  // less is the rims of folds
  c.domain_area = c.measures.area;
  if (left_out(c).area > 0 && !(c.domain_area > least_single * (c.domain_area + left_out(c).area)))
    throw OverlapError(
        "all but a hundredth of the area that the scans share has several layers along the direction, so it is no "
        "height field: choose another @direction, keep one layer by @class or @crop, or measure it as it is with "
        "@folds "
        "keep");
  if (!(c.domain_area > 0) && c.trimmed_area > 0)
    throw OverlapError(
        "no part of the area that the scans share is sampled densely enough by both: every triangle was trimmed; use "
        "@border hull, or a larger @max-edge or @alpha");
  if (!(c.domain_area > 0))
    throw OverlapError(
        "the common area of the scans holds no cell to measure: they touch, overlap in a sliver only, or all points "
        "lie on one line");
  if (borders.removed_area > 0) c.area_union = area_of_both_footprints(borders, c);
  const FoldSummary out = left_out(c);
  if (c.folds.area > 0) c.folds.share = std::min(1.0, c.folds.area / (c.domain_area + out.area));
  c.trimmed_area /= c.domain_area + out.area + c.trimmed_area;
  const double untrimmed_volume = c.measures.volume.absolute + out.volume.absolute + c.trimmed_volume;
  if (untrimmed_volume > 0) c.trimmed_volume /= untrimmed_volume;
  if (!(c.area_union > 0)) c.area_union = c.domain_area;  // two lines span a hull but cover nothing themselves
  c.coverage = std::min(1.0, c.domain_area / c.area_union);
  warn_of_folds(c);
  if (c.coverage < c.options.min_coverage)
    throw OverlapError(
        fmt::format("coverage is {:.6g}, below the {:.6g} that @min-coverage requires: the scans share too little area",
                    c.coverage, c.options.min_coverage));
}

}  // namespace isopach::stages
