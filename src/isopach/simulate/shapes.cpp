// Scenes whose difference is a plane, a paraboloid or a cone. The hull of every scan is the footprint exactly, so that
// the planes are reproduced to rounding and the others converge with the spacing of the points.
#include <cmath>
#include <numbers>

#include "isopach/simulate/model.hpp"

namespace isopach {
namespace {

Array<Point2> bordered(int epoch, const Outline& footprint, std::size_t count, std::uint64_t seed) {
  return bordered_nodes(footprint, count, {seed, static_cast<std::uint64_t>(epoch)});
}

SceneModel shape_scene(const char* name, const char* description) {
  SceneModel model;
  model.name = name;
  model.description = description;
  model.unit = "m";
  model.defaults.points_a = 20000;
  model.defaults.points_b = 30000;
  model.nodes = bordered;
  return model;
}

// plane -------------------------------------------------------------------------------------------------------------

enum PlaneVariant { lifted, tilted };
constexpr double lift = 0.25;
constexpr double width = 100, depth = 80;               // of the rectangle of the tilted variant
constexpr double slope = 0.04, zero = 40, slant = 0.3;  // d = slope (x − zero − slant (y − depth/2))

double plane_height(int variant, int epoch, double x, double y) {
  const double f1 = 10 + 0.1 * x - 0.05 * y;
  if (epoch == 1) return f1;
  return f1 + (variant == lifted ? lift : slope * (x - zero - slant * (y - depth / 2)));
}

Outline plane_footprint(int variant, const SceneOptions&) {
  if (variant == tilted) return rectangle({0, 0}, {width, depth});
  return {{0, 12}, {31, 0}, {78, 5}, {100, 34}, {94, 71}, {58, 90}, {11, 66}};
}

/// Tilted: d is zero on a line that crosses the sides y = 0 and y = depth; each part is the integral over y of a
/// triangle.
Truth plane_truth(int variant, const Outline& footprint) {
  Truth truth;
  truth.area = polygon_area(footprint);
  if (variant == lifted) {
    truth.above = truth.net = truth.area * lift;
    return truth;
  }
  const double spread = slant * slant * depth * depth * depth / 12;
  truth.above = slope / 2 * (depth * (width - zero) * (width - zero) + spread);
  truth.below = slope / 2 * (depth * zero * zero + spread);
  truth.net = truth.above - truth.below;
  return truth;
}

// paraboloid and cone -----------------------------------------------------------------------------------------------

constexpr double half = 50;         // the square |x|, |y| <= half
constexpr double zero_radius = 35;  // d > 0 inside
constexpr double apex = 4;          // d at the centre

double base_height(double x, double y) { return 0.05 * x + 0.02 * y; }

double paraboloid_height(int, int epoch, double x, double y) {
  return base_height(x, y) + (epoch == 1 ? 0 : apex * (1 - (x * x + y * y) / (zero_radius * zero_radius)));
}

double cone_height(int, int epoch, double x, double y) {
  return base_height(x, y) + (epoch == 1 ? 0 : apex * (1 - std::sqrt(x * x + y * y) / zero_radius));
}

Outline square(int, const SceneOptions&) { return rectangle({-half, -half}, {half, half}); }

Truth round_truth(const Outline& footprint, double above, double net) {
  Truth truth;
  truth.area = polygon_area(footprint);
  truth.above = above;
  truth.net = net;
  truth.below = above - net;
  return truth;
}

Truth paraboloid_truth(int, const Outline& footprint) {
  const double square_r2 = 8 * half * half * half * half / 3;  // ∬ r² over the square
  return round_truth(footprint, std::numbers::pi * apex * zero_radius * zero_radius / 2,
                     apex * (4 * half * half - square_r2 / (zero_radius * zero_radius)));
}

Truth cone_truth(int, const Outline& footprint) {
  const double square_r = 4 * half * half * half / 3 * (std::numbers::sqrt2 + std::asinh(1.0));  // ∬ r over the square
  return round_truth(footprint, std::numbers::pi * apex * zero_radius * zero_radius / 3,
                     apex * (4 * half * half - square_r / zero_radius));
}

}  // namespace

SceneModel plane_scene() {
  SceneModel model = shape_scene("plane", "two planes: lifted by a constant, or tilted against each other");
  model.variants = {"lifted", "tilted"};
  model.height = plane_height;
  model.footprint = plane_footprint;
  model.truth = plane_truth;
  return model;
}

SceneModel paraboloid_scene() {
  SceneModel model = shape_scene("paraboloid", "a plane and a paraboloid that cuts it in a circle");
  model.height = paraboloid_height;
  model.footprint = square;
  model.truth = paraboloid_truth;
  return model;
}

SceneModel cone_scene() {
  SceneModel model = shape_scene("cone", "a plane and a cone that cuts it in a circle");
  model.height = cone_height;
  model.footprint = square;
  model.truth = cone_truth;
  return model;
}

}  // namespace isopach
