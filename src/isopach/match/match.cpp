// THE PAGE of matching: one stage a line (METHOD section 4).
#include "isopach/match/match.hpp"

#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/compare/weighting.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/match/checks.hpp"
#include "isopach/match/coarse.hpp"
#include "isopach/match/currents_search.hpp"
#include "isopach/match/icp.hpp"
#include "isopach/match/motion.hpp"
#include "isopach/match/nominal.hpp"
#include "isopach/match/search.hpp"
#include "isopach/match/surface.hpp"
#include "isopach/match/weights.hpp"

namespace isopach {

namespace {

Fit fit_of(const Comparison& c) { return {c.measures.rho, c.measures.difference.rms, c.coverage}; }

/// MOVING (as B) on FIXED (as A) where it starts: the scans as meshes, and how they lie on one another if that is
/// asked for.
ScanMeshes at_start(const Cloud& moving, const Cloud& fixed, Matching& m, stages::Clock& clock,
                    const Context& context) {
  CompareOptions options = m.options.compare;
  options.pose = m.options.start;
  ScanMeshes meshes;
  if (m.options.judge) {
    clock.start("before");
    Comparison before = compare(fixed, moving, options, context, meshes);
    m.before = fit_of(before);
    if (m.options.keep_comparisons) m.comparison_before = std::move(before);
    return meshes;
  }
  Comparison c;
  c.options = options;
  stages::check_options(options);
  stages::check_weight(options);
  stages::check_units(fixed, moving, options, c);

  clock.start("project");
  const Frame frame = meshes.frame = choose_frame(fixed, moving, options.pose, options.project, context);
  HeightField &a = meshes.a, &b = meshes.b;
  both([&] { a = project(fixed, Pose{}, frame, options.project, context); },
       [&] { b = project(moving, options.pose, frame, options.project, context); });
  stages::describe_inputs(fixed, moving, a, b, c, context);
  describe(c, m);

  clock.start("delaunay");  // once: no motion changes it
  both([&] { meshes.t1 = triangulate(a.xy, frame.curve, context); },
       [&] { meshes.t2 = triangulate(b.xy, frame.curve, context); });

  clock.start("border");
  stages::find_footprints(meshes.t1, meshes.t2, a, b, options, meshes.kept_1, meshes.kept_2, context);
  return meshes;
}

/// Whether one of the scans, whose file has faces, is a nominal mesh: the points of the other lie on its facets. Such
/// surfaces are taken as they are from now on.
bool find_nominal(const Cloud& moving, const Cloud& fixed, const Motion& motion, MatchSurface& g, MatchSurface& f,
                  Matching& m, const Context& context) {
  m.nominal_moving = may_be_nominal(moving) && is_nominal(rise_shown(f, g, motion, true, context));
  m.nominal_fixed = may_be_nominal(fixed) && is_nominal(rise_shown(g, f, motion, false, context));
  if (m.nominal_moving && m.nominal_fixed) m.nominal_moving = false;  // points of one of them are needed
  if (m.nominal_moving) take_as_nominal(g, true);                     // its nodes say what of MOVING was fitted
  if (m.nominal_fixed) take_as_nominal(f, false);
  return m.nominal_moving || m.nominal_fixed;
}

/// The objectives `measure` and `currents`: both scans in one frame, triangulated once, then the search.
void match_surfaces(const Cloud& moving, const Cloud& fixed, ScanMeshes meshes, Matching& m, stages::Clock& clock,
                    const Context& context) {
  clock.start("facets");
  HeightField &a = meshes.a, &b = meshes.b;
  MatchSurface f, g;
  both([&] { f = make_surface(std::move(a.xy), std::move(a.z), std::move(meshes.t1), meshes.kept_1); },
       [&] { g = make_surface(std::move(b.xy), std::move(b.z), std::move(meshes.t2), meshes.kept_2); });

  apply_weight(moving, fixed, b, a, meshes.frame, m.options.compare, g, f, context);

  clock.start("search");
  const auto minimise = m.options.objective == Objective::currents ? currents_search : search;
  SearchResult found = minimise(g, f, m.options, axis_names(meshes.frame), context);
  if (m.options.objective == Objective::measure && find_nominal(moving, fixed, found.motion, g, f, m, context))
    found = minimise(g, f, m.options, axis_names(meshes.frame), context);
  take(found, meshes.frame, b.node_of_point, m);
}

/// The objectives of pairs of points.
void match_points(const Cloud& moving, const Cloud& fixed, Matching& m, stages::Clock& clock, const Context& context) {
  clock.start("search");
  Matching found = icp(moving, fixed, m.options.start, m.options, context);
  clock.stop();
  found.before = m.before, found.timing = m.timing, found.comparison_before = std::move(m.comparison_before);
  found.moving = m.moving, found.fixed = m.fixed, found.unit = m.unit;
  found.warnings.insert(found.warnings.begin(), m.warnings.begin(), m.warnings.end());
  m = std::move(found);
}

Matching run(const Cloud& moving, const Cloud& fixed, const MatchOptions& options, const Context& context) {
  Matching m;
  m.options = options;
  check_options(options);
  stages::Clock clock(m.timing, context);

  if (options.coarse) {
    clock.start("coarse");
    m.options.start = coarse_start(moving, fixed, options, context);
  }
  ScanMeshes meshes = at_start(moving, fixed, m, clock, context);
  if (options.objective == Objective::measure || options.objective == Objective::currents)
    match_surfaces(moving, fixed, std::move(meshes), m, clock, context);
  else
    match_points(moving, fixed, m, clock, context);

  if (options.judge) {
    clock.start("after");
    CompareOptions there = options.compare;
    there.pose = m.pose;
    Comparison after = compare(fixed, moving, there, context);
    m.after = fit_of(after);
    describe(after, m);
    if (options.keep_comparisons) m.comparison_after = std::move(after);
  }
  clock.stop();
  warn(m);
  return m;
}

}  // namespace

Matching match(const Cloud& moving, const Cloud& fixed, const MatchOptions& options, const Context& context) {
  Matching result;
  run_with_threads(context.threads, [&] { result = run(moving, fixed, options, context); });
  return result;
}

}  // namespace isopach
