// asymmetry of faces in any pose: the same plane and index, R and L of the patient, what is given against what is
// found.
#include <gtest/gtest.h>

#include "isopach/apps/asymmetry.hpp"
#include "isopach/distance/vectors.hpp"
#include "tests/apps/mean_faces.hpp"

namespace isopach {
namespace {

bool warned(const Asymmetry& a, const char* words) {
  for (const std::string& w : a.warnings)
    if (w.find(words) != std::string::npos) return true;
  return false;
}

/// A face with a swollen left cheek (x > 0 is the patient's left where z is the front).
test::FaceScan swollen(double height) {
  test::FaceScan scan;
  scan.points = 4000;
  scan.added = [bump = test::cheek(height)](double x, double y) { return bump.at(x, y); };
  return scan;
}

TEST(AsymmetryPose, AFaceOnItsSideOrUpsideDownHasTheSamePlaneAndSides) {
  const Cloud cloud = test::mean_face_scan(swollen(6));
  const Asymmetry plain = asymmetry(cloud, {}, {});
  EXPECT_GT(plain.regions[0].directional, 0.05);  // the patient's left stands out
  for (const double degrees : {90.0, 180.0}) {
    SCOPED_TRACE(degrees);
    const Pose pose = test::turn_and_shift({1, 1, 0.3}, degrees, {0, 0, 0}, {300, -50, 20});
    const Asymmetry a = asymmetry(test::posed(cloud, pose), {}, {});
    EXPECT_LT(test::plane_error(a.plane, pose).degrees, 0.3);
    const Point3 left = pose.apply({1, 0, 0}) - pose.apply({0, 0, 0});
    EXPECT_GT(dot(a.plane.normal, left), 0.99);
    EXPECT_NEAR(a.index.percent, plain.index.percent, 0.05 * plain.index.percent);
    EXPECT_NEAR(a.regions[0].directional, plain.regions[0].directional, 0.02);
  }
}

TEST(AsymmetryPose, WhatIsGivenHoldsAndIsWarnedOf) {
  const Cloud cloud = test::mean_face_scan(swollen(0));
  AsymmetryOptions given;
  given.orientation = FaceOrientation::given;
  EXPECT_FALSE(warned(asymmetry(cloud, given, {}), "@direction"));
  given.compare.project.direction = {Direction::Kind::vector, {0.4, 0, 1}};
  const Asymmetry turned = asymmetry(cloud, given, {});
  EXPECT_TRUE(warned(turned, "@direction"));
  AsymmetryOptions across;
  across.across = Point3{1, 0.4, 0};
  EXPECT_TRUE(warned(asymmetry(cloud, across, {}), "@across"));
  across.across = Point3{-1, 0, 0};  // either way: the positive side of a face is the patient's left
  const Asymmetry sides = asymmetry(cloud, across, {});
  EXPECT_FALSE(warned(sides, "@across"));
  EXPECT_GT(sides.plane.normal.x, 0.99);
}

TEST(AsymmetryPose, StablePartsHoldThePlaneOfASwollenFace) {
  test::FaceScan scan;
  scan.points = 6000;
  scan.added = [](double x, double y) {  // flanks so soft that they look like ordinary asymmetry
    return 12 * std::exp(-((x - 42) * (x - 42) + (y + 25) * (y + 25)) / (2 * 20 * 20));
  };
  const Cloud cloud = test::mean_face_scan(scan);
  const Asymmetry all = asymmetry(cloud, {}, {});
  EXPECT_TRUE(warned(all, "@stable"));
  AsymmetryOptions options;
  options.stable = {StablePart::forehead, StablePart::eyes, StablePart::nose};
  const Asymmetry healthy = asymmetry(cloud, options, {});
  const double with = test::plane_error(healthy.plane, {}).degrees;
  EXPECT_LT(with, 0.6);
  EXPECT_LT(with, test::plane_error(all.plane, {}).degrees + 0.1);
  EXPECT_NE(healthy.plane.normal, all.plane.normal);
}

/// A head whose left cheek is coarsely scanned and stands out: chords there lie below the surface and hide a part of
/// the difference, which the noise floor gives back.
Cloud coarse_cheek(double swelling) {
  const RandomStream random(1, 1);
  Cloud cloud;
  const auto add = [&](double step, bool inside, std::uint64_t seed) {
    for (int i = 0; i * step <= 200; ++i)
      for (int k = 0; k * step <= 200; ++k) {
        const std::uint64_t n = seed + 2 * static_cast<std::uint64_t>(i * 100 + k);
        const double x = -100 + step * (i + .6 * random.uniform(n) - .3);
        const double y = -100 + step * (k + .6 * random.uniform(n + 1) - .3);
        const double from_cheek = std::hypot(x - 38, y);
        if (std::hypot(x / 80, y / 100) >= 1 || (from_cheek < 32) != inside) continue;
        const double head = 70 * std::sqrt(1.4 - x * x / 8100 - y * y / 12100);
        const double nose = 6 * std::exp(-x * x / 81 - (y + 5) * (y + 5) / 400);
        cloud.points.push_back({x, y, head + nose + swelling * std::clamp((38 - from_cheek) / 8, 0., 1.)});
      }
  };
  add(3, false, 0);
  add(16, true, 1000000);
  return cloud;
}

TEST(AsymmetryPose, WithoutNoiseThereIsNeverMoreThanWithIt) {
  AsymmetryOptions options;
  options.orientation = FaceOrientation::given;
  for (const double swelling : {0.6, 2.5}) {
    const Asymmetry a = asymmetry(coarse_cheek(swelling), options, {});
    EXPECT_LE(a.index.percent, a.index.raw) << swelling;
    EXPECT_LE(a.comparison.noise_floor->debiased_rho, a.comparison.measures.rho) << swelling;
    EXPECT_GT(a.index.percent, 0);
  }
}

TEST(AsymmetryPose, WhatIsNoFaceIsRefused) {
  Cloud ball;
  for (int i = 0; i < 4000; ++i) {
    const double z = 2 * (i + .5) / 4000 - 1, turn = 2.399963 * i, r = std::sqrt(1 - z * z);
    ball.points.push_back({r * std::cos(turn), r * std::sin(turn), z});
  }
  try {
    (void)asymmetry(ball, {}, {});
    FAIL() << "a ball was taken for a face";
  } catch (const OverlapError& error) {
    EXPECT_NE(std::string(error.what()).find("@direction"), std::string::npos);
  }
}

}  // namespace
}  // namespace isopach
