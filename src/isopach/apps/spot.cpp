#include "isopach/apps/spot.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/apps/heights_below.hpp"
#include "isopach/apps/patches.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"

namespace isopach {
namespace {

constexpr std::size_t most_patches = 512, fewest_patches = 8;
constexpr int widths = 9;

/// Nodes of the scan, `patch` neighbours at a time.
std::vector<Index> chosen_nodes(std::size_t nodes) {
  const std::size_t patches = nodes / patch,
                    step = std::max<std::size_t>(1, (patches + most_patches - 1) / most_patches);
  std::vector<Index> chosen;
  for (std::size_t p = 0; p < patches; p += step)
    for (std::size_t k = 0; k < patch; ++k) chosen.push_back(static_cast<Index>(p * patch + k));
  return chosen;
}

/// Places that share a disc evenly (Vogel's sunflower).
std::vector<Point2> disc(double radius, std::size_t places) {
  std::vector<Point2> all;
  for (std::size_t i = 0; i < places; ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(places);
    const double r = radius * std::sqrt(share),
                 angle = static_cast<double>(i) * std::numbers::pi * (3 - std::sqrt(5.0));
    all.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  return all;
}

/// Heights of the chosen nodes above the mean of the reference over a disc about each; NaN where it does not hold all
/// of the disc.
std::vector<double> above_mean(const HeightField& scan, const std::vector<Index>& chosen, const MatchSurface& reference,
                               const std::vector<Point2>& places, const Context& context) {
  Array<Point2> xy(chosen.size() * places.size());
  for_each_index(chosen.size(), [&](std::size_t i) {
    const Point2 at = scan.xy[chosen[i]];
    for (std::size_t k = 0; k < places.size(); ++k)
      xy[i * places.size() + k] = {at.x + places[k].x, at.y + places[k].y};
  });
  const Array<double> below = heights_below(xy, reference, context);
  std::vector<double> above(chosen.size());
  for_each_index(chosen.size(), [&](std::size_t i) {
    double sum = 0;
    for (std::size_t k = 0; k < places.size(); ++k) sum += below[i * places.size() + k];
    above[i] = scan.z[chosen[i]] - sum / static_cast<double>(places.size());
  });
  return above;
}

/// NaN where too few patches are known.
double variance_about(const HeightField& scan, const std::vector<Index>& chosen, const std::vector<double>& above) {
  std::vector<double> variances;
  for (std::size_t begin = 0; begin < chosen.size(); begin += patch) {
    PatchValues<2> xy;
    PatchValues<1> d;
    for (int k = 0; k < patch; ++k) {
      const std::size_t i = begin + static_cast<std::size_t>(k);
      xy.row(k) << scan.xy[chosen[i]].x, scan.xy[chosen[i]].y;
      d[k] = above[i];
    }
    if (d.allFinite()) variances.push_back(patch_variance(xy, d));
  }
  return variances.size() < fewest_patches ? std::nan("") : median(variances);
}

}  // namespace

Spot find_spot(const HeightField& scan, const MatchSurface& reference, double spacing, double reference_sigma,
               const Context& context) {
  const std::vector<Index> chosen = chosen_nodes(scan.xy.size());
  const double cell = reference.footprint.area / std::max<double>(1, static_cast<double>(reference.xy.size()));
  const auto variance = [&](double radius) {
    const double nodes = std::numbers::pi * radius * radius / cell;
    const double own = reference_sigma * reference_sigma / std::max(2.0, nodes);
    const auto places = radius == 0 ? std::size_t{1} : static_cast<std::size_t>(std::clamp(nodes, 16.0, 256.0));
    return variance_about(scan, chosen, above_mean(scan, chosen, reference, disc(radius, places), context)) - own;
  };
  const auto noise = [](double v) { return std::sqrt(std::max(0.0, v)); };
  const double at_points = variance(0);
  double least = at_points, radius = 0;
  for (int i = 0; i < widths; ++i) {
    context.check();
    const double r = spacing / 8 * std::exp2(0.375 * i);
    if (!(std::numbers::pi * r * r >= 2 * cell)) continue;
    const double v = variance(r);
    if (v < least) least = v, radius = r;
  }
  if (radius == 0 || !(least < spot_gain * at_points)) return {0, noise(at_points)};
  return {2 * radius, noise(least)};
}

}  // namespace isopach
