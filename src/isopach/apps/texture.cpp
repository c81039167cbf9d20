#include "isopach/apps/texture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "isopach/apps/heights_below.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/distance/point_tree.hpp"
#include "isopach/measure/texture/form.hpp"
#include "isopach/measure/texture/gaussian_filter.hpp"
#include "isopach/overlay/folds.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double least_cutoff = 2, poor_cutoff = 5;  // spacings: below, no filter at all; one that is short of points
constexpr unsigned cubic_pieces = 3;  // each triangle is cut into 9: chords take a ninth of what they took

/// Every quantity by node. `node_of_point` leads from the points of the file.
struct SurfaceScan {
  MatchSurface s;
  Array<Index> node_of_point;
  Array<double> below;  ///< height of the reference; empty without
  Folds folds;          ///< left out of the footprint of s, unless they are to be kept
};

InputSummary summary(const CloudView& cloud, const char* role, const Pose& pose, const Frame& frame,
                     const HeightField& field, const RoughnessOptions& options, std::vector<std::string>& warnings,
                     const Context& context) {
  InputSummary s = stages::summarise_file(cloud, role);
  s.nodes = field.xy.size();
  s.cleaning = field.cleaning;
  s.nodata = cloud.nodata;
  for (const Point3& p : cloud.points)
    if (is_finite(p)) s.bounds.add(pose.apply(p));
  if (!options.compare.check_layers) return s;
  s.layered_share = layered_share(field, cloud, pose, frame, context);
  if (s.layered_share > 0.02)
    warnings.push_back(
        fmt::format("{}: {:.0f} % of its area has several layers along the direction, so it is no height field there: "
                    "crop it or choose another @direction",
                    cloud.path.empty() ? role : cloud.path, 100 * s.layered_share));
  return s;
}

/// Only nodes with keep(i); ids of points follow.
template <class Keep>
void thin_out(Array<Point2>& xy, Array<double>& z, Array<double>& below, Array<Index>& node_of_point, Keep&& keep) {
  Array<Index> now(xy.size());
  std::size_t n = 0;
  for (std::size_t i = 0; i < xy.size(); ++i) {
    now[i] = keep(i) ? static_cast<Index>(n) : no_index;
    if (!keep(i)) continue;
    xy[n] = xy[i], z[n] = z[i];
    if (!below.empty()) below[n] = below[i];
    ++n;
  }
  xy.resize(n), z.resize(n);
  if (!below.empty()) below.resize(n);
  for (Index& id : node_of_point)
    if (id != no_index) id = now[id];
}

/// Nodes in folds stay without a facet, so that nothing is fitted to them.
void find_folds_of(SurfaceScan& scan, const RoughnessOptions& options, const Context& context) {
  if (!options.compare.check_layers) return;
  MatchSurface& s = scan.s;
  scan.folds = find_folds(s.t, s.xy, s.z, {}, s.footprint, context);
  if (!scan.folds.any() || options.compare.folds == FoldRule::keep) return;
  Array<unsigned char> kept(s.t.real);
  for_each_index(kept.size(), [&](std::size_t i) {
    const auto t = static_cast<Index>(i);
    kept[i] = s.footprint.keeps(t) && !scan.folds.holds(t) ? 1 : 0;
  });
  if (std::all_of(kept.begin(), kept.end(), [](unsigned char k) { return k == 0; }))
    throw OverlapError(
        "all of the scan has several layers along the direction, so no part of it is a height field: choose another "
        "@direction, keep one layer by @class or @crop, or take it as it is with @folds keep");
  s = make_surface(std::move(s.xy), std::move(s.z), std::move(s.t), kept);
}

/// The scan's surface, without nodes that the reference does not know and those no kept triangle has.
SurfaceScan make_scan(HeightField field, const CloudView& cloud, const Frame& frame, const MatchSurface* reference,
                      const RoughnessOptions& options, const Context& context) {
  SurfaceScan scan;
  scan.node_of_point = std::move(field.node_of_point);
  Array<Point2> xy = std::move(field.xy);
  Array<double> z = std::move(field.z);
  if (reference != nullptr) {
    scan.below = heights_below(xy, *reference, context);
    const Array<double> known = scan.below;
    thin_out(xy, z, scan.below, scan.node_of_point, [&](std::size_t i) { return !std::isnan(known[i]); });
    if (xy.empty()) throw OverlapError("@reference: lies nowhere under the scan: put it in place, or let @match do so");
  }
  const bool trim = options.compare.border == BorderRule::trim;
  for (int pass = 0; pass < 2; ++pass) {
    scan.s = make_surface(std::move(xy), std::move(z), frame.curve, trim, options.compare.max_edge, context);
    const Array<double> weight = scan.s.weight;
    if (std::all_of(weight.begin(), weight.end(), [](double w) { return w > 0; })) break;
    xy = std::move(scan.s.xy), z = std::move(scan.s.z);
    thin_out(xy, z, scan.below, scan.node_of_point, [&](std::size_t i) { return weight[i] > 0; });
    if (xy.empty())
      throw InputError(cloud_name(cloud) +
                       ": its points cover no area along the direction: choose another @direction, or @border hull");
    if (pass == 1)  // what a second look leaves out has no weight and stays
      scan.s = make_surface(std::move(xy), std::move(z), frame.curve, trim, options.compare.max_edge, context);
  }
  find_folds_of(scan, options, context);
  return scan;
}

double total(std::span<const double> area) {
  Sum sum;
  for (const double a : area) sum.add(a);
  return sum.value();
}

double root_mean_square(std::span<const double> area, std::span<const double> value) {
  Sum sum, weighted;
  for (std::size_t i = 0; i < area.size(); ++i)
    if (area[i] > 0) sum.add(area[i]), weighted.add(area[i] * value[i]);
  const double mean = weighted.value() / sum.value();
  Sum squares;
  for (std::size_t i = 0; i < area.size(); ++i)
    if (area[i] > 0) squares.add(area[i] * (value[i] - mean) * (value[i] - mean));
  return std::sqrt(squares.value() / sum.value());
}

/// Triangles that are evaluated: those of the footprint without a corner nearer than `margin` to its rim.
Array<unsigned char> evaluated(const MatchSurface& s, double margin) {
  Array<unsigned char> rim(s.xy.size()), kept(s.t.real);
  std::fill(rim.begin(), rim.end(), static_cast<unsigned char>(0));
  const auto keeps = [&](Index t) { return !s.t.is_ghost(t) && s.footprint.keeps(t); };
  for (Index i = 0; i < s.t.real; ++i)
    for (Index side = 0; side < 3; ++side)
      if (keeps(i) && !keeps(triangle_of(s.t.triangles[i].n[side])))
        rim[s.t.triangles[i].v[side]] = rim[s.t.triangles[i].v[next_side(side)]] = 1;
  Array<unsigned char> near(s.xy.size());
  std::fill(near.begin(), near.end(), static_cast<unsigned char>(0));
  if (margin > 0) {
    Array<Point3> places;
    for (std::size_t i = 0; i < s.xy.size(); ++i)
      if (rim[i] != 0) places.push_back({s.xy[i].x, s.xy[i].y, 0});
    if (!places.empty()) {
      const PointTree tree(places);
      for_each_index(s.xy.size(), [&](std::size_t i) {
        near[i] = tree.nearest_distance2({s.xy[i].x, s.xy[i].y, 0}) < margin * margin ? 1 : 0;
      });
    }
  }
  for_each_index(s.t.real, [&](std::size_t i) {
    const auto& v = s.t.triangles[i].v;
    kept[i] = s.footprint.keeps(static_cast<Index>(i)) && near[v[0]] == 0 && near[v[1]] == 0 && near[v[2]] == 0 ? 1 : 0;
  });
  return kept;
}

Array<double> shares(const MatchSurface& s, std::span<const unsigned char> kept) {
  Array<double> area(s.xy.size());
  std::fill(area.begin(), area.end(), 0.0);
  for (Index i = 0; i < s.t.real; ++i) {
    if (kept[i] == 0) continue;
    const auto& v = s.t.triangles[i].v;
    const double third = triangle_area(s.xy[v[0]], s.xy[v[1]], s.xy[v[2]]) / 3;
    for (const Index node : v) area[node] += third;
  }
  return area;
}

void check_cutoff(double cutoff, double spacing, const char* option, const std::string& role,
                  std::vector<std::string>& warnings) {
  if (cutoff == 0) return;
  if (cutoff < least_cutoff * spacing)
    throw UsageError(fmt::format("{}: {} is below {} times the spacing of the points, {:.3g}: give a longer cut-off",
                                 option, cutoff, least_cutoff, spacing));
  if (cutoff < poor_cutoff * spacing)
    warnings.push_back(
        fmt::format("{} of {} is only {:.1f} times the spacing of the points of {}: the filter is coarse", option,
                    cutoff, cutoff / spacing, role));
}

Array<double> less(std::span<const double> a, std::span<const double> b) {
  Array<double> out(a.size());
  for_each_index(out.size(), [&](std::size_t i) { out[i] = a[i] - b[i]; });
  return out;
}

/// Over the evaluated cells; the surface under them stays as it is.
Measures distribution(Cells& cells, std::span<const double> relief, const Context& context) {
  for_each_index(cells.z1.size(), [&](std::size_t i) { cells.z2[i] = cells.z1[i] + relief[i]; });
  return measure(cells.view(), context);
}

void point_fields(const SurfaceScan& scan, std::span<const double> area, std::span<const double> waviness,
                  std::span<const double> rough, Texture& x) {
  const std::size_t n = scan.node_of_point.size();
  Array<double> number(scan.s.xy.size());
  std::fill(number.begin(), number.end(), 0.0);
  for (std::size_t k = 0; k < x.wrinkles.all.size(); ++k)
    for (const Index i : x.wrinkles.all[k].nodes) number[i] = static_cast<double>(k + 1);
  const auto field = [&](const char* name, std::span<const double> of_node) {
    Attribute a{name, Array<double>(n)};
    for_each_index(n, [&](std::size_t i) {
      const Index node = scan.node_of_point[i];
      a.values[i] = node == no_index || !(area[node] > 0) ? nan : of_node[node];
    });
    x.fields.push_back(std::move(a));
  };
  field("waviness", waviness), field("roughness", rough), field("valley", x.valley), field("wrinkle", number);
}

/// Where most of the relief is a curved form, the depth that it sets for wrinkles hides them.
void check_depth(const MatchSurface& s, std::span<const double> area, const Texture& x, const RoughnessOptions& o,
                 const std::string& role, std::vector<std::string>& warnings, const Context& context) {
  const bool removed = o.l_filter > 0 || (o.form == FormKind::polynomial && o.degree > 1);
  if (o.wrinkles.depth > 0 || removed) return;
  const Form curved = fit_form(s.xy, area, x.valley, 2, context);
  Array<double> left(x.valley.size());
  for_each_index(left.size(), [&](std::size_t i) { left[i] = x.valley[i] - curved.at(s.xy[i]); });
  if (nmad(left, area) >= nmad(x.valley, area) / 2) return;
  warnings.push_back(fmt::format(
      "most of the heights of {} are a curved form, which sets the depth that wrinkles need, {:.3g}: remove it "
      "with @form polynomial or @l-filter, or give @wrinkle-depth",
      role, x.wrinkles.depth));
}

}  // namespace

MatchSurface reference_surface(const CloudView& reference, const Pose& pose, const Frame& frame,
                               const RoughnessOptions& options, const Context& context) {
  ProjectOptions project_options = options.compare.project;
  project_options.crop.reset();  // of the scan
  HeightField field = project(reference, pose, frame, project_options, context);
  Box2 bounds;
  for (const Point2& p : field.xy) bounds.add(p);
  const CurveBox box = curve_box(bounds);
  Array<Point2> sorted;
  const Array<Index> order = curve_order(field.xy, box, nullptr, &sorted);
  Array<double> z(sorted.size());
  for_each_index(z.size(), [&](std::size_t i) { z[i] = field.z[order[i]]; });
  return make_surface(std::move(sorted), std::move(z), box, options.compare.border == BorderRule::trim,
                      options.compare.max_edge, context);
}

Texture texture(const CloudView& cloud, const char* role, const Pose& pose, const Frame& frame,
                const MatchSurface* reference, const RoughnessOptions& o, std::vector<std::string>& warnings,
                const Context& context) {
  Texture x;
  HeightField field = project(cloud, pose, frame, o.compare.project, context);
  x.input = summary(cloud, role, pose, frame, field, o, warnings, context);
  const SurfaceScan scan = make_scan(std::move(field), cloud, frame, reference, o, context);
  const MatchSurface& s = scan.s;
  const std::span<const double> area = s.weight;
  x.area = total(area);
  const bool left_out = scan.folds.any() && o.compare.folds == FoldRule::leave_out;
  x.folded_area = scan.folds.area;
  x.folded_share = scan.folds.area / (x.area + (left_out ? scan.folds.area : 0));
  const auto nodes = left_out ? std::count_if(area.begin(), area.end(), [](double share) { return share > 0; })
                              : static_cast<std::ptrdiff_t>(s.xy.size());
  x.spacing = std::sqrt(x.area / static_cast<double>(nodes));
  check_cutoff(o.s_filter, x.spacing, "@s-filter", role, warnings);
  check_cutoff(o.l_filter, x.spacing, "@l-filter", role, warnings);

  // S-filter, form, L-filter
  Array<double> heights = scan.below.empty() ? s.z : less(s.z, scan.below);
  if (o.s_filter > 0) heights = gaussian_mean(s.xy, area, heights, {o.s_filter, o.filter_degree}, context);
  Array<double> removed(heights.size());
  std::fill(removed.begin(), removed.end(), 0.0);
  if (o.form == FormKind::plane || o.form == FormKind::polynomial) {
    const Form form = fit_form(s.xy, area, heights, o.form == FormKind::plane ? 1 : o.degree, context);
    for_each_index(removed.size(), [&](std::size_t i) { removed[i] = form.at(s.xy[i]); });
    x.form = form.coefficients;
  }
  x.form_sq = root_mean_square(area, scan.below.empty() ? removed : scan.below);
  const Array<double> formless = less(heights, removed);
  Array<double> waviness(heights.size()), level(heights.size());
  std::fill(waviness.begin(), waviness.end(), 0.0);
  level = waviness;
  if (o.l_filter > 0) {
    level = robust_gaussian_mean(s.xy, area, formless, {o.l_filter, o.filter_degree}, context);
    waviness = o.filter == MeanFilter::robust
                   ? level
                   : gaussian_mean(s.xy, area, formless, {o.l_filter, o.filter_degree}, context);
    x.waviness_sq = root_mean_square(area, waviness);
  }
  Array<double> rough = less(formless, waviness);
  x.valley = less(formless, level);
  for (Array<double>* values : {&rough, &x.valley})  // of nodes that nothing supports
    for (double& v : *values)
      if (!std::isfinite(v)) v = 0;

  x.margin = o.margin >= 0 ? o.margin : o.l_filter / 2;
  x.cells.in_domain = evaluated(s, x.margin);
  const Array<double> share = shares(s, x.cells.in_domain);
  const unsigned pieces = o.interpolation == Interpolation::cubic ? cubic_pieces : 1;
  x.parameters = areal_parameters(refined(s.t, s.xy, rough, x.cells.in_domain, pieces, context), context);
  if (!(x.parameters.area > 0))
    throw UsageError(fmt::format("@margin: {} from the rim leaves nothing of {} to evaluate: give a smaller one",
                                 x.margin, cloud.path.empty() ? role : cloud.path));
  x.wrinkles = find_wrinkles(s.t, s.xy, s.z, x.valley, x.cells.in_domain, share, o.wrinkles, context);
  check_depth(s, area, x, o, cloud.path.empty() ? role : cloud.path, warnings, context);
  point_fields(scan, share, waviness, rough, x);

  x.cells.xy = s.xy, x.cells.z1 = x.cells.z2 = s.z, x.cells.triangulation = s.t;
  x.valleys = distribution(x.cells, x.valley, context);
  x.relief = distribution(x.cells, rough, context);
  return x;
}

std::vector<LineDepth> follow_wrinkles(const Texture& of, const Texture& in, const Context& context) {
  std::vector<LineDepth> out;
  const Cells& cells = in.cells;
  std::vector<unsigned char> evaluated_node(cells.xy.size(), 0);
  for (Index i = 0; i < cells.triangulation.real; ++i)
    for (const Index node : cells.triangulation.triangles[i].v)
      if (cells.in_domain[i] != 0) evaluated_node[node] = 1;
  for (const Wrinkle& w : of.wrinkles.all) {
    Array<Point2> places;
    for (const Index i : w.nodes) places.push_back(of.cells.xy[i]);
    const Locations where = localise_in_order(places, cells.triangulation, cells.xy, context);
    Array<double> relief = interpolate(where, places, cells.triangulation, cells.xy, in.valley, context);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Location at = where[k];
      const bool inside = at.kind == Location::Kind::triangle ? cells.in_domain[at.id] != 0
                          : at.kind == Location::Kind::edge
                              ? cells.in_domain[triangle_of(at.id)] != 0
                              : at.kind == Location::Kind::node && evaluated_node[at.id] != 0;
      if (!inside) relief[k] = nan;
    }
    out.push_back(depth_along(w, relief));
  }
  return out;
}

}  // namespace isopach
