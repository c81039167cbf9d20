// What weights say where the truth is known: weight_bench, writes the table of docs/use/weights.md. Three scenes, each
// with a weight that suits it, and the share of CPU time that each kind of weight takes.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/io/expression.hpp"
#include "isopach/simulate/scene.hpp"

namespace {

using namespace isopach;

Comparison compared(const Cloud& a, const Cloud& b, const WeightSource& weight) {
  CompareOptions o;
  o.check_layers = false;
  o.weight = weight;
  return compare(a, b, o, {});
}
WeightSource formula(const std::string& text) {
  return {WeightSource::Kind::expression, WeightSource::Scan::any, text, Expression(text, "--weight")};
}

void row(const std::string& name, const Comparison& c, const std::string& truth) {
  const WeightedMeasures& w = *c.weighted;
  fmt::print("| {} | {:.4f} m | {:.4f} m | {:.4f} m | {:.4f} m | {} |\n", name, c.measures.difference.mean,
             w.net / w.integral, c.measures.rho, (w.above + w.below) / w.integral, truth);
}

Scene scene_of(const char* name, const char* variant, std::size_t points, double noise) {
  SceneOptions o;
  o.points_a = o.points_b = points;
  o.noise_a = o.noise_b = noise;
  o.variant = variant;
  return make_scene(name, o, {});
}

/// Near the mound of the rough relief alone: the rest of the square kilometre is chords.
void distance() {
  const Scene s = scene_of("relief", "rough", 100000, 0);
  row("distance: `exp(-((x-350)^2+(y-600)^2)/1800)`", compared(s.a, s.b, formula("exp(-((x-350)^2+(y-600)^2)/1800)")),
      "3.84 m");
}

/// A plane lifted by 0.1; heights of B are good to 0.02 in the west and to 1 in the east, and say so.
void confidence() {
  Scene s = scene_of("plane", "lifted", 5000, 0);
  const RandomStream random(1, 7);
  Attribute weight{"confidence", {}};
  double west = s.b.points[0].x, east = west, lift = 0;
  for (const Point3& p : s.b.points) west = std::min(west, p.x), east = std::max(east, p.x);
  lift = s.truth.net / s.truth.area;
  for (std::size_t i = 0; i < s.b.points.size(); ++i) {
    const double sigma = 0.02 + 3 * (s.b.points[i].x - west) / (east - west);
    s.b.points[i].z += sigma * random.normal(i);
    weight.values.push_back(1 / (sigma * sigma));
  }
  s.b.attributes.push_back(std::move(weight));
  row("confidence: `@b:confidence`, 1/σ²",
      compared(s.a, s.b, {WeightSource::Kind::attribute, WeightSource::Scan::b, "confidence"}),
      fmt::format("{:.4f} m", lift));
}

/// Nothing changed, but B is shifted by 0.5 m in x: false differences on slopes.
void slope() {
  Scene s = scene_of("relief", "unchanged", 400000, 0);
  for (Point3& p : s.b.points) p.x += 0.5;
  row("slope: `1/(1+(slope1/0.05)^4)`", compared(s.a, s.b, formula("1/(1+(slope1/0.05)^4)")), "0 m");
}

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void costs() {
  Scene s = scene_of("terrain", "", 300000, 0.02);
  Attribute weight{"w", {}};
  for (const Point3& p : s.b.points) weight.values.push_back(p.z);
  s.b.attributes.push_back(std::move(weight));
  const auto time = [&](const WeightSource& w) {
    const double start = seconds();
    (void)compared(s.a, s.b, w);
    return seconds() - start;
  };
  const double plain = time({});
  fmt::print("\nCPU time of the whole comparison, 300 000 points each, over that without a weight ({}):\n\n",
             "terrain");
  fmt::print("| weight | time |\n|---|---|\n");
  for (const WeightSource& w :
       {WeightSource{WeightSource::Kind::attribute, WeightSource::Scan::b, "w"}, formula("1 + slope1"),
        formula("exp(-((x-412500)^2+(y-5236500)^2)/20000)"), formula("x > 412500 ? 1 : 0")})
    fmt::print("| `{}` | {:.1f} |\n", to_text(w), time(w) / plain);
}

}  // namespace

int main() {
  run_with_threads(0, [] {
    fmt::print(
        "| weight | mean d | weighted mean d | mean abs d (ρ) | weighted mean abs d | true d "
        "|\n|---|---|---|---|---|---|\n");
    distance();
    confidence();
    slope();
    costs();
  });
  return 0;
}
