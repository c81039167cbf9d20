// Relief over a square kilometre whose interpolation error is the subject: how much of a gross volume is chords.
//   smooth     one long wave; d is a plane that crosses zero
//   rough      40 waves of wavelengths 1000 to 22 m; d is a Gaussian mound and a Gaussian pit, next to nothing
//   unchanged  the rough relief twice: every volume is false
//   cliff      a step 30 m high that retreats by 5 m, on ground that rises by 0.2 m
// Nodes are independent and uniform, with as dense a border, so that the hull adds nothing.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "isopach/base/sum.hpp"
#include "isopach/simulate/model.hpp"

namespace isopach {
namespace {

enum ReliefVariant { smooth, rough, unchanged, cliff };
constexpr double side = 1000;

constexpr double slope = 0.002, zero = 250;  // of smooth: d = slope (x − zero)

double smooth_height(int epoch, double x, double y) {
  const double f1 = 20 * std::sin(x / 60) * std::cos(y / 80);
  return epoch == 1 ? f1 : f1 + slope * (x - zero);
}

struct Wave {
  double kx, ky, phase, height;  // radians per metre, radians, metres
};

constexpr int waves = 40;
constexpr double longest = 1000, shortest = 22;  // wavelengths
constexpr double steepness = 0.022;              // height over wavelength: the same for all, as on eroded ground

/// Directions turn by the golden angle and phases by √2 turns, so that no two waves are alike.
std::array<Wave, waves> make_waves() {
  std::array<Wave, waves> made{};
  for (int i = 0; i < waves; ++i) {
    const double wavelength = longest * std::pow(shortest / longest, i / (waves - 1.0));
    const double direction = i * std::numbers::pi * (3 - std::sqrt(5.0)), k = 2 * std::numbers::pi / wavelength;
    made[static_cast<std::size_t>(i)] = {k * std::cos(direction), k * std::sin(direction),
                                         i * 2 * std::numbers::pi * std::numbers::sqrt2, steepness * wavelength};
  }
  return made;
}

struct Gaussian {
  Point2 centre;
  double height, s;
  [[nodiscard]] double at(double x, double y) const {
    const double dx = x - centre.x, dy = y - centre.y;
    return height * std::exp(-(dx * dx + dy * dy) / (2 * s * s));
  }
  [[nodiscard]] double volume() const { return 2 * std::numbers::pi * s * s * height; }

  /// ∫ over u > from of the Gaussian on the line at distance v from its centre.
  [[nodiscard]] double tail(double from, double v) const {
    return height * std::exp(-v * v / (2 * s * s)) * s * std::sqrt(std::numbers::pi / 2) *
           std::erfc(from / (s * std::numbers::sqrt2));
  }
};

constexpr Gaussian mound{{350, 600}, 6, 40}, pit{{650, 350}, -4, 30};  // 8.75 s and more from the border

double rough_height(int variant, int epoch, double x, double y) {
  static const std::array<Wave, waves> relief = make_waves();
  double z = 0;
  for (const Wave& w : relief) z += w.height * std::sin(w.kx * x + w.ky * y + w.phase);
  return epoch == 2 && variant == rough ? z + mound.at(x, y) + pit.at(x, y) : z;
}

constexpr double cliff_height = 30, ramp = 2, retreat = 5, rise = 0.2,
                 foot = 500;  // it climbs over [foot, foot + ramp]

double cliff_ground(int epoch, double x) {
  const double from = epoch == 1 ? foot : foot + retreat;
  return cliff_height * std::clamp((x - from) / ramp, 0.0, 1.0) + (epoch == 1 ? 0 : rise);
}

double height(int variant, int epoch, double x, double y) {
  if (variant == cliff) return cliff_ground(epoch, x);
  return variant == smooth ? smooth_height(epoch, x, y) : rough_height(variant, epoch, x, y);
}

/// The pit wins over the mound inside a circle. With u from the mound to the pit and v across, each line v = const is
/// an erfc; the rule of trapezia over v converges faster than any power, for the integrand is smooth and fades to 0.
double rough_below() {
  const double distance = std::hypot(pit.centre.x - mound.centre.x, pit.centre.y - mound.centre.y);
  const double p = 1 / (2 * pit.s * pit.s), m = 1 / (2 * mound.s * mound.s), a = p - m;
  Sum below;
  const double step = 0.5;
  for (int i = -600; i <= 600; ++i) {
    const double v = i * step;
    const double c = p * distance * distance + a * v * v - std::log(-pit.height / mound.height);
    const double root = std::sqrt(p * distance * p * distance - a * c);  // the circle's radius is over 900: real
    const double u = c / (p * distance + root);                          // its near side
    below.add(-step * (pit.tail(u - distance, v) + mound.tail(u, v)));
  }
  return below.value();
}

Truth truth(int variant, const Outline& footprint) {
  Truth truth;
  truth.area = polygon_area(footprint);
  if (variant == smooth) {
    truth.above = slope / 2 * side * (side - zero) * (side - zero);
    truth.below = slope / 2 * side * zero * zero;
    truth.net = truth.above - truth.below;
  } else if (variant == rough) {
    truth.net = mound.volume() + pit.volume();
    truth.below = rough_below();
    truth.above = truth.net + truth.below;
    truth.error = 1e-6;  // rounding; 10⁻¹⁷ of the mound lies beyond the border, of the pit less
    truth.parts = {{"mound", mound.volume()}, {"pit", pit.volume()}};
  } else if (variant == cliff) {  // d = rise outside the band; at either end of it a corner of d stays above 0
    const double corner = rise * rise * ramp / cliff_height / 2;
    truth.above = side * (rise * (side - retreat - ramp) + 2 * corner);
    truth.net = side * (rise * side - cliff_height * retreat);
    truth.below = truth.above - truth.net;
  }
  return truth;
}

Outline footprint(int, const SceneOptions&) { return rectangle({0, 0}, {side, side}); }

Array<Point2> nodes(int epoch, const Outline& footprint, std::size_t count, std::uint64_t seed) {
  return bordered_nodes(footprint, count, {seed, static_cast<std::uint64_t>(epoch)});
}

}  // namespace

SceneModel relief_scene() {
  SceneModel model;
  model.name = "relief";
  model.description = "smooth or rough relief, changed a little: what interpolation adds to a gross volume";
  model.unit = "m";
  model.variants = {"smooth", "rough", "unchanged", "cliff"};
  model.height = height;
  model.footprint = footprint;
  model.truth = truth;
  model.nodes = nodes;
  return model;
}

}  // namespace isopach
