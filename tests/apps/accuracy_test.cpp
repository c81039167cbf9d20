// Reconstructions whose bias, noise, scale and completeness are known.
#include "isopach/apps/accuracy.hpp"

#include <gtest/gtest.h>

#include "isopach/base/random.hpp"
#include "isopach/simulate/sampling.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

double part(double x, double y) { return 3 * std::sin(0.21 * x) * std::cos(0.17 * y) + 0.02 * x * y / 10; }

struct Made {
  std::size_t points = 6000;
  double noise = 0, lift = 0, wave = 0;
  double right = 60;  // x reaches to
  std::uint64_t seed = 1;
};

Cloud scan(const Made& m) {
  const Array<Point2> nodes = bordered_nodes(rectangle({0, 0}, {m.right, 40}), m.points, {m.seed, 0});
  const RandomStream random(m.seed, 9);
  Cloud cloud;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto [x, y] = nodes[i];
    const double form = m.wave * std::sqrt(2.0) * std::sin(0.5 * x);
    cloud.points.push_back({x, y, part(x, y) + m.lift + form + m.noise * random.normal(i)});
  }
  cloud.unit = cloud.vertical_unit = "mm";
  return cloud;
}

Cloud reference() { return scan({20000, 0, 0, 0, 60, 77}); }

AccuracyOptions options_of(Align align) {
  AccuracyOptions o;
  o.align = align;
  return o;
}

TEST(Accuracy, BiasAndNoiseAreReturned) {
  const Cloud truth = reference();
  for (const double noise : {0.02, 0.1}) {
    const Accuracy a = accuracy(scan({6000, noise, 0.25, 0, 60, 3}), truth, options_of(Align::none), {});
    EXPECT_NEAR(a.comparison.measures.difference.mean, 0.25, 0.1 * noise);
    EXPECT_NEAR(a.points.bias, 0.25, 0.1 * noise);
    EXPECT_NEAR(a.points.noise, noise, 0.1 * noise);
    EXPECT_LT(a.points.form, 0.3 * noise);
    EXPECT_GT(a.completeness.share, 0.97);
    EXPECT_GE(a.distances.hausdorff->b_to_a.upper, a.distances.c2s->b_to_a.max - 1e-9);
    EXPECT_FALSE(a.matching);
  }
}

TEST(Accuracy, FormIsToldFromNoise) {
  const Accuracy a = accuracy(scan({6000, 0.05, 0, 0.1, 60, 4}), reference(), options_of(Align::none), {});
  EXPECT_NEAR(a.points.noise, 0.05, 0.005);
  EXPECT_NEAR(a.points.form, 0.1, 0.01);
}

TEST(Accuracy, ScaleAndPoseAreReturned) {
  const double scale = 1.004;
  const Pose moved = test::turn_and_shift({0.2, 0.1, 1}, 2, {30, 20, 0}, {0.4, -0.3, 0.2});
  Cloud cloud = test::posed(scan({6000, 0.02, 0, 0, 60, 5}), moved);
  for (Point3& p : cloud.points) p = {scale * p.x, scale * p.y, scale * p.z};
  const Accuracy a = accuracy(cloud, reference(), options_of(Align::scale), {});
  EXPECT_TRUE(a.matching->converged);
  EXPECT_NEAR(a.scale * scale, 1, 1e-4);
  EXPECT_NEAR(a.points.noise, 0.02, 0.002);
  EXPECT_LT(std::fabs(a.points.bias), 0.005);
  const Accuracy rigid = accuracy(cloud, reference(), options_of(Align::rigid), {});
  EXPECT_EQ(rigid.scale, 1);
  EXPECT_GT(rigid.points.rms, 1.5 * a.points.rms);
}

TEST(Accuracy, CompletenessIsThatOfTheReference) {
  AccuracyOptions options = options_of(Align::none);
  options.within = 0.3;
  Cloud half = scan({4000, 0, 0.2, 0, 45, 6});
  const Accuracy a = accuracy(half, reference(), options, {});
  EXPECT_NEAR(a.completeness.reference_area, 2400, 5);
  EXPECT_NEAR(a.completeness.share, 0.75, 0.01);
  EXPECT_NEAR(*a.completeness.within, a.completeness.share, 1e-3);
  options.within = 0.1;
  EXPECT_LT(*accuracy(half, reference(), options, {}).completeness.within, 0.01);
  EXPECT_GT(a.distances.hausdorff->a_to_b.lower, 14);  // the missing quarter
  options.within = -1;
  EXPECT_THROW((void)accuracy(half, reference(), options, {}), UsageError);
}

TEST(Accuracy, AreaWithinIsThatOfTheClosedForm) {
  // d = x over the unit square of a lattice: the area with |d| <= 0.3 is 0.3; along the normal of the tilted plane,
  // whose slope is 1, the distance is x / sqrt(2).
  Cloud flat, tilted;
  for (int i = 0; i <= 8; ++i)
    for (int j = 0; j <= 8; ++j) {
      const double x = i / 8.0, y = j / 8.0;
      flat.points.push_back({x, y, 0});
      tilted.points.push_back({x, y, x});
    }
  AccuracyOptions options = options_of(Align::none);
  options.within = 0.3;
  const Accuracy a = accuracy(tilted, flat, options, {});
  EXPECT_NEAR(area_within(a.comparison.cells.view(), 0.3, {}), 0.3, 1e-12);
  EXPECT_NEAR(*a.completeness.within, 0.3 * std::sqrt(2), 1e-12);
}

TEST(Accuracy, TheSameBitsForAnyThreadsAndOrder) {
  const Cloud truth = scan({3000, 0, 0, 0, 60, 77}), cloud = scan({1500, 0.02, 0.1, 0, 60, 8});
  const Accuracy one = accuracy(cloud, truth, options_of(Align::none), {});
  Context three;
  three.threads = 3;
  for (const Accuracy& other : {accuracy(cloud, truth, options_of(Align::none), three),
                                accuracy(test::shuffled(cloud, 2), truth, options_of(Align::none), {})}) {
    EXPECT_EQ(one.points.noise, other.points.noise);
    EXPECT_EQ(one.points.form, other.points.form);
    EXPECT_EQ(one.comparison.measures.rho, other.comparison.measures.rho);
  }
}

}  // namespace
}  // namespace isopach
