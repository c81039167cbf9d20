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

/// Mean over a disc.
double over_spot(double x, double y, double radius) {
  constexpr int places = 96;
  double sum = 0;
  for (int i = 0; i < places; ++i) {
    const double r = radius * std::sqrt((i + 0.5) / places), angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    sum += textured(x + r * std::cos(angle), y + r * std::sin(angle));
  }
  return sum / places;
}

Cloud scan(std::size_t points, double noise, double lift, std::uint64_t seed, double spot = 0) {
  const Array<Point2> nodes = bordered_nodes(rectangle({0, 0}, {100, 100}), points, {seed, 0});
  const RandomStream random(seed, 9);
  Cloud cloud;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    cloud.points.push_back(
        {nodes[i].x, nodes[i].y,
         (spot > 0 ? over_spot(nodes[i].x, nodes[i].y, spot / 2) : textured(nodes[i].x, nodes[i].y)) + lift +
             noise * random.normal(i)});
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
      EXPECT_NEAR(s.scan[0].spot.noise, noise, 0.1 * noise) << points;
      EXPECT_NEAR(s.scan[1].spot.noise, 0.1, 0.01);
      EXPECT_NEAR(s.scan[0].residuals.bias, 0.2, 0.1 * noise);
      EXPECT_NEAR(s.bias, -0.2, 0.05);
    }
}

TEST(Scanners, WhatASpotHidesIsNoNoise) {
  // Points 3 mm apart, each the mean over a spot 4.5 mm wide that takes a third of the texture.
  const Cloud reference = scan(40000, 0, 0, 1), fine = scan(20000, 0.05, 0, 2);
  const Scanners s = scanners(fine, scan(1100, 0.05, 0, 3, 4.5), reference, in_place(), {});
  EXPECT_EQ(s.scan[0].spot.width, 0);
  EXPECT_NEAR(s.scan[0].spot.noise, 0.05, 0.005);
  EXPECT_NEAR(s.scan[1].spot.width, 4.5, 0.3 * 4.5);
  EXPECT_NEAR(s.scan[1].spot.noise, 0.05, 0.007);
  EXPECT_GT(s.scan[1].residuals.noise, 0.07);
  const Scanners at_points = scanners(fine, scan(1100, 0.05, 0, 3), reference, in_place(), {});
  EXPECT_EQ(at_points.scan[1].spot.width, 0);
}

TEST(Scanners, NoiseOfTheReferenceIsTakenOff) {
  const Cloud reference = scan(40000, 0.1, 0, 1);
  ScannersOptions options = in_place();
  const Cloud a = scan(8000, 0.1, 0, 2), b = scan(8000, 0.2, 0, 3);
  EXPECT_GT(scanners(a, b, reference, options, {}).scan[0].residuals.noise, 0.115);
  options.reference_sigma = 0.1;
  const Scanners s = scanners(a, b, reference, options, {});
  EXPECT_NEAR(s.scan[0].spot.noise, 0.1, 0.01);
  EXPECT_NEAR(s.scan[1].spot.noise, 0.2, 0.02);
  EXPECT_EQ(s.scan[0].spot.width, 0);
  EXPECT_EQ(s.scan[1].spot.width, 0);
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

/// Waves of 40 along x and 50 along y.
Cloud long_waves(std::size_t points, std::uint64_t seed) {
  Cloud cloud;
  for (const Point2& p : bordered_nodes(rectangle({0, 0}, {100, 100}), points, {seed, 0}))
    cloud.points.push_back({p.x, p.y, 5 * std::sin(p.x / 6) * std::cos(p.y / 8)});
  return cloud;
}

// Points 3 apart lie close to long waves, and so do the heights between them: that says nothing of waves of 2 and 4.
TEST(Scanners, ClaimsNoDetailFinerThanItsPointsHold) {
  const Scanners s = scanners(long_waves(1100, 2), long_waves(3000, 3), long_waves(40000, 1), in_place(), {});
  for (const Scanner& scan : s.scan) EXPECT_GE(scan.resolved, 2 * scan.spacing);
  for (const DetailScale& d : s.detail)
    for (std::size_t k = 0; k < 2; ++k)
      if (d.length < 2 * s.scan[k].spacing) {
        EXPECT_FALSE(d.seen[k]) << d.length;
      }
}

TEST(Scanners, TheCurvatureOfLongWavesIsNoDetail) {
  const RandomStream random(7, 0);
  std::vector<DetailSample> samples;
  for (std::size_t k = 0; k < 20; ++k)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const double x = 4 * static_cast<double>(k) + i, y = i % 2 == 0 ? j : 3 - j;
        const double hill = 0.01 * x * x - 0.02 * x * y + 0.03 * y * y + x, noise = random.normal(samples.size());
        samples.push_back({{x, y}, hill, {hill, 0.1 * noise}});
      }
  const DetailScale d = detail_scales(samples, 1).front();
  EXPECT_LT(d.reference, 1e-10);
  EXPECT_NEAR(d.error[1], 0.1 * std::sqrt(10.0 / 16), 0.01);  // of 16 degrees of freedom 10 are left
}

TEST(Scanners, TheSameBitsForAnyThreadsAndOrder) {
  const Cloud a = scan(2500, 0.05, 0, 2), b = scan(600, 0.05, 0.1, 3, 5), reference = scan(6000, 0, 0, 1);
  const Scanners one = scanners(a, b, reference, in_place(), {});
  EXPECT_GT(one.scan[1].spot.width, 0);
  Context three;
  three.threads = 3;
  for (const Scanners& other :
       {scanners(a, b, reference, in_place(), three),
        scanners(test::shuffled(a, 4), test::shuffled(b, 5), test::shuffled(reference, 6), in_place(), {})}) {
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_EQ(one.scan[k].spot.noise, other.scan[k].spot.noise);
      EXPECT_EQ(one.scan[k].spot.width, other.scan[k].spot.width);
      EXPECT_EQ(one.scan[k].residuals.form, other.scan[k].residuals.form);
      EXPECT_EQ(one.scan[k].rho_dv, other.scan[k].rho_dv);
    }
    ASSERT_EQ(one.detail.size(), other.detail.size());
    for (std::size_t i = 0; i < one.detail.size(); ++i) {
      EXPECT_EQ(one.detail[i].gain, other.detail[i].gain);
      EXPECT_EQ(one.detail[i].error, other.detail[i].error);
    }
  }
}

/// A patch of 4 by 4 nodes, 1 apart, that a scan without the ripple lies over; `torn`: half of it lies far away.
void add_square(std::vector<DetailSample>& samples, double x, bool torn) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      const double far = torn && i > 1 ? 500 : 0, u = x + i + far, v = i % 2 == 0 ? j : 3 - j;
      const double hill = 0.001 * u * u, ripple = (i + static_cast<int>(v)) % 2 == 0 ? 0.1 : -0.1;
      samples.push_back({{u, v}, hill + ripple, {hill + ripple, hill}});
    }
}

TEST(Scanners, PatchesThatTheCurveTearsDoNotCount) {
  std::vector<DetailSample> whole, some_torn;
  for (int k = 0; k < 20; ++k) {
    add_square(whole, 4 * k, false);
    add_square(some_torn, 4 * k, false);
    if (k % 2 == 0) add_square(some_torn, 4 * k, true);
  }
  const DetailScale one = detail_scales(whole, 1).front(), other = detail_scales(some_torn, 1).front();
  EXPECT_EQ(one.stretches, 320u);
  EXPECT_EQ(other.stretches, 320u);
  EXPECT_EQ(one.reference, other.reference);
  EXPECT_NEAR(one.reference, 0.1, 0.01);
  EXPECT_TRUE(other.seen[0]);
  EXPECT_FALSE(other.seen[1]);
  EXPECT_NEAR(other.gain[1], 0, 0.05);
}

TEST(Scanners, TheReferenceItselfShowsAll) {
  const Cloud reference = scan(5000, 0, 0, 1);
  const Scanners s = scanners(reference, reference, reference, in_place(), {});
  for (const DetailScale& d : s.detail) {
    EXPECT_NEAR(d.gain[0], 1, 1e-9);
    EXPECT_LT(d.error[1], 1e-9);
  }
  EXPECT_EQ(s.scan[0].resolved, s.detail.front().length);
  EXPECT_EQ(s.scan[0].spot.noise, 0);
}

}  // namespace
}  // namespace isopach
