#include "isopach/distance/distance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/distance/point_tree.hpp"
#include "isopach/distance/surface_tree.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t query_block = 256;
constexpr Point3 up{0, 0, 1};

/// A scan on its way through the measures.
struct PosedScan {
  HeightField field;
  ScanPoints kept;
  Mesh mesh;
  std::unique_ptr<SurfaceTree> tree;
};

/// Sorts `values`: sums and ranks of a set, whatever the order of the points.
Figures figures_of(std::vector<double> values) {
  Figures f;
  const auto missing = std::partition(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
  f.missing = static_cast<std::size_t>(values.end() - missing);
  values.erase(missing, values.end());
  f.count = values.size();
  if (values.empty()) return f;
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(f.count);
  Sum sum, squares;
  for (const double v : values) sum.add(v), squares.add(v * v);
  f.signed_mean = sum.value() / n;
  Sum spread;
  for (const double v : values) spread.add((v - f.signed_mean) * (v - f.signed_mean));
  f.signed_std = std::sqrt(spread.value() / n);
  f.rms = std::sqrt(squares.value() / n);
  for (double& v : values) v = std::fabs(v);
  std::sort(values.begin(), values.end());
  Sum sizes;
  for (const double v : values) sizes.add(v);
  f.mean = sizes.value() / n;
  f.max = values.back();
  const auto rank = [&](double share) {
    return values[static_cast<std::size_t>(std::max(0.0, std::ceil(share * n) - 1))];
  };
  f.median = rank(0.5), f.p95 = rank(0.95);
  return f;
}

/// `distance_of(point)` for all kept points of a scan, in parallel; the field over all points of its file beside it.
template <class F>
Figures over_points(const PosedScan& scan, std::size_t points, const std::string& name, std::vector<Attribute>& fields,
                    const Context& context, F&& distance_of) {
  std::vector<double> values(scan.kept.points.size());
  for_blocks(values.size(), query_block, [&](std::size_t begin, std::size_t end) {
    context.check();
    for (std::size_t i = begin; i < end; ++i) values[i] = distance_of(scan.kept.points[i]);
  });
  Array<double> all(points);
  std::fill(all.begin(), all.end(), nan);
  for (std::size_t i = 0; i < values.size(); ++i) all[scan.kept.ids[i]] = values[i];
  fields.push_back({name, std::move(all)});
  return figures_of(std::move(values));
}

/// Along the direction: own height less that of the surface, nearest sheet first; NaN beside the surface.
double vertical_distance(const Point3& p, const SurfaceTree& tree) {
  const Crossing crossing = tree.cross(p, up);
  return crossing.face == no_index ? nan : -crossing.t;
}

double normal_distance(const Point3& p, const SurfaceTree& tree) {
  const Crossing under = tree.cross(p, up);
  if (under.face == no_index) return nan;
  const auto c = tree.corners(under.face);
  const Point3 n = cross(c[1] - c[0], c[2] - c[0]);
  const Crossing crossing = tree.cross(p, (1 / length(n)) * n);
  return crossing.face == no_index ? nan : -crossing.t;
}

double diagonal(const PosedScan& a, const PosedScan& b) {
  Box3 box;
  for (const PosedScan* scan : {&a, &b})
    for (const Point3& p : scan->kept.points) box.add(p);
  return length(box.max - box.min);
}

/// Sets the unit of the result. Distances in space mean nothing where z has another unit than x and y.
void check_units(const CloudView& a, const CloudView& b, Distances& d) {
  const DistanceOptions& options = d.options;
  Comparison units;  // what compare says of units and CRS holds here too
  units.options.unit = options.unit;
  units.options.allow_crs = options.allow_crs;
  for (const CloudView* cloud : {&a, &b}) {
    if (!options.unit.empty() || cloud->unit == "unknown" || cloud->vertical_unit == "unknown" ||
        cloud->unit == cloud->vertical_unit)
      continue;
    const std::string what =
        fmt::format("{}: x and y are in {} but heights in {}", cloud_name(*cloud), cloud->unit, cloud->vertical_unit);
    if (!options.allow_crs)
      throw InputError(what +
                       ", so distances in space would mean nothing: convert it, or say @unit or @allow-crs to "
                       "take the numbers as they are");
    units.options.unit = "unknown";
    d.warnings.push_back(what + ": distances mix the two as if they were one");
  }
  stages::check_units(a, b, units.options, units);
  d.unit = units.unit;
  d.warnings.insert(d.warnings.end(), units.warnings.begin(), units.warnings.end());
}

M3c2Result measure_m3c2(const std::optional<CloudView>& cores, const PosedScan& a, const PosedScan& b,
                        const Distances& d, const Context& context) {
  M3c2Result result;
  Array<Point3> places;
  if (cores) {
    for (const Point3& p : cores->points)
      if (is_finite(p)) result.cores.push_back(p), places.push_back(d.frame.to_field(p));
    if (places.empty())
      throw InputError((cores->path.empty() ? std::string("@core-points") : cores->path) + ": holds no core point");
  } else {
    places = a.kept.points;
    for (const Point3& p : places) result.cores.push_back(d.frame.to_input(p));
  }
  result.field = m3c2(a.kept.points, b.kept.points, places, d.options.m3c2, context);
  const M3c2Field& f = result.field;
  std::vector<double> lods;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!std::isnan(f.distance[i])) ++result.measured;
    if (!std::isnan(f.lod[i])) lods.push_back(f.lod[i]);
    if (f.significant[i] != 0) ++result.significant;
  }
  result.with_lod = lods.size();
  result.figures = figures_of({f.distance.begin(), f.distance.end()});
  result.median_lod = figures_of(std::move(lods)).median;
  // Normals leave the frame as the points do.
  for (Point3& n : result.field.normal)
    if (!std::isnan(n.x)) {
      const auto& r = d.frame.rotation;
      n = {r[0] * n.x + r[3] * n.y + r[6] * n.z, r[1] * n.x + r[4] * n.y + r[7] * n.z,
           r[2] * n.x + r[5] * n.y + r[8] * n.z};
    }
  return result;
}

class Page {
 public:
  Page(const CloudView& cloud_a, const CloudView& cloud_b, Distances& d, const Context& context)
      : cloud_a_(cloud_a), cloud_b_(cloud_b), d_(d), context_(context), clock_(d.timing, context) {}

  void run(const std::optional<CloudView>& cores) {
    prepare();
    measure_points();
    measure_surfaces();
    if (d_.options.measures.m3c2) {
      clock_.start("m3c2");
      d_.m3c2 = measure_m3c2(cores, a_, b_, d_, context_);
    }
    clock_.stop();
  }

 private:
  void prepare() {
    const DistanceOptions& o = d_.options;
    const DistanceMeasures& m = o.measures;
    clock_.start("project");
    d_.frame = choose_frame(cloud_a_, cloud_b_, o.pose, o.project, context_);
    both([&] { load(cloud_a_, Pose{}, a_); }, [&] { load(cloud_b_, o.pose, b_); });
    d_.points_a = a_.kept.points.size(), d_.points_b = b_.kept.points.size();
    if (!(m.c2s || m.normal || m.vertical || m.surface || m.hausdorff)) return;
    clock_.start("surface");
    both([&] { lay(cloud_a_, Pose{}, a_); }, [&] { lay(cloud_b_, o.pose, b_); });
    d_.faces_a = a_.mesh.faces.size(), d_.faces_b = b_.mesh.faces.size();
    d_.own_faces_a = a_.mesh.own_faces, d_.own_faces_b = b_.mesh.own_faces;
    d_.trimmed_a = a_.mesh.trimmed_area, d_.trimmed_b = b_.mesh.trimmed_area;
  }
  void load(const CloudView& cloud, const Pose& pose, PosedScan& scan) {
    scan.field = project(cloud, pose, d_.frame, d_.options.project, context_);
    scan.kept = scan_points(cloud, pose, d_.frame, scan.field);
  }
  void lay(const CloudView& cloud, const Pose& pose, PosedScan& scan) {
    scan.mesh = make_mesh(cloud, pose, d_.frame, scan.field, d_.options.mesh,
                          {d_.options.border == BorderRule::trim, d_.options.max_edge}, context_);
    scan.tree = std::make_unique<SurfaceTree>(scan.mesh);
  }

  template <class A, class B>
  void both_ways(const char* name, std::optional<BothWays<Figures>>& figures, A&& of_a, B&& of_b) {
    clock_.start(name);
    figures.emplace();
    figures->a_to_b = over_points(a_, cloud_a_.points.size(), name, d_.fields_a, context_, of_a);
    figures->b_to_a = over_points(b_, cloud_b_.points.size(), name, d_.fields_b, context_, of_b);
  }

  void measure_points() {
    const DistanceMeasures& m = d_.options.measures;
    if (m.c2c) {
      std::unique_ptr<PointTree> ta, tb;
      both([&] { ta = std::make_unique<PointTree>(a_.kept.points); },
           [&] { tb = std::make_unique<PointTree>(b_.kept.points); });
      const auto nearest = [](const PointTree& t) {
        return [&t](const Point3& p) { return std::sqrt(t.nearest_distance2(p)); };
      };
      both_ways("c2c", d_.c2c, nearest(*tb), nearest(*ta));
    }
    const auto closest = [](const SurfaceTree& t) {
      return [&t](const Point3& p) { return std::sqrt(t.closest(p).at.distance2); };
    };
    // B − A: over A's points the other way round.
    if (m.c2s) both_ways("c2s", d_.c2s, closest(*b_.tree), closest(*a_.tree));
    if (m.normal)
      both_ways(
          "normal", d_.normal, [&](const Point3& p) { return -normal_distance(p, *b_.tree); },
          [&](const Point3& p) { return normal_distance(p, *a_.tree); });
    if (m.vertical)
      both_ways(
          "vertical", d_.vertical, [&](const Point3& p) { return -vertical_distance(p, *b_.tree); },
          [&](const Point3& p) { return vertical_distance(p, *a_.tree); });
  }

  void measure_surfaces() {
    DistanceOptions& o = d_.options;
    if (o.measures.surface) {
      clock_.start("surface_figures");
      SurfaceSampling sampling;
      if (o.samples != DistanceOptions{}.samples) sampling.least = 0;  // the user says how many
      sampling.per_face = o.samples, sampling.rounding = distance_rounding(a_.mesh, b_.mesh);
      d_.surface = {surface_figures(a_.mesh, *b_.tree, sampling, context_),
                    surface_figures(b_.mesh, *a_.tree, sampling, context_)};
    }
    if (!o.measures.hausdorff) return;
    clock_.start("hausdorff");
    if (o.tolerance == 0) o.tolerance = std::max(1e-6 * diagonal(a_, b_), 4 * distance_rounding(a_.mesh, b_.mesh));
    d_.hausdorff = {directed_hausdorff(a_.mesh, *b_.tree, o.tolerance, context_),
                    directed_hausdorff(b_.mesh, *a_.tree, o.tolerance, context_)};
    for (HausdorffBound* bound : {&d_.hausdorff->a_to_b, &d_.hausdorff->b_to_a})
      bound->at = d_.frame.to_input(bound->at);
  }

  CloudView cloud_a_, cloud_b_;
  Distances& d_;
  const Context& context_;
  stages::Clock clock_;
  PosedScan a_, b_;
};

}  // namespace

void check(const DistanceOptions& options) {
  const auto positive = [](double value, const char* name, const char* what) {
    if (!(value > 0) || !std::isfinite(value))
      throw UsageError(fmt::format("{}: m3c2 needs it, a length above 0: {}", name, what));
  };
  if (options.measures.m3c2) {
    positive(options.m3c2.normal_scale, "@normal-scale", "the diameter D of the ball that gives the normal");
    positive(options.m3c2.projection_scale, "@projection-scale", "the diameter d of the cylinder");
    positive(options.m3c2.max_depth, "@max-depth", "how far the cylinder reaches from the core point");
    if (!(options.m3c2.registration_error >= 0) || !std::isfinite(options.m3c2.registration_error))
      throw UsageError("@registration-error: is not a length, 0 or more");
  }
  if (!(options.tolerance >= 0) || !std::isfinite(options.tolerance))
    throw UsageError("@tolerance: is not a length, 0 or more");
  if (!(options.max_edge >= 0) || !std::isfinite(options.max_edge))
    throw UsageError("@max-edge: is not a length, 0 or more");
  if (options.samples < 1) throw UsageError("@samples: at least 1 a triangle");
}

Distances distance(const CloudView& a, const CloudView& b, const std::optional<CloudView>& cores,
                   const DistanceOptions& options, const Context& context) {
  check(options);
  Distances d;
  d.options = options;
  check_units(a, b, d);
  d.a = stages::summarise_file(a, "A"), d.b = stages::summarise_file(b, "B");
  run_with_threads(context, [&] { Page(a, b, d, context).run(cores); });
  return d;
}

}  // namespace isopach
