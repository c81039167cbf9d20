// THE PAGE of matching: one stage a line (docs/method/matching.md).
#include "isopach/match/match.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "isopach/base/kept_memory.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/compare/weighting.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/match/checks.hpp"
#include "isopach/match/coarse/coarse.hpp"
#include "isopach/match/currents/currents_search.hpp"
#include "isopach/match/judge.hpp"
#include "isopach/match/motion.hpp"
#include "isopach/match/pairs/icp.hpp"
#include "isopach/match/surface/nominal.hpp"
#include "isopach/match/surface/search.hpp"
#include "isopach/match/surface/surface.hpp"
#include "isopach/match/surface/weights.hpp"

namespace isopach {

namespace {

/// Whether it is of heights over a plane; pairs of points are of space, and need no height field.
bool of_surfaces(Objective objective) { return !of_pairs(objective); }

Fit fit_of(const Comparison& c) { return {c.measures.rho, c.measures.difference.rms, c.coverage}; }

/// MOVING (as B) on FIXED (as A) where it starts: the scans as meshes, and how they lie on one another if that is
/// asked for.
Pair at_start(const CloudView& moving, const CloudView& fixed, Matching& m, stages::Clock& clock,
              const Context& context) {
  CompareOptions options = m.options.compare;
  options.pose = m.options.start;
  options.keep_points = m.options.keep_comparisons;
  Pair pair;
  if (m.options.judge) {
    clock.start("before");
    options.check_layers = false;  // the comparison after it does
    Comparison before = compare(fixed, moving, options, context, pair);
    m.before = fit_of(before);
    if (m.options.keep_comparisons) m.comparison_before = std::move(before);
    return pair;
  }
  Comparison c;
  options.check_layers = options.check_layers && of_surfaces(m.options.objective);
  c.options = options;
  stages::check_options(options);
  stages::check_weight(options);
  stages::check_units(fixed, moving, options, c);

  clock.start("project");
  pair = project_pair(fixed, moving, options.pose, options.project, context);
  stages::describe_inputs(fixed, moving, pair, c, context);
  describe(c, m);

  if (!of_surfaces(m.options.objective)) return pair;  // they look at points alone
  clock.start("delaunay");                             // once: no motion changes it
  triangulate(pair, context);

  clock.start("border");
  stages::find_footprints(pair, options, context);
  return pair;
}

/// The search by the measure, again on the facets of a scan that could be a nominal mesh: it is one if the points of
/// the other lie on its facets where these lead to. Of two, FIXED alone: points of one of them are needed.
template <class Search>
SearchResult search_with_nominal(const CloudView& moving, const CloudView& fixed, MatchSurface& g, MatchSurface& f,
                                 Matching& m, const Search& search_from, const Context& context) {
  SearchResult found = search_from(g, f);
  const auto shown = [&](bool of_fixed, const Motion& motion) {
    return of_fixed ? rise_shown(g, f, motion, false, context) : rise_shown(f, g, motion, true, context);
  };
  for (const bool of_fixed : {true, false}) {
    if (!may_be_nominal(of_fixed ? fixed : moving) || !could_be_nominal(shown(of_fixed, found.motion))) continue;
    MatchSurface flat = of_fixed ? f : g;
    take_as_nominal(flat, !of_fixed);  // nodes of MOVING say what of it was fitted
    SearchResult on_facets = of_fixed ? search_from(g, flat) : search_from(flat, f);
    if (!is_nominal(shown(of_fixed, on_facets.motion))) continue;
    (of_fixed ? m.nominal_fixed : m.nominal_moving) = true;
    (of_fixed ? f : g) = std::move(flat);
    return on_facets;
  }
  return found;
}

/// The objectives `measure` and `currents`: both scans in one frame, triangulated once, then the search.
void match_surfaces(const CloudView& moving, const CloudView& fixed, Pair pair, Matching& m, stages::Clock& clock,
                    const Context& context) {
  clock.start("facets");
  Scan &a = pair.scan[0], &b = pair.scan[1];
  const auto surface_of = [](Scan& s) {
    return make_surface(std::move(s.field.xy), std::move(s.field.z), std::move(s.t), s.kept);
  };
  MatchSurface f, g;
  both([&] { f = surface_of(a); }, [&] { g = surface_of(b); });

  apply_weight(moving, fixed, b.field, a.field, pair.frame, m.options.compare, g, f);

  clock.start("search");
  const auto minimise = m.options.objective == Objective::currents ? currents_search : search;
  const auto search_from = [&](const MatchSurface& from, const MatchSurface& on) {
    return minimise(from, on, m.options, axis_names(pair.frame), context);
  };
  SearchResult found = m.options.objective == Objective::measure
                           ? search_with_nominal(moving, fixed, g, f, m, search_from, context)
                           : search_from(g, f);
  take(found, pair.frame, b.field.node_of_point, m);
}

/// The objectives of pairs of points.
void match_points(const CloudView& moving, const CloudView& fixed, Matching& m, stages::Clock& clock,
                  const Context& context) {
  clock.start("search");
  Matching found = icp(moving, fixed, m.options.start, m.options, context);
  clock.stop();
  found.before = m.before, found.comparison_before = std::move(m.comparison_before);
  found.moving = m.moving, found.fixed = m.fixed, found.unit = m.unit;
  found.warnings.insert(found.warnings.begin(), m.warnings.begin(), m.warnings.end());
  m = std::move(found);
}

/// One search from options.start.
Matching search_once(const CloudView& moving, const CloudView& fixed, const MatchOptions& options, stages::Clock& clock,
                     const Context& context) {
  Matching m;
  m.options = options;
  Pair pair = at_start(moving, fixed, m, clock, context);
  if (of_surfaces(options.objective))
    match_surfaces(moving, fixed, std::move(pair), m, clock, context);
  else
    match_points(moving, fixed, m, clock, context);
  return m;
}

constexpr std::size_t most_places = 4;  // of a coarse search: the best one and its rivals

/// One matching: a search from the start, a verdict, and what follows from that.
class Run {
 public:
  Run(const CloudView& moving, const CloudView& fixed, const MatchOptions& options, const Context& context)
      : moving_(moving),
        fixed_(fixed),
        options_(options),
        context_(context),
        clock_(timing_, context),
        judge_(moving, fixed, options, context) {}

  Matching operator()() {
    std::optional<OverlapError> lost;
    std::optional<Matching> best = first_attempt(lost);
    const bool doubted = !best || (best->verdict && best->verdict->grade == Grade::doubted);
    if (options_.check_pose && doubted && all_rigid_motions(options_.freedom)) best = second_attempt(std::move(best));
    if (!best) throw *lost;
    Matching m = std::move(*best);
    if (m.verdict && m.verdict->trusted() && all_rigid_motions(options_.freedom)) look_for_rivals(m);
    finish(m);
    return m;
  }

 private:
  std::optional<Matching> first_attempt(std::optional<OverlapError>& lost) {
    MatchOptions o = options_;
    if (options_.coarse) o.start = places().front();
    try {
      Matching m = search_once(moving_, fixed_, o, clock_, context_);
      pronounce(m, options_.coarse);
      return m;
    } catch (const OverlapError& error) {
      lost = error;
      return std::nullopt;
    }
  }

  const std::vector<Pose>& places() {
    if (!places_.empty()) return places_;
    clock_.start("coarse");
    places_ = coarse_poses(moving_, fixed_, options_, most_places, context_);
    return places_;
  }

  void pronounce(Matching& m, bool coarse) {
    if (!options_.check_pose) return;
    clock_.start("verdict");
    judge_.take_as_nominal(m.nominal_moving, m.nominal_fixed);
    m.verdict = judge_(m.pose);
    if (coarse) m.verdict->stage = Verdict::Stage::coarse;
  }

  /// From a start of the coarse search by icp-plane, and from there by what was asked for, which is kept unless the
  /// verdict falls: the measure leads astray what is seen from different sides. Nothing where no place is found.
  std::optional<Matching> from_coarse() {
    MatchOptions o = options_;
    o.judge = o.keep_comparisons = false;
    o.objective = Objective::icp_plane;
    o.compare.weight = {};
    o.sigma = 0;
    try {
      o.start = places().front();
      Matching plane = search_once(moving_, fixed_, o, clock_, context_);
      pronounce(plane, true);
      if (options_.objective == Objective::icp_plane) return plane;
      std::optional<Matching> asked = asked_from(plane.pose);
      constexpr double as_good = 0.02;  // of z: what a hundredth of a noise makes of it
      const bool falls = !asked || asked->verdict->grade != plane.verdict->grade ||
                         asked->verdict->evidence.least() < plane.verdict->evidence.least() - as_good;
      if (!falls) return asked;
      plane.warnings.push_back(
          "the pose is that of icp-plane: the objective asked for leads from there to one that agrees less");
      return plane;
    } catch (const OverlapError&) {
      return std::nullopt;
    }
  }

  std::optional<Matching> asked_from(const Pose& start) {
    MatchOptions o = options_;
    o.judge = o.keep_comparisons = false;
    o.start = start;
    try {
      Matching m = search_once(moving_, fixed_, o, clock_, context_);
      pronounce(m, true);
      return m;
    } catch (const OverlapError&) {
      return std::nullopt;
    }
  }

  /// The better of the first attempt, if it found any, and one from a coarse search.
  std::optional<Matching> second_attempt(std::optional<Matching> first) {
    if (options_.coarse && options_.objective == Objective::icp_plane) return first;  // it was that already
    std::optional<Matching> second = from_coarse();
    if (!second) {
      if (first) first->verdict->tried = "a coarse search found no place where they fit";
      return first;
    }
    if (!first) {
      second->verdict->tried = "they do not overlap at the start: a coarse search found the place";
      return second;
    }
    const double one = first->verdict->evidence.least(), other = second->verdict->evidence.least();
    if (!second->verdict->trusted() && !(other > one)) {
      first->verdict->tried = fmt::format("the place that a coarse search found agrees by {:.2f}", other);
      return first;
    }
    second->verdict->tried =
        fmt::format("from the start it agreed by {:.2f} only: a coarse search found this place", one);
    second->before = first->before;
    second->comparison_before = std::move(first->comparison_before);
    return second;
  }

  /// Another place that is as good, once icp-plane has led it home: of the coarse search, if it ran, or where one of
  /// the scans repeats itself. Where the pose is that of the start but for a little, the start has decided between
  /// them.
  void look_for_rivals(Matching& m) {
    constexpr double worth_a_search = 0.4;  // a place that few steps led to agrees less than where more would lead
    constexpr double near_start = 0.1;      // of the way to the rival
    clock_.start("verdict");
    const double least = m.verdict->evidence.least();
    const bool from_start = m.verdict->stage == Verdict::Stage::start;
    const auto start_decides = [&](const Pose& other) {
      return from_start && judge_.share_of_way(m.pose, other, options_.start) < near_start;
    };
    MatchOptions o = options_;
    o.objective = Objective::icp_plane;
    o.compare.weight = {}, o.sigma = 0;
    std::vector<Pose> others = places_;
    for (const Pose& place : judge_.repeated(m.pose)) others.push_back(place);
    for (const Pose& place : others) {
      if (!judge_.is_another(m.pose, place)) continue;
      if (start_decides(place)) continue;
      if (judge_(place).evidence.least() < least - worth_a_search) continue;
      try {
        const Matching found = icp(moving_, fixed_, place, o, context_);
        const Verdict v = judge_(found.pose);
        if (!judge_.is_another(m.pose, found.pose) || v.evidence.least() < least - rival_margin) continue;
        if (m.verdict->rival && m.verdict->rival->least >= v.evidence.least()) continue;
        m.verdict->rival = judge_.apart_from(m.pose, found.pose);
        m.verdict->rival->least = v.evidence.least();
        m.verdict->grade = Grade::rival;
      } catch (const OverlapError&) {
        continue;
      }
    }
  }

  void finish(Matching& m) {
    m.options.coarse = options_.coarse;
    m.options.judge = options_.judge, m.options.keep_comparisons = options_.keep_comparisons;
    if (options_.label_points && m.verdict) {
      clock_.start("verdict");
      m.agreement = judge_.labels(m.pose, *m.verdict);
    }
    if (options_.judge) compare_after(m);
    clock_.stop();
    warn(m);
    if (m.verdict && !m.verdict->trusted()) m.warnings.push_back("the pose is " + sentence(*m.verdict, m.unit));
    m.timing = std::move(timing_);
  }

  void compare_after(Matching& m) {
    clock_.start("after");
    CompareOptions there = options_.compare;
    there.pose = m.pose;
    there.keep_points = options_.keep_comparisons;
    there.check_layers = there.check_layers && of_surfaces(options_.objective);
    Comparison after = compare(fixed_, moving_, there, context_);
    m.after = fit_of(after);
    std::vector<std::string> own;
    own.swap(m.warnings);
    describe(after, m);
    for (const std::string& w : own)
      if (std::find(m.warnings.begin(), m.warnings.end(), w) == m.warnings.end()) m.warnings.push_back(w);
    if (options_.keep_comparisons) m.comparison_after = std::move(after);
  }

  CloudView moving_, fixed_;
  const MatchOptions& options_;
  const Context& context_;
  Timing timing_;
  stages::Clock clock_;
  Judge judge_;
  std::vector<Pose> places_;  ///< of the coarse search, once it ran: the best one first
};

}  // namespace

bool slides_alone(const Matching& m) { return m.verdict && only_slides(*m.verdict); }

void require_trust(const Matching& m, const std::string& option) {
  if (m.verdict) require_trust(*m.verdict, m.unit == "unknown" ? "units" : m.unit, option);
}

Matching match(const CloudView& moving, const CloudView& fixed, const MatchOptions& options, const Context& context) {
  const KeptMemory kept;  // of one comparison for the next
  Matching result;
  run_with_threads(context, [&] {
    check_options(options);
    result = Run(moving, fixed, options, context)();
  });
  return result;
}

}  // namespace isopach
