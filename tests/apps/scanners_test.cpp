// Two scanners of known noise on a surface with texture of known wavelength.
#include "isopach/apps/scanners.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "isopach/base/random.hpp"
#include "isopach/simulate/sampling.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

/// Broad shapes and a texture of waves of 8 to 10.
double textured(double x, double y) {
  double z = 5 * std::sin(x / 40) * std::cos(y / 50);
  for (int i = 0; i < 8; ++i) {
    const double direction = i * std::numbers::pi * (3 - std::sqrt(5.0)), k = 2 * std::numbers::pi / (8 + i / 4.0);
    z += 0.1 * std::sin(k * (std::cos(direction) * x + std::sin(direction) * y) + i * i);
  }
  return z;
}

Cloud scan(std::size_t points, double noise, double lift, std::uint64_t seed) {
  const Array<Point2> nodes = bordered_nodes(rectangle({0, 0}, {100, 100}), points, {seed, 0});
  const RandomStream random(seed, 9);
  Cloud cloud;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    cloud.points.push_back(
        {nodes[i].x, nodes[i].y, textured(nodes[i].x, nodes[i].y) + lift + noise * random.normal(i)});
  cloud.unit = cloud.vertical_unit = "mm";
  return cloud;
}

ScannersOptions in_place() {
  ScannersOptions options;
  options.align = false;
  return options;
}

TEST(Scanners, NoiseOfEachAtFourDensitiesAndThreeLevels) {
  const Cloud reference = scan(40000, 0, 0, 1);
  for (const std::size_t points : {20000, 8000, 4000, 2500})
    for (const double noise : {0.05, 0.1, 0.3}) {
      const Scanners s = scanners(scan(points, noise, 0.2, 2), scan(2500, 0.1, 0, 3), reference, in_place(), {});
      EXPECT_NEAR(s.scan[0].noise, noise, 0.1 * noise) << points;
      EXPECT_NEAR(s.scan[1].noise, 0.1, 0.01);
      EXPECT_NEAR(s.scan[0].residuals.bias, 0.2, 0.1 * noise);
      EXPECT_NEAR(s.bias, -0.2, 0.05);
    }
}

TEST(Scanners, NoiseOfTheReferenceIsTakenOff) {
  const Cloud reference = scan(40000, 0.1, 0, 1);
  ScannersOptions options = in_place();
  const Cloud a = scan(8000, 0.1, 0, 2), b = scan(8000, 0.2, 0, 3);
  EXPECT_GT(scanners(a, b, reference, options, {}).scan[0].noise, 0.115);
  options.reference_sigma = 0.1;
  const Scanners s = scanners(a, b, reference, options, {});
  EXPECT_NEAR(s.scan[0].noise, 0.1, 0.01);
  EXPECT_NEAR(s.scan[1].noise, 0.2, 0.02);
  options.reference_sigma = -1;
  EXPECT_THROW((void)scanners(a, b, reference, options, {}), UsageError);
}

TEST(Scanners, SaysWhoSeesTheTexture) {
  // 1 mm apart against waves of 8 to 10 mm; 8 mm apart the texture is lost.
  const Scanners s = scanners(scan(10000, 0.01, 0, 2), scan(160, 0.01, 0, 3), scan(40000, 0, 0, 1), in_place(), {});
  ASSERT_GE(s.detail.size(), 4u);
  EXPECT_EQ(s.coarser, "B");
  EXPECT_LT(s.scan[0].resolved, 5);
  EXPECT_GT(s.scan[0].resolved, 0);
  EXPECT_TRUE(s.scan[1].resolved == 0 || s.scan[1].resolved > 8) << s.scan[1].resolved;
  for (const DetailScale& d : s.detail) {
    if (d.length < 3 || d.length > 9) continue;
    EXPECT_TRUE(d.seen[0]);
    EXPECT_FALSE(d.seen[1]);
    EXPECT_NEAR(d.gain[0], 1, 0.1);
  }
  EXPECT_LT(s.rho_dv, s.rho);
}

TEST(Scanners, TheReferenceItselfShowsAll) {
  const Cloud reference = scan(5000, 0, 0, 1);
  const Scanners s = scanners(reference, reference, reference, in_place(), {});
  for (const DetailScale& d : s.detail) {
    EXPECT_NEAR(d.gain[0], 1, 1e-9);
    EXPECT_LT(d.error[1], 1e-9);
  }
  EXPECT_EQ(s.scan[0].resolved, s.detail.front().length);
  EXPECT_EQ(s.scan[0].noise, 0);
}

}  // namespace
}  // namespace isopach
