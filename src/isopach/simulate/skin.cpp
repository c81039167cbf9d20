// A piece of skin, mm: form, waviness, fine relief and wrinkles of known depth and volume; in the second scan two of
// the wrinkles are shallower, as after a treatment. Variant waves: one wave, whose roughness is known in closed
// form; in the second scan it has half the amplitude.
#include <cmath>
#include <numbers>

#include "isopach/simulate/bump.hpp"
#include "isopach/simulate/model.hpp"

namespace isopach {
namespace {

enum Variant { wrinkled, waves };
constexpr double width = 40, depth = 30, turn = 2 * std::numbers::pi;

struct SkinWrinkle {
  const char* name;
  Bump groove;
  double after;  ///< share of its depth in the second scan
};
constexpr SkinWrinkle wrinkles[] = {
    {"wrinkle_1", {{12, 9}, -0.30, 9, 0.9, {1, 0}, 0.01, 0}, 0.5},
    {"wrinkle_2", {{29, 17}, -0.20, 8, 0.8, {0.8, 0.6}, -0.015, 0}, 0.6},
    {"wrinkle_3", {{20, 25}, -0.12, 7, 0.8, {1, 0}, 0.008, 0}, 1},
};

constexpr double wave_amplitude = 0.05, wave_length = 2;

double height(int variant, int epoch, double x, double y) {
  if (variant == waves) return (epoch == 1 ? 1 : 0.5) * wave_amplitude * std::cos(turn * x / wave_length);
  const double u = x - width / 2;
  double z = 0.02 * x - 0.01 * y - 0.004 * u * u;                       // form
  z += 0.08 * std::sin(turn * x / width) * std::cos(turn * y / depth);  // waviness
  z += 0.012 * std::sin(turn * x / 1.25) * std::sin(turn * y / 1.25);   // relief
  for (const SkinWrinkle& w : wrinkles) z += (epoch == 1 ? 1 : w.after) * w.groove.at(x, y);
  return z;
}

Outline footprint(int, const SceneOptions&) { return rectangle({0, 0}, {width, depth}); }

Truth truth(int variant, const Outline& footprint) {
  Truth truth;
  truth.area = polygon_area(footprint);
  if (variant == waves) {  // the mean of |cos| is 2/π, half of it on either side
    truth.above = truth.below = truth.area * (wave_amplitude / 2) / std::numbers::pi;
    return truth;
  }
  for (const SkinWrinkle& w : wrinkles) {
    const double filled = (w.after - 1) * w.groove.volume();
    truth.parts[w.name] = filled;
    truth.above += filled;
  }
  truth.net = truth.above;
  return truth;
}

Array<Point2> nodes(int epoch, const Outline& footprint, std::size_t count, std::uint64_t seed) {
  return bordered_nodes(footprint, count, {seed, static_cast<std::uint64_t>(epoch)});
}

}  // namespace

SceneModel skin_scene() {
  SceneModel model;
  model.name = "skin";
  model.description = "skin before and after a treatment that makes wrinkles shallower";
  model.unit = "mm";
  model.variants = {"wrinkled", "waves"};
  model.defaults.points_a = model.defaults.points_b = 120000;
  model.defaults.noise_a = model.defaults.noise_b = 0.002;
  model.height = height;
  model.footprint = footprint;
  model.truth = truth;
  model.nodes = nodes;
  return model;
}

}  // namespace isopach
