#include "isopach/match/nominal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/judged_scan.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {
namespace {

constexpr std::size_t least_patch = 16, facets_a_patch = 4, least_patches = 16;
constexpr double bound = 4.685;  // standard deviations of noise: more is a change
constexpr double sure = 3;       // standard errors
constexpr double halfway = 0.5;  // between facets and what is curved

/// A node over a facet.
struct Over {
  double height = std::numeric_limits<double>::quiet_NaN();  ///< above it; NaN: over none
  double rise = 0;                                           ///< of the surface there
};

std::vector<Over> nodes_over(const MatchSurface& nodes, const MatchSurface& target, const Motion& motion, bool inverse,
                             const Context& context) {
  const std::size_t n = nodes.xy.size();
  Array<Point2> places(n);
  Array<double> heights(n);
  for_each_index(n, [&](std::size_t i) {
    const Point3 own{nodes.xy[i].x, nodes.xy[i].y, nodes.z[i]}, there = inverse ? motion.undo(own) : motion.apply(own);
    places[i] = {there.x, there.y};
    heights[i] = there.z;
  });
  const Locations where = localise_in_order(places, target.t, target.xy, context);
  std::vector<Over> over(n);
  for_each_index(n, [&](std::size_t i) {
    const Location at = where[i];
    if (at.kind != Location::Kind::triangle || !target.facets[at.id].exists()) return;
    Facet flat = target.facets[at.id];
    flat.rise = 0;
    const double facet = flat.height(places[i].x, places[i].y);
    over[i] = {heights[i] - facet, target.facets[at.id].height(places[i].x, places[i].y) - facet};
  });
  return over;
}

/// Standard deviation of the noise, from the smaller of the residuals from facets and from raised facets.
double noise_of(const std::vector<Over>& over) {
  std::vector<double> flat, raised;
  for (const Over& o : over)
    if (!std::isnan(o.height)) flat.push_back(std::fabs(o.height)), raised.push_back(std::fabs(o.height - o.rise));
  return mad_to_sigma * std::min(median(flat), median(raised));
}

struct PatchSums {
  double shared = 0, own = 0;  // Σ height · rise and Σ rise², both about their means over the patch
};

PatchSums sums_of(const std::vector<Over>& over, std::size_t begin, std::size_t end, double most) {
  const auto counts = [&](const Over& o) {
    return std::min(std::fabs(o.height), std::fabs(o.height - o.rise)) <= most;  // not NaN
  };
  double n = 0, height = 0, rise = 0;
  for (std::size_t i = begin; i < end; ++i)
    if (counts(over[i])) ++n, height += over[i].height, rise += over[i].rise;
  PatchSums sums;
  if (n < 4) return sums;
  for (std::size_t i = begin; i < end; ++i) {
    if (!counts(over[i])) continue;
    const double r = over[i].rise - rise / n;
    sums.shared += (over[i].height - height / n) * r, sums.own += r * r;
  }
  return sums;
}

}  // namespace

RiseShown rise_shown(const MatchSurface& nodes, const MatchSurface& target, const Motion& motion, bool inverse,
                     const Context& context) {
  context.check();
  const std::vector<Over> over = nodes_over(nodes, target, motion, inverse, context);
  const double most = bound * noise_of(over);
  const std::size_t of_facet = nodes.xy.size() / std::max<std::size_t>(1, target.t.real);
  const std::size_t patch = std::max(least_patch, facets_a_patch * of_facet);
  std::vector<PatchSums> patches;
  Sum shared, own;
  for (std::size_t begin = 0; begin < over.size(); begin += patch) {
    const PatchSums s = sums_of(over, begin, std::min(over.size(), begin + patch), most);
    if (!(s.own > 0)) continue;
    patches.push_back(s);
    shared.add(s.shared), own.add(s.own);
  }
  if (patches.size() < least_patches) return {};
  RiseShown shown{shared.value() / own.value(), 0, patches.size()};
  Sum squares;
  for (const PatchSums& s : patches) squares.add(std::pow(s.shared - shown.share * s.own, 2));
  shown.error = std::sqrt(squares.value()) / own.value();
  return shown;
}

bool is_nominal(const RiseShown& shown) { return shown.patches > 0 && shown.share + sure * shown.error < halfway; }

bool is_undecided(const RiseShown& shown) {
  return shown.patches > 0 && !is_nominal(shown) && shown.share - sure * shown.error < halfway;
}

bool may_be_nominal(const Cloud& cloud) { return !cloud.faces.empty() || cloud.format == "stl"; }

Cloud points_on_faces(const Cloud& mesh, std::size_t count, std::uint64_t seed) {
  const auto area = [&](const std::array<Index, 3>& face) {
    const Point3 &a = mesh.points[face[0]], &b = mesh.points[face[1]], &c = mesh.points[face[2]];
    const double size = length(cross(b - a, c - a)) / 2;
    return std::isfinite(size) ? size : 0;
  };
  Sum total;
  for (const auto& face : mesh.faces) total.add(area(face));
  Cloud points;
  points.path = mesh.path;
  if (!(total.value() > 0)) return points;
  const double density = static_cast<double>(count) / total.value();
  for (const auto& face : mesh.faces) {
    std::array<Point3, 3> p{mesh.points[face[0]], mesh.points[face[1]], mesh.points[face[2]]};
    std::sort(p.begin(), p.end(), [](const Point3& a, const Point3& b) {
      return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    });
    std::uint64_t key = seed;
    for (const Point3& corner : p) key = point_key(corner, key);
    const RandomStream random(key, 0);
    const auto own = static_cast<std::uint64_t>(area(face) * density + random.uniform(0));
    for (std::uint64_t i = 0; i < own; ++i) {
      double u = random.uniform(2 * i + 1), v = random.uniform(2 * i + 2);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      points.points.push_back(p[0] + u * (p[1] - p[0]) + v * (p[2] - p[0]));
    }
  }
  return points;
}

void take_as_nominal(MatchSurface& s, bool with_nodes) {
  for_each_index(s.facets.size(), [&](std::size_t i) { s.facets[i].rise = 0; });
  if (!with_nodes) std::fill(s.weight.begin(), s.weight.end(), 0.0);
}

}  // namespace isopach
