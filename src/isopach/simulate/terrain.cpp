// One square kilometre of hills, flown over twice. Between the flights a landslide came down, a mound was raised and a
// pit dug. The supports of these changes are disjoint and well inside, so the truth is the sum of their closed forms.
//
// The hills are a winding valley with ravines, built of smooth waves; 100 000 points (3 m apart) resolve them to a
// centimetre nearly everywhere, less than the default noise.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/simulate/bump.hpp"
#include "isopach/simulate/model.hpp"

namespace isopach {
namespace {

constexpr Point2 origin{412000, 5236000};
constexpr double side = 1000;

double wave(double phase) { return std::sin(2 * std::numbers::pi * phase); }

/// From 0 to about 1, period 1: rounded spurs between narrow ravines, as running water leaves them.
double ravine(double phase) {
  const double s = std::sin(std::numbers::pi * phase);
  return std::sqrt(s * s + 0.04) - 0.2;
}

struct Wave {
  double kx, ky;  // cycles per kilometre
  double phase;   // cycles
  double height;  // m
};

constexpr Wave waves[] = {
    {0.62, 0.35, 0.10, 5.0},  {-1.10, 1.75, 0.27, 2.6}, {2.60, -1.70, 0.61, 1.4}, {1.35, 3.10, 0.05, 1.2},
    {-3.10, 4.40, 0.91, 0.6}, {6.90, -4.80, 0.33, 0.3}, {4.10, 7.60, 0.72, 0.3},
};

/// A winding valley with ravines on both slopes; they fade out towards the valley floor and the ridges.
double hills(double x, double y) {
  const double u = (x - origin.x) / 1000, v = (y - origin.y) / 1000;
  const double bent_u = u + 0.03 * wave(1.9 * v + 0.7 * u + 0.15) + 0.012 * wave(4.1 * v - 1.7 * u);
  const double bent_v = v + 0.03 * wave(1.7 * u - 0.9 * v + 0.70) + 0.012 * wave(3.7 * u + 2.3 * v + 0.4);
  const double along = 0.8 * bent_u + 0.6 * bent_v;
  const double across = 0.8 * bent_v - 0.6 * bent_u - 0.02 + 0.05 * wave(1.3 * along);
  const double rise = across * across / (across * across + 0.07);  // 0 on the valley floor, towards 1 on the ridges
  const double bank = std::tanh(across / 0.08);  // −1 and 1: the two slopes have ravines of their own
  const double spurs = 15 * ravine(3.6 * along + 0.9 * bank * across + 0.2 * bank) +
                       6 * ravine(7.7 * along - 1.6 * bank * across + 0.35 * bank + 0.3);
  double z = 790 + 12 * along + 52 * rise + 4 * rise * (1 - rise) * spurs;
  for (const Wave& w : waves) z += w.height * wave(w.kx * u + w.ky * v + w.phase);
  return z;
}

constexpr double bulking = 1.25;  // loosened soil: the deposit holds more than the scar

struct Changes {
  Bump scar{{origin.x + 290, origin.y + 625}, -18, 150, 85, {0.8, -0.6}, 0.001, -0.5};
  Bump deposit{
      {origin.x + 520, origin.y + 455}, 18 * bulking*(150 * 85) / (135.0 * 115), 135, 115, {0.8, -0.6}, -0.0007, 0.4};
  Bump mound{{origin.x + 560, origin.y + 880}, 10, 55, 42, {0.8, 0.6}, 0, 0};
  Bump pit{{origin.x + 345, origin.y + 235}, -8, 40, 34, {1, 0}, 0, 0};
};

double height(int, int epoch, double x, double y) {
  double z = hills(x, y);
  if (epoch == 2) {
    static constexpr Changes changes;
    for (const Bump* bump : {&changes.scar, &changes.deposit, &changes.mound, &changes.pit}) z += bump->at(x, y);
  }
  return z;
}

Outline footprint(int, const SceneOptions&) { return rectangle(origin, {origin.x + side, origin.y + side}); }

Truth truth(int, const Outline& footprint) {
  const Changes changes;
  Truth truth;
  truth.area = polygon_area(footprint);
  truth.above = changes.deposit.volume() + changes.mound.volume();
  truth.below = -changes.scar.volume() - changes.pit.volume();
  truth.net = truth.above - truth.below;
  truth.parts = {{"landslide_deposit", changes.deposit.volume()},
                 {"landslide_net", changes.deposit.volume() + changes.scar.volume()},
                 {"landslide_scar", changes.scar.volume()},
                 {"mound", changes.mound.volume()},
                 {"pit", changes.pit.volume()}};
  return truth;
}

/// First flight: an oscillating mirror, eastwards. Second: a turning mirror, northwards. The survey is cut along its
/// border, so its hull is the rectangle: without these nodes slivers along the hull would add volume that the truth
/// does not have.
Array<Point2> nodes(int epoch, const Outline& footprint, std::size_t count, std::uint64_t seed) {
  const ScanPattern first{0.14, 2, 0.2, true, 1.4, 0.15}, second{1.69, 2, 0.2, false, 1.2, 0.2};
  const Draw draw{seed, static_cast<std::uint64_t>(epoch)};
  const double spacing = std::sqrt(polygon_area(footprint) / static_cast<double>(count));
  const Array<Point2> cut = border_nodes(footprint, spacing, draw);
  const std::size_t inside = count - std::min(count / 2, cut.size());
  Array<Point2> nodes = scan_nodes(footprint, inside, epoch == 1 ? first : second, draw);
  nodes.insert(nodes.end(), cut.begin(), cut.end());
  return nodes;
}

}  // namespace

SceneModel terrain_scene() {
  SceneModel model;
  model.name = "terrain";
  model.description = "two airborne laser scans of hills: between them a landslide, a mound and a pit";
  model.unit = "m";
  model.defaults.points_a = 100000;
  model.defaults.points_b = 140000;
  model.defaults.noise_a = model.defaults.noise_b = 0.03;
  model.least_points = 100;
  model.steps_per_unit = 1000;
  model.height = height;
  model.footprint = footprint;
  model.truth = truth;
  model.nodes = nodes;
  return model;
}

}  // namespace isopach
