#include "isopach/apps/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "isopach/apps/along_normal.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/match/match.hpp"
#include "isopach/match/surface/surface.hpp"
#include "isopach/measure/source.hpp"

namespace isopach {
namespace {

void check(const AccuracyOptions& o) {
  if (!(o.within >= 0) || !std::isfinite(o.within))
    throw UsageError(fmt::format("@within: {} is no tolerance: a height above 0", o.within));
}

double footprint_area(const CloudView& reference, const Frame& frame, const CompareOptions& o, const Context& context) {
  HeightField f = project(reference, Pose{}, frame, o.project, context);
  return make_surface(std::move(f.xy), std::move(f.z), frame.curve, o.border == BorderRule::trim, o.max_edge, context)
      .footprint.area;
}

void describe_completeness(const CloudView& reference, const CellView& along_normal, Accuracy& a,
                           const Context& context) {
  const Comparison& c = a.comparison;
  Completeness& k = a.completeness;
  k.reference_area = footprint_area(reference, c.frame, c.options, context);
  const double folded = c.options.folds == FoldRule::leave_out ? c.folds.area : 0;
  k.share = std::min(1.0, (c.domain_area + folded) / k.reference_area);
  if (a.options.within > 0)
    k.within = std::min(1.0, area_within(along_normal, a.options.within, context) / (k.reference_area - folded));
}

DistanceOptions distance_options(const Accuracy& a) {
  const CompareOptions& c = a.options.match.compare;
  DistanceOptions d;
  d.project = c.project;
  d.pose = a.pose;
  d.measures.c2s = d.measures.hausdorff = true;
  d.unit = c.unit;
  d.allow_crs = c.allow_crs;
  return d;
}

void add_new(std::vector<std::string>& all, const std::vector<std::string>& more) {
  for (const std::string& w : more)
    if (std::find(all.begin(), all.end(), w) == all.end()) all.push_back(w);
}

Accuracy run(const CloudView& reconstruction, const CloudView& reference, const AccuracyOptions& options,
             const Context& context) {
  Accuracy a;
  a.options = options;
  check(options);
  stages::Clock clock(a.timing, context);
  MatchOptions& m = a.options.match;
  m.freedom.scale = m.freedom.scale || options.align == Align::scale;

  clock.start("align");
  a.pose = m.start;
  if (options.align != Align::none) {
    MatchOptions wanted = m;
    wanted.compare.check_layers = false;  // the comparison does
    a.matching = match(reconstruction, reference, wanted, context);
    if (!slides_alone(*a.matching)) require_trust(*a.matching, "@align");
    a.pose = a.matching->pose;
    a.scale = a.matching->scale;
  }

  clock.start("compare");
  CompareOptions compare_options = m.compare;
  compare_options.pose = a.pose;
  Pair scans;
  a.comparison = compare(reference, reconstruction, compare_options, context, scans);
  a.unit = a.comparison.unit;
  const Comparison& c = a.comparison;
  const NormalCells cells(c, scans, context);
  a.normal = measure(cells.view(), context);
  a.points = point_residuals(reconstruction, a.pose, c.frame, compare_options.project, c.fields_b.dz_signed, context);
  describe_completeness(reference, cells.view(), a, context);

  clock.start("distance");
  a.distances = distance(reference, reconstruction, std::nullopt, distance_options(a), context);
  clock.stop();
  if (a.matching) add_new(a.warnings, a.matching->warnings);
  add_new(a.warnings, c.warnings);
  add_new(a.warnings, a.distances.warnings);
  return a;
}

}  // namespace

double area_within(const CellView& cells, double limit, const Context& context) {
  context.check();
  return reduce_blocks<Sum>(
             items_of(cells), default_block,
             [&](std::size_t begin, std::size_t end) {
               Sum area;
               for_convex(cells, begin, end, [&](const ConvexCell& whole) {
                 const ConvexCell low = cut(whole, [&](const Corner& p) { return p.d() + limit; });
                 const ConvexCell piece = cut(low, [&](const Corner& p) { return limit - p.d(); });
                 for_triangles(piece,
                               [&](double part, const Corner&, const Corner&, const Corner&) { area.add(part); });
               });
               return area;
             },
             [](Sum& total, const Sum& part) { total.add(part); })
      .value();
}

Accuracy accuracy(const CloudView& reconstruction, const CloudView& reference, const AccuracyOptions& options,
                  const Context& context) {
  Accuracy result;
  run_with_threads(context, [&] { result = run(reconstruction, reference, options, context); });
  return result;
}

}  // namespace isopach
