// One square kilometre of hills, flown over twice. Between the flights a landslide came down, a mound was raised and a pit
// dug. The supports of these changes are disjoint and well inside, so the truth is the sum of their closed forms.
//
// The hills are a sum of waves no shorter than 85 m, in coordinates that are themselves bent by waves, which hides the
// regularity of the sum: 100 000 points (3 m apart) resolve them to a centimetre.
#include <cmath>
#include <numbers>

#include "isopach/simulate/bump.hpp"
#include "isopach/simulate/model.hpp"

namespace isopach {
namespace {

constexpr Point2 origin{412000, 5236000};
constexpr double side = 1000;

double wave(double phase) { return std::sin(2 * std::numbers::pi * phase); }

struct Wave {
  double kx, ky;  // cycles per kilometre
  double phase;   // cycles
  double height;  // m
};

constexpr Wave waves[] = {
    {0.62, 0.35, 0.10, 13.0}, {-0.48, 0.93, 0.52, 9.0},  {1.55, 0.80, 0.83, 4.2},  {-1.10, 1.75, 0.27, 3.6},
    {2.60, -1.70, 0.61, 2.2}, {1.35, 3.10, 0.05, 1.9},   {4.70, 2.30, 0.44, 0.95}, {-3.10, 4.40, 0.91, 0.90},
    {6.90, -4.80, 0.33, 0.42}, {4.10, 7.60, 0.72, 0.40}, {9.30, 4.10, 0.18, 0.22}, {-6.20, 8.10, 0.57, 0.22},
};

double hills(double x, double y) {
  const double u = (x - origin.x) / 1000, v = (y - origin.y) / 1000;
  const double bent_u = u + 0.055 * wave(1.3 * v + 0.4 * u + 0.15);
  const double bent_v = v + 0.050 * wave(1.2 * u - 0.5 * v + 0.70);
  double z = 820;
  for (const Wave& w : waves) z += w.height * wave(w.kx * bent_u + w.ky * bent_v + w.phase);
  return z;
}

constexpr double bulking = 1.25;  // loosened soil: the deposit holds more than the scar

struct Changes {
  Bump scar{{origin.x + 420, origin.y + 640}, -7, 70, 45, {0.6, -0.8}, 0.002, -0.5};
  Bump deposit{{origin.x + 520, origin.y + 500}, 7 * bulking * (70 * 45) / (80 * 60.0), 80, 60, {0.6, -0.8}, -0.001, 0.4};
  Bump mound{{origin.x + 760, origin.y + 740}, 6, 34, 26, {0.8, 0.6}, 0, 0};
  Bump pit{{origin.x + 240, origin.y + 260}, -5, 28, 22, {1, 0}, 0, 0};
};

double height(int, int epoch, double x, double y) {
  double z = hills(x, y);
  if (epoch == 2) {
    static constexpr Changes changes;
    for (const Bump* bump : {&changes.scar, &changes.deposit, &changes.mound, &changes.pit}) z += bump->at(x, y);
  }
  return z;
}

Footprint footprint(int, const SceneOptions&) { return rectangle(origin, {origin.x + side, origin.y + side}); }

Truth truth(int, const Footprint& footprint) {
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

/// First flight: an oscillating mirror, eastwards. Second: a turning mirror, northwards.
Array<Point2> nodes(int epoch, const Footprint& footprint, std::size_t count, std::uint64_t seed) {
  const ScanPattern first{0.14, 2, 0.3, true, 1.4, 0.15}, second{1.69, 2, 0.2, false, 1.2, 0.2};
  return scan_nodes(footprint, count, epoch == 1 ? first : second, {seed, static_cast<std::uint64_t>(epoch)});
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
