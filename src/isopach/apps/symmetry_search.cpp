#include "isopach/apps/symmetry_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/apps/symmetry_check.hpp"
#include "isopach/apps/symmetry_start.hpp"
#include "isopach/base/error.hpp"
#include "isopach/match/match.hpp"

namespace isopach {
namespace {

constexpr int most_rounds = 5;         // of match and turn; two are usual
constexpr double stands_still = 1e-6;  // of the size of the face: a plane that moves less has been found,
constexpr double still_enough = 0.1;   // … or one that moves less than this share of its standard deviation
// A jackknife over six parts is itself uncertain by a third, and of six that all move the plane the largest counts: on
// faces with independent noise, 1.3 made pulls of 0.7 (bench/pulls.py). Of two real faces of three it is 4 to 5 times
// larger.
constexpr double clearly_larger = 2;

void believe_if_larger(double& sigma, double jackknife) {
  if (jackknife > clearly_larger * sigma) sigma = jackknife;
}

}  // namespace

FoundPlane refined_plane(const Array<Point3>& points, const Upright& start, const Point3& towards,
                         const AsymmetryOptions& o, const Context& context) {
  const MatchOptions options = mirror_match_options(o, false);
  const Context silent = without_progress(context);
  FoundPlane f;
  f.place = start;
  for (int round = 0; round < most_rounds; ++round) {
    context.step("match", static_cast<double>(round) / most_rounds);
    const Cloud face = placed(points, f.place);
    const Matching m = match(mirrored(face), face, options, silent);
    const Reflection found = reflection_of(m.pose);
    const double size = size_of(face);
    f.place = f.place.after(found, towards);
    f.iterations += m.iterations;
    f.converged = m.converged;
    f.reason = m.reason;
    f.overlap = m.overlap;
    f.plane.twist = found.twist, f.plane.glide = found.glide;
    describe_sigma(m, f.plane.sigma_angle, f.plane.sigma_offset);
    const double moved = size * std::hypot(found.normal.y, found.normal.z) + std::fabs(found.offset);
    const double sigma = size * f.plane.sigma_angle * std::numbers::pi / 180 + f.plane.sigma_offset;
    if (moved < std::max(stands_still * size, still_enough * sigma) || !m.converged) break;
    if (round + 1 == most_rounds && moved > sigma)
      f.warnings.push_back(fmt::format(
          "the symmetry plane still moved by {:.2g} of the size of the face when the search ended, more than its "
          "standard deviation: take it as approximate",
          moved / size));
  }
  return f;
}

FoundPlane agreed_plane(const Array<Point3>& points, const Upright& start, const Point3& towards,
                        const AsymmetryOptions& o, const std::string& path, const Context& context) {
  const Context silent = without_progress(context);
  FoundPlane f = refined_plane(points, start, towards, o, context);
  f.sides = symmetry_evidence(placed(points, f.place), silent);
  if (!is_symmetric(*f.sides)) {
    const std::optional<Upright> other = other_plane(points, f.place, towards, o, silent);
    if (other) {
      FoundPlane second = refined_plane(points, *other, towards, o, silent);
      second.sides = symmetry_evidence(placed(points, second.place), silent);
      if (is_symmetric(*second.sides)) f = std::move(second);
    }
  }
  if (!is_symmetric(*f.sides)) {
    if (!o.accept_doubt)
      throw Error(ExitCode::not_converged,
                  fmt::format("{}: the plane that was found is not one of symmetry: {}: keep more of the other side in "
                              "the scan, give @across from side to side, or "
                              "take the plane as it is by @accept-doubt",
                              path.empty() ? "the scan" : path, sides_sentence(*f.sides)));
    f.warnings.push_back("the plane that was found is not one of symmetry: " + sides_sentence(*f.sides));
  }
  const PlaneSigma jackknife = plane_sigma(points, f.place, o, silent);
  believe_if_larger(f.plane.sigma_angle, jackknife.angle);
  believe_if_larger(f.plane.sigma_offset, jackknife.offset);
  return f;
}

}  // namespace isopach
