#include "isopach/compare/currents.hpp"

#include <fmt/format.h>

#include "isopach/base/parallel.hpp"
#include "isopach/measure/current.hpp"

namespace isopach::stages {

namespace {

/// A ρ known no better than this is told with a warning.
constexpr double poor_rho = 0.05;

bool asked(const CompareOptions& options) { return options.measure == MeasureKind::currents; }

/// Triangles of a scan that are kept and, unless over the hull, have all corners over the footprint of the other; cut
/// to the clip.
SurfaceCurrent current_in_domain(const OverlayMesh& m, const Margin& in_other, bool over_hull, const Clip* clip) {
  Array<unsigned char> kept(m.t.real);
  for_each_index(m.t.real, [&](std::size_t i) {
    const auto& v = m.t.triangles[i].v;
    const bool inside = over_hull || (in_other.covers(v[0]) && in_other.covers(v[1]) && in_other.covers(v[2]));
    kept[i] = inside && (m.kept.empty() || m.kept[i] != 0) ? 1 : 0;
  });
  return surface_current(m.t, m.xy, m.z, kept, clip);
}

}  // namespace

void check_currents(const CompareOptions& options) {
  const CurrentsOptions& o = options.currents;
  if (!asked(options)) {
    if (o.sigma != 0) throw UsageError("--sigma: it is the width of the kernel of currents: add --measure currents");
    if (o.error != CurrentsOptions{}.error) throw UsageError("--currents-error: it needs --measure currents");
    return;
  }
  CurrentsOptions chosen = o;
  if (chosen.sigma == 0) chosen.sigma = 1;  // not known yet
  check(chosen);
  if (options.interpolation == Interpolation::cubic)
    throw UsageError("--measure currents: they are of plane triangles: leave --interpolation cubic out");
}

void check_currents_units(const Cloud& a, const Cloud& b, const Comparison& c) {
  if (!asked(c.options) || !c.options.unit.empty()) return;
  const std::string& heights = a.vertical_unit != "unknown" ? a.vertical_unit : b.vertical_unit;
  if (c.unit == "deg" || (c.unit != "unknown" && heights != "unknown" && heights != c.unit))
    throw InputError(fmt::format(
        "--measure currents: x and y are in {}, heights in {}, so distances in space mean nothing: convert one of them",
        c.unit, heights));
}

void measure_currents(const OverlayMesh& m1, const OverlayMesh& m2, const Borders& borders, const Clip* clip,
                      Comparison& c, const Context& context) {
  if (!asked(c.options)) return;
  const bool over_hull = c.options.domain == DomainKind::hull;
  const SurfaceCurrent a = current_in_domain(m1, borders.measured_2().other, over_hull, clip),
                       b = current_in_domain(m2, borders.measured_1().other, over_hull, clip);
  for (const auto& [current, role] : {std::pair{&a, "A"}, std::pair{&b, "B"}})
    if (current->centroids.empty())
      throw OverlapError(fmt::format(
          "--measure currents: no triangle of {} lies whole over the other scan{}: take scans that share more area, or "
          "--domain hull",
          role, clip != nullptr ? " and in part inside the polygons or the mask" : ""));
  CurrentsOptions options = c.options.currents;
  if (options.sigma == 0) options.sigma = default_sigma(a, b);
  c.currents =
      CurrentsComparison{currents(a.view(), b.view(), options, context), a.centroids.size(), b.centroids.size()};
  const Currents& found = c.currents->sums;
  if (!found.reached)
    c.warnings.push_back(
        "--measure currents: the asked error was not reached: the surfaces fold so often within --sigma "
        "that their normals cancel; the bounds in the result hold");
  else if (found.error_bound > poor_rho * found.rho)
    c.warnings.push_back(
        fmt::format("--measure currents: the scans are so alike that rho is known to {:.1e} only, and is {:.1e}: for "
                    "more digits give "
                    "a smaller --currents-error",
                    found.error_bound, found.rho));
}

}  // namespace isopach::stages
