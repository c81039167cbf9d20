#include "isopach/apps/roughness.hpp"

#include <cmath>

#include <fmt/format.h>

#include "isopach/apps/texture.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/field/extent.hpp"
#include "isopach/match/match.hpp"
#include "isopach/measure/texture/form.hpp"

namespace isopach {
namespace {

void check(const RoughnessOptions& o, bool has_after, bool has_reference) {
  const auto length = [](double value, const char* option) {
    if (!(value >= 0) || !std::isfinite(value))
      throw UsageError(fmt::format("{}: {} is no length: give one above 0", option, value));
  };
  length(o.s_filter, "@s-filter"), length(o.l_filter, "@l-filter");
  for (const auto& [value, option] : {std::pair{o.s_filter, "@s-filter"}, {o.l_filter, "@l-filter"}})
    if (value > max_extent)
      throw UsageError(fmt::format("{}: {} is longer than any scan, the most is {}", option, value, max_extent));
  if (o.margin >= 0) length(o.margin, "@margin");
  length(o.wrinkles.depth, "@wrinkle-depth"), length(o.wrinkles.length, "@wrinkle-length");
  if (o.s_filter > 0 && o.l_filter > 0 && !(o.s_filter < o.l_filter))
    throw UsageError(fmt::format("@s-filter: {} is not below the cut-off of @l-filter, {}: nothing would be left",
                                 o.s_filter, o.l_filter));
  if (o.form == FormKind::polynomial && (o.degree < 1 || o.degree > most_form_degree))
    throw UsageError(fmt::format("@degree: {} is not one of 1 to {}", o.degree, most_form_degree));
  if (o.filter_degree > 1) throw UsageError(fmt::format("@filter-degree: {} is not 0 or 1", o.filter_degree));
  if (o.filter == MeanFilter::robust && o.l_filter == 0)
    throw UsageError("@filter: there is no waviness to filter: give the cut-off @l-filter");
  if (o.form == FormKind::reference && !has_reference)
    throw UsageError("@form: a reference is to be removed: name its file with @reference");
  if (o.form != FormKind::reference && has_reference)
    throw UsageError("@reference: is of use with @form reference alone");
  if (o.match && !has_after && !has_reference)
    throw UsageError("@match: there is nothing to move: give a second scan or a @reference");
  if (!has_after && !o.compare.pose.is_identity())
    throw UsageError("@pose: is that of the second scan, and there is none");
}

/// Sets the unit. Slopes and lengths along the surface mean nothing where z has another unit than x and y.
void check_units(const CloudView& scan, const std::optional<CloudView>& after,
                 const std::optional<CloudView>& reference, Roughness& r) {
  CompareOptions options = r.options.compare;
  const CloudView none;
  for (const CloudView* cloud : {&scan, after ? &*after : nullptr, reference ? &*reference : nullptr}) {
    if (cloud == nullptr || !options.unit.empty() || cloud->unit == "unknown" || cloud->vertical_unit == "unknown" ||
        cloud->unit == cloud->vertical_unit)
      continue;
    const std::string what =
        fmt::format("{}: x and y are in {} but heights in {}", cloud_name(*cloud), cloud->unit, cloud->vertical_unit);
    if (!options.allow_crs)
      throw InputError(what +
                       ", so slopes would mean nothing: convert it, or say @unit or @allow-crs to take the "
                       "numbers as they are");
    options.unit = "unknown";
    r.warnings.push_back(what + ": slopes and lengths mix the two as if they were one");
  }
  Comparison units;  // what compare says of units and CRS holds here too
  stages::check_units(scan, after ? *after : none, options, units);
  r.unit = units.unit;
  r.warnings.insert(r.warnings.end(), units.warnings.begin(), units.warnings.end());
  if (reference) stages::check_units(scan, *reference, options, units);
}

Pose matched(const CloudView& moving, const CloudView& scan, const Pose& start, const char* what,
             std::optional<Verdict>& verdict, Roughness& r, const Context& context) {
  MatchOptions wanted;
  wanted.compare = r.options.compare;
  wanted.compare.pose = {};
  wanted.start = start;
  wanted.compare.check_layers = false;
  wanted.accept_doubt = r.options.accept_doubt;
  const Matching m = match(moving, scan, wanted, context);
  require_trust(m, fmt::format("@match: {}", what));
  if (m.verdict && !m.verdict->trusted())
    r.warnings.push_back(fmt::format("match of {}: the pose is {}", what, sentence(*m.verdict, m.unit)));
  verdict = m.verdict;
  if (!m.converged)
    throw Error(ExitCode::not_converged,
                fmt::format("@match: {}: {}: look at it with isopach match, and give it in place", what, m.reason));
  for (const std::string& weak : m.weak_directions) r.warnings.push_back(fmt::format("match of {}: {}", what, weak));
  return m.pose;
}

Roughness run(const CloudView& scan, const std::optional<CloudView>& after, const std::optional<CloudView>& reference,
              const RoughnessOptions& options, const Context& context) {
  Roughness r;
  r.options = options;
  check(options, after.has_value(), reference.has_value());
  check_units(scan, after, reference, r);
  stages::Clock clock(r.timing, context);

  if (options.match) {
    clock.start("match");
    Pose& pose = r.options.compare.pose;
    if (after) pose = matched(*after, scan, pose, "the second scan", r.verdict, r, context);
    if (reference)
      r.reference_pose = matched(*reference, scan, Pose{}, "the reference", r.reference_verdict, r, context);
  }

  clock.start("frame");
  const Pose& pose = r.options.compare.pose;
  r.frame = choose_frame(scan, after ? *after : scan, after ? pose : Pose{}, options.compare.project, context);
  std::optional<MatchSurface> form;
  if (reference) {
    form = reference_surface(*reference, r.reference_pose, r.frame, r.options, context);
    r.reference = stages::summarise_file(*reference, "reference");
    r.reference->nodes = form->xy.size();
  }

  clock.start("roughness");
  const MatchSurface* surface = form ? &*form : nullptr;
  r.scan = texture(scan, "scan", Pose{}, r.frame, surface, r.options, r.warnings, context);
  if (after) {
    clock.start("roughness_after");
    r.after = texture(*after, "after", pose, r.frame, surface, r.options, r.warnings, context);
    r.wrinkles_after = follow_wrinkles(r.scan, *r.after, context);
  }
  clock.stop();
  return r;
}

}  // namespace

Roughness roughness(const CloudView& scan, const std::optional<CloudView>& after,
                    const std::optional<CloudView>& reference, const RoughnessOptions& options,
                    const Context& context) {
  Roughness result;
  run_with_threads(context, [&] { result = run(scan, after, reference, options, context); });
  return result;
}

}  // namespace isopach
