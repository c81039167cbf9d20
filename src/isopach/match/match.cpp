// THE PAGE of matching: one stage a line (METHOD section 4).
#include "isopach/match/match.hpp"

#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/match/checks.hpp"
#include "isopach/match/coarse.hpp"
#include "isopach/match/icp.hpp"
#include "isopach/match/motion.hpp"
#include "isopach/match/search.hpp"
#include "isopach/match/surface.hpp"

namespace isopach {

namespace {

/// The same comparison before and after: ρ, RMS and coverage of MOVING (as B) on FIXED (as A).
Comparison compare_at(const Cloud& moving, const Cloud& fixed, const Pose& pose, CompareOptions options,
                      const Context& context) {
  options.pose = pose;
  return compare(fixed, moving, options, context);
}

Fit fit_of(const Comparison& c) { return {c.measures.rho, c.measures.difference.rms, c.coverage}; }

/// The objective `measure`: both scans in one frame, triangulated once, then the search.
void match_surfaces(const Cloud& moving, const Cloud& fixed, Matching& m, stages::Clock& clock,
                    const Context& context) {
  const CompareOptions& o = m.options.compare;

  clock.start("project");
  const Frame frame = choose_frame(fixed, moving, m.options.start, o.project, context);
  HeightField a, b;
  both([&] { a = project(fixed, Pose{}, frame, o.project, context); },
       [&] { b = project(moving, m.options.start, frame, o.project, context); });

  clock.start("delaunay");  // once: no motion changes it
  const bool trim = o.border == BorderRule::trim;
  MatchSurface f, g;
  both([&] { f = make_surface(std::move(a.xy), std::move(a.z), frame.curve, trim, o.max_edge, context); },
       [&] { g = make_surface(std::move(b.xy), std::move(b.z), frame.curve, trim, o.max_edge, context); });

  clock.start("search");
  const SearchResult found = search(g, f, m.options, axis_names(frame), context);
  clock.stop();
  take(found, frame, b.node_of_point, m);
}

/// The objectives of pairs of points.
void match_points(const Cloud& moving, const Cloud& fixed, Matching& m, stages::Clock& clock, const Context& context) {
  clock.start("search");
  Matching found = icp(moving, fixed, m.options.start, m.options, context);
  clock.stop();
  found.before = m.before, found.timing = m.timing;
  m = std::move(found);
}

Matching run(const Cloud& moving, const Cloud& fixed, const MatchOptions& options, const Context& context) {
  Matching m;
  m.options = options;
  check_options(options);
  if (options.objective == Objective::currents)
    throw UsageError("this build does not match by currents: objective measure, icp-point or icp-plane");
  stages::Clock clock(m.timing, context);

  if (options.coarse) {
    clock.start("coarse");
    m.options.start = coarse_start(moving, fixed, options, context);
    clock.stop();
  }

  clock.start("before");
  const Comparison before = compare_at(moving, fixed, m.options.start, options.compare, context);
  m.before = fit_of(before);
  clock.stop();

  if (options.objective == Objective::measure)
    match_surfaces(moving, fixed, m, clock, context);
  else
    match_points(moving, fixed, m, clock, context);

  clock.start("after");
  const Comparison after = compare_at(moving, fixed, m.pose, options.compare, context);
  m.after = fit_of(after);
  clock.stop();
  describe(after, m);
  return m;
}

}  // namespace

Matching match(const Cloud& moving, const Cloud& fixed, const MatchOptions& options, const Context& context) {
  Matching result;
  run_with_threads(context.threads, [&] { result = run(moving, fixed, options, context); });
  return result;
}

}  // namespace isopach
