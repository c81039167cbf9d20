// Whether B lies off A as a whole: offsets, tilts and shifts are found, changes of a part and noise are not.
#include "isopach/compare/displacement.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/compare/compare.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

using Kind = Displacement::Kind;

double hills(const Point2& p) { return 0.3 * std::sin(7 * p.x + 1) * std::cos(5 * p.y) + 0.1 * p.x; }

/// Two samples of `hills`, B with `change` on top; both with noise of deviation `noise`.
std::optional<Displacement> found(const Height& change, double noise = 0.002, const Height& ground = hills) {
  Random random(7);
  const auto noisy = [&](const Height& f) {
    return [&random, f, noise](const Point2& p) { return f(p) + noise * random.bell(); };
  };
  CompareOptions o;
  o.check_layers = false;
  return plain_displacement(compare(
      cloud_over(framed_square(3000, 1), noisy(ground)),
      cloud_over(framed_square(4000, 2), noisy([&](const Point2& p) { return ground(p) + change(p); })), o, {}));
}

TEST(Displacement, AnOffset) {
  const auto d = found([](const Point2&) { return -0.05; });
  ASSERT_TRUE(d);
  EXPECT_EQ(d->kind, Kind::offset);
  EXPECT_NEAR(d->offset, -0.05, 0.0005);
  EXPECT_NEAR(d->before, 0.05, 0.001);
  EXPECT_LT(d->after, 0.004);
}

TEST(Displacement, ATilt) {
  const auto d = found([](const Point2& p) { return 0.1 * (p.x - 0.5) + 0.05 * (p.y - 0.5); });
  ASSERT_TRUE(d);
  EXPECT_EQ(d->kind, Kind::tilt);
  EXPECT_NEAR(d->tilt, std::atan(std::hypot(0.1, 0.05)), 0.002);
}

TEST(Displacement, AShiftAcrossTheDirection) {
  const Cloud a = cloud_over(framed_square(6000, 1), hills);
  CompareOptions o;
  o.check_layers = false;
  const auto d =
      plain_displacement(compare(a, shifted(cloud_over(framed_square(6000, 2), hills), {0.02, -0.01, 0}), o, {}));
  ASSERT_TRUE(d);
  EXPECT_EQ(d->kind, Kind::shift);
  EXPECT_NEAR(d->shift, std::hypot(0.02, 0.01), 0.003);
}

TEST(Displacement, AnOffsetBesideALocalChange) {
  const auto d = found([](const Point2& p) { return p.x < 0.35 ? 1.0 : 0.05; });
  ASSERT_TRUE(d);
  EXPECT_EQ(d->kind, Kind::offset);
  EXPECT_NEAR(d->offset, 0.05, 0.005);
}

TEST(Displacement, OffsetOfAPlane) {
  const auto d = found([](const Point2&) { return 0.5; }, 0, [](const Point2& p) { return 0.2 * p.x; });
  ASSERT_TRUE(d);
  EXPECT_EQ(d->kind, Kind::offset);
}

TEST(Displacement, NoneWhereTheScansAgree) {
  EXPECT_FALSE(found([](const Point2&) { return 0; }));
  EXPECT_FALSE(found([](const Point2&) { return 0; }, 0.2));
  EXPECT_FALSE(found([](const Point2&) { return 0; }, 0, [](const Point2&) { return 0; }));
  EXPECT_FALSE(found([](const Point2&) { return 0.005; }, 0.02));  // well within the noise
}

TEST(Displacement, NoneWhereAPartChanged) {
  EXPECT_FALSE(found([](const Point2& p) { return p.x < 0.45 ? 1.0 : 0.0; }));
  EXPECT_FALSE(found([](const Point2& p) {
    return 0.5 * std::exp(-40 * (p.x - 0.4) * (p.x - 0.4) - 30 * (p.y - 0.6) * (p.y - 0.6));
  }));
}

TEST(Displacement, NoneWhereTheWholeChangedInItsOwnWay) {
  EXPECT_FALSE(found([](const Point2& p) { return -std::hypot(p.x - 0.5, p.y - 0.5); }));
  EXPECT_FALSE(found([](const Point2& p) { return 0.1 * std::sin(9 * p.x) * std::sin(8 * p.y + 1); }));
  EXPECT_FALSE(found([](const Point2& p) { return 0.2 * hills({p.y, p.x}); }));
}

TEST(Displacement, NoneInScenesThatChange) {
  for (const char* name : {"terrain", "face", "cone", "paraboloid"}) {
    SceneOptions o = scene_defaults(name);
    o.points_a = 6000, o.points_b = 8000;
    const Scene scene = make_scene(name, o, {});
    CompareOptions options;
    options.check_layers = false;
    const auto d = plain_displacement(compare(scene.a, scene.b, options, {}));
    EXPECT_FALSE(d) << name << ": " << d->before << " -> " << d->after;
  }
}

TEST(Displacement, NoneOfTooFewNodes) {
  CompareOptions o;
  o.check_layers = false;
  const Cloud a = cloud_over({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}}, hills);
  EXPECT_FALSE(plain_displacement(compare(a, shifted(a, {0, 0, 0.2}), o, {})));
}

}  // namespace
}  // namespace isopach::test
