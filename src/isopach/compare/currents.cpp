#include "isopach/compare/currents.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "isopach/base/parallel.hpp"
#include "isopach/measure/currents/current.hpp"

namespace isopach::stages {

namespace {

/// A ρ known no better than this is told with a warning.
constexpr double poor_rho = 0.05;

bool asked(const CompareOptions& options) { return options.measure == MeasureKind::currents; }

/// What a scan supports of the plane: the sides that its kept triangles share with no other kept one. Sides of a
/// triangulation do not cross, so they always bound a region.
Region footprint_of(const OverlayMesh& m) {
  const auto keeps = [&](Index i) { return !m.t.is_ghost(i) && (m.kept.empty() || m.kept[i] != 0); };
  Region region;
  for (Index i = 0; i < m.t.real; ++i) {
    if (!keeps(i)) continue;
    const Triangle& triangle = m.t.triangles[i];
    for (Index k = 0; k < 3; ++k)
      if (!keeps(triangle_of(triangle.n[k])))
        region.edges.push_back({m.xy[triangle.v[k]], m.xy[triangle.v[next_side(k)]]});
  }
  auto parts = trapezoids(region.edges);
  if (!parts) throw Error(ExitCode::internal, "the footprint of a scan crosses itself: please report this");
  region.parts = std::move(*parts);
  return region;
}

/// The kept triangles of a scan, cut to the domain and, unless over the hull, to the footprint of the other scan.
SurfaceCurrent current_in_domain(const OverlayMesh& m, const OverlayMesh& other, bool over_hull, const Domain& domain) {
  if (over_hull) return surface_current(m.t, m.xy, m.z, m.kept, domain);
  std::vector<Region> footprint;
  footprint.push_back(footprint_of(other));
  Domain shared = domain;
  shared.keep(Regions(std::move(footprint), m.t.real));
  return surface_current(m.t, m.xy, m.z, m.kept, shared);
}

}  // namespace

void check_currents(const CompareOptions& options) {
  const CurrentsOptions& o = options.currents;
  if (!asked(options)) {
    if (o.sigma != 0)
      throw UsageError(
          "@sigma: it is the width of the kernel of currents: add @measure currents; the noise of the scans is given "
          "by "
          "@sigma1 and @sigma2");
    if (o.error != CurrentsOptions{}.error) throw UsageError("@currents-error: it needs @measure currents");
    return;
  }
  CurrentsOptions chosen = o;
  if (chosen.sigma == 0) chosen.sigma = 1;  // not known yet
  check(chosen);
  if (options.interpolation == Interpolation::cubic)
    throw UsageError("@measure currents: they are of plane triangles: leave @interpolation cubic out");
}

void check_currents_units(const CloudView& a, const CloudView& b, const Comparison& c) {
  if (!asked(c.options) || !c.options.unit.empty()) return;
  const std::string& heights = a.vertical_unit != "unknown" ? a.vertical_unit : b.vertical_unit;
  if (c.unit == "deg" || (c.unit != "unknown" && heights != "unknown" && heights != c.unit))
    throw InputError(fmt::format(
        "@measure currents: x and y are in {}, heights in {}, so distances in space mean nothing: convert one of them",
        c.unit, heights));
}

void measure_currents(const Pair& pair, const Domain& domain, Comparison& c, const Context& context) {
  if (!asked(c.options)) return;
  const OverlayMesh m1 = pair.mesh(0), m2 = pair.mesh(1);
  const bool over_hull = c.options.domain == DomainKind::hull;
  SurfaceCurrent a, b;
  both([&] { a = current_in_domain(m1, m2, over_hull, domain); },
       [&] { b = current_in_domain(m2, m1, over_hull, domain); });
  for (const auto& [current, role] : {std::pair{&a, "A"}, std::pair{&b, "B"}})
    if (current->centroids.empty())
      throw OverlapError(fmt::format(
          "@measure currents: no triangle of {} lies over the other scan{}: take scans that share more area, or "
          "@domain hull",
          role, !domain.is_everything() ? " and inside the polygons or the mask" : ""));
  CurrentsOptions options = c.options.currents;
  if (options.sigma == 0) options.sigma = default_sigma(a, b);
  c.currents =
      CurrentsComparison{currents(a.view(), b.view(), options, context), a.centroids.size(), b.centroids.size()};
  const Currents& found = c.currents->sums;
  if (!found.reached)
    c.warnings.push_back(
        "@measure currents: the asked error was not reached: the surfaces fold so often within @sigma "
        "that their normals cancel; the bounds in the result hold");
  else if (found.error_bound > poor_rho * found.rho)
    c.warnings.push_back(
        fmt::format("@measure currents: the scans are so alike that rho is known to {:.1e} only, and is {:.1e}: for "
                    "more digits give "
                    "a smaller @currents-error",
                    found.error_bound, found.rho));
}

}  // namespace isopach::stages
