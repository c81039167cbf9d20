// The noise floor in whole comparisons: what it must explain on unchanged surfaces, and the gross volumes that it must
// find again on changed ones.
#include "isopach/measure/uncertainty/noise_floor.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/error.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

CompareOptions with_floor() {
  CompareOptions o;
  o.check_layers = false;
  o.noise_floor = true;
  return o;
}

Scene scene_of(const char* name, const char* variant, std::size_t a, std::size_t b, double noise) {
  SceneOptions o;
  o.points_a = a, o.points_b = b;
  o.noise_a = o.noise_b = noise;
  o.variant = variant;
  return make_scene(name, o, {});
}

struct Found {
  double raw, floor, debiased, truth;
};
Found found(const char* name, const char* variant, std::size_t a, std::size_t b, double noise) {
  const Scene scene = scene_of(name, variant, a, b, noise);
  const Comparison c = compare(scene.a, scene.b, with_floor(), {});
  return {c.measures.volume.absolute, c.noise_floor->above + c.noise_floor->below, c.noise_floor->debiased.absolute,
          scene.truth.above + scene.truth.below};
}

TEST(NoiseFloor, ExplainsAnUnchangedSurface) {
  for (const double noise : {0.3, 1.0}) {
    const Found f = found("relief", "unchanged", 20000, 20000, noise);
    EXPECT_NEAR(f.floor / f.raw, 1, 0.1) << noise;
    EXPECT_LT(f.debiased, 0.05 * f.raw);
  }
  const Found f = found("relief", "unchanged", 20000, 8000, 0.3);  // of different density
  EXPECT_NEAR(f.floor / f.raw, 1, 0.1);
}

TEST(NoiseFloor, FindsTheGrossUnderNoise) {
  const Found smooth = found("relief", "smooth", 20000, 15000, 0.5);
  EXPECT_GT(smooth.raw / smooth.truth, 1.1);
  EXPECT_NEAR(smooth.debiased / smooth.truth, 1, 0.03);
  const Found terrain = found("terrain", "", 20000, 20000, 0.1);
  EXPECT_GT(terrain.raw / terrain.truth, 1.1);
  EXPECT_NEAR(terrain.debiased / terrain.truth, 1, 0.03);
}

TEST(NoiseFloor, SlowExplainsRoughRelief) {
  const Found unchanged = found("relief", "unchanged", 100000, 100000, 0);
  EXPECT_NEAR(unchanged.floor / unchanged.raw, 1, 0.1);
  const Found rough = found("relief", "rough", 100000, 100000, 0);
  EXPECT_GT(rough.raw / rough.truth, 1.8);
  EXPECT_NEAR(rough.debiased / rough.truth, 1, 0.1);
}

TEST(NoiseFloor, IsNothingBetweenPlanes) {
  const Height one = [](const Point2& p) { return 2 * p.x - p.y; };
  const Height two = [](const Point2& p) { return 2.5 * p.x - p.y - 0.2; };
  const Comparison c =
      compare(cloud_over(framed_square(2000, 1), one), cloud_over(framed_square(1500, 2), two), with_floor(), {});
  EXPECT_LT(c.noise_floor->rho, 1e-12);
  EXPECT_NEAR(c.noise_floor->debiased.absolute, c.measures.volume.absolute, 1e-12);
}

TEST(NoiseFloor, KeepsTheNetAndAddsUp) {
  const Scene s = scene_of("relief", "rough", 5000, 5000, 0.2);
  const Comparison c = compare(s.a, s.b, with_floor(), {});
  const Volume& v = c.noise_floor->debiased;
  EXPECT_EQ(v.net, c.measures.volume.net);
  EXPECT_NEAR(v.above - v.below, v.net, 1e-12 * v.absolute);
  EXPECT_NEAR(v.above + v.below, v.absolute, 1e-12 * v.absolute);
  EXPECT_GE(v.absolute, std::fabs(v.net));
  EXPECT_NEAR(c.noise_floor->rho * c.domain_area, c.noise_floor->above + c.noise_floor->below, 1e-9 * v.absolute);
  EXPECT_EQ(c.noise_floor->debiased_rho, v.absolute / c.domain_area);
}

void expect_same(const NoiseFloor& f, const NoiseFloor& g) {
  EXPECT_EQ(f.above, g.above);
  EXPECT_EQ(f.below, g.below);
  EXPECT_EQ(f.rho, g.rho);
  EXPECT_EQ(f.debiased.absolute, g.debiased.absolute);
}

TEST(NoiseFloor, HasTheSameBitsWhateverTheThreadsTheOrderAndTheWay) {
  const Scene s = scene_of("terrain", "", 3000, 4000, 0.05);
  const Comparison c = compare(s.a, s.b, with_floor(), {});
  for (const int threads : {1, 7}) {
    Context context;
    context.threads = threads;
    expect_same(*compare(s.a, s.b, with_floor(), context).noise_floor, *c.noise_floor);
  }
  expect_same(*compare(shuffled(s.a, 1), shuffled(s.b, 2), with_floor(), {}).noise_floor, *c.noise_floor);
  for (const LocateMethod way : {LocateMethod::tree, LocateMethod::interface}) {
    CompareOptions o = with_floor();
    o.locate = way;
    expect_same(*compare(s.a, s.b, o, {}).noise_floor, *c.noise_floor);
  }
}

TEST(NoiseFloor, ChangesSidesWithTheScans) {
  const Scene s = scene_of("relief", "rough", 3000, 4000, 0.1);
  const Comparison c = compare(s.a, s.b, with_floor(), {}), d = compare(s.b, s.a, with_floor(), {});
  EXPECT_EQ(c.noise_floor->above, d.noise_floor->below);
  EXPECT_EQ(c.noise_floor->below, d.noise_floor->above);
  EXPECT_EQ(c.noise_floor->debiased.above, d.noise_floor->debiased.below);
}

TEST(NoiseFloor, StandsDegenerateScans) {
  for (const Family& family : families()) {
    if (family.collinear) continue;
    const Points points = distinct(family.make(60, 3));
    const Comparison c = compare(rough_cloud(points, 4), rough_cloud(points, 5), with_floor(), {});
    EXPECT_TRUE(std::isfinite(c.noise_floor->rho)) << family.name;
    EXPECT_GE(c.noise_floor->debiased.absolute, std::fabs(c.measures.volume.net)) << family.name;
  }
  const Points four{{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  EXPECT_EQ(compare(rough_cloud(four, 1), rough_cloud(four, 1), with_floor(), {}).noise_floor->rho, 0);
}

TEST(NoiseFloor, IsNotThatOfTheOverlayOrOfCubics) {
  CompareOptions o = with_floor();
  o.surface = Surface::overlay;
  const Scene s = scene_of("plane", "tilted", 200, 200, 0);
  EXPECT_THROW((void)compare(s.a, s.b, o, {}), UsageError);
  o.surface = Surface::common;
  o.interpolation = Interpolation::cubic;
  EXPECT_THROW((void)compare(s.a, s.b, o, {}), UsageError);
}

}  // namespace
}  // namespace isopach::test
