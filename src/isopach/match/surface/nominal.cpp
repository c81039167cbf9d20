#include "isopach/match/surface/nominal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/verdict/judged_scan.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {
namespace {

constexpr std::size_t least_patch = 16, facets_a_patch = 4, least_patches = 16;
constexpr double bound = 4.685;  // standard deviations of noise: more is a change
constexpr double sure = 3;       // standard errors
constexpr double halfway = 0.5;  // between facets and what is curved
constexpr double middle_bubble = 1.1,
                 corner_bubble = 0.8;  // bubbles of a facet: as much of its area lies beyond each, nearly
constexpr double least_excess = 0.1;   // of the square rise: less biases nothing

/// A node over a facet.
struct Over {
  double height = std::numeric_limits<double>::quiet_NaN();  ///< above it; NaN: over none
  double rise = 0;                                           ///< of the surface there
  double bubble = 0;                                         ///< 0 at the corners of the facet, 4/3 in its middle
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
    over[i] = {heights[i] - facet, target.facets[at.id].height(places[i].x, places[i].y) - facet,
               flat.bubble(places[i].x - flat.x, places[i].y - flat.y)};
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
  double in_middle = 0, at_corners = 0, raised = 0;  // Σ height² about the mean, and Σ rise² of the middle
  std::size_t middles = 0, corners = 0;
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
    const double r = over[i].rise - rise / n, h = over[i].height - height / n;
    sums.shared += h * r, sums.own += r * r;
    if (over[i].bubble >= middle_bubble)
      ++sums.middles, sums.in_middle += h * h, sums.raised += over[i].rise * over[i].rise;
    if (over[i].bubble <= corner_bubble) ++sums.corners, sums.at_corners += h * h;
  }
  return sums;
}

/// The share, and its error by the spread of the patches.
void estimate_share(const std::vector<PatchSums>& patches, RiseShown& shown) {
  Sum shared, own, squares;
  for (const PatchSums& s : patches) shared.add(s.shared), own.add(s.own);
  shown.share = shared.value() / own.value();
  for (const PatchSums& s : patches) squares.add(std::pow(s.shared - shown.share * s.own, 2));
  shown.error = std::sqrt(squares.value()) / own.value();
}

/// The excess of the middle, likewise.
void estimate_excess(const std::vector<PatchSums>& patches, RiseShown& shown) {
  Sum in_middle, at_corners, raised, squares;
  double middles = 0, corners = 0;
  for (const PatchSums& s : patches) {
    in_middle.add(s.in_middle), at_corners.add(s.at_corners), raised.add(s.raised);
    middles += static_cast<double>(s.middles), corners += static_cast<double>(s.corners);
  }
  if (!(middles > 0 && corners > 0 && raised.value() > 0)) return;
  const double of_middle = in_middle.value() / middles, of_corners = at_corners.value() / corners;
  const double square_rise = raised.value() / middles;
  shown.excess = (of_middle - of_corners) / square_rise;
  for (const PatchSums& s : patches) {
    const double own = (s.in_middle - of_middle * static_cast<double>(s.middles)) / middles -
                       (s.at_corners - of_corners * static_cast<double>(s.corners)) / corners;
    squares.add(own * own);
  }
  shown.excess_error = std::sqrt(squares.value()) / square_rise;
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
  for (std::size_t begin = 0; begin < over.size(); begin += patch) {
    const PatchSums s = sums_of(over, begin, std::min(over.size(), begin + patch), most);
    if (s.own > 0) patches.push_back(s);
  }
  if (patches.size() < least_patches) return {1, 1, 0, 0, 0};
  RiseShown shown;
  shown.patches = patches.size();
  estimate_share(patches, shown);
  estimate_excess(patches, shown);
  return shown;
}

bool is_nominal(const RiseShown& shown) {
  const bool even = std::fabs(shown.excess) <= std::max(least_excess, sure * shown.excess_error);
  return shown.patches > 0 && std::fabs(shown.share) + sure * shown.error < halfway && even;
}

bool could_be_nominal(const RiseShown& shown) {
  return shown.patches > 0 && std::fabs(shown.share) - sure * shown.error < halfway;
}

bool may_be_nominal(const CloudView& cloud) { return !cloud.faces.empty() || cloud.format == "stl"; }

Cloud points_on_faces(const CloudView& mesh, std::size_t count, std::uint64_t seed) {
  check_faces(mesh);
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
