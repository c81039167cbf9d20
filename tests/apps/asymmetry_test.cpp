// Faces of known plane and known difference of the sides.
#include "isopach/apps/asymmetry.hpp"

#include <gtest/gtest.h>

#include "tests/apps/faces.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

using test::FaceScan;

/// Seen along z, as the scans of this file lie: what is tested here is the plane, not the search for the face.
AsymmetryOptions seen_along_z(AsymmetryOptions options = {}) {
  options.orientation = FaceOrientation::given;
  return options;
}

Asymmetry found(const FaceScan& scan, const AsymmetryOptions& options = {}) {
  return asymmetry(test::face_scan(scan), seen_along_z(options), {});
}

void expect_plane(const Asymmetry& a, const Pose& pose, double degrees, double distance) {
  const test::PlaneError error = test::plane_error(a.plane, pose);
  EXPECT_TRUE(a.converged) << a.reason;
  EXPECT_LT(error.degrees, degrees);
  EXPECT_LT(error.distance, distance);
  // Three deviations of two angles and of one offset.
  EXPECT_LT(error.degrees, 4 * a.plane.sigma_angle);
  EXPECT_LT(error.distance, 4 * a.plane.sigma_offset);
}

TEST(Asymmetry, FindsThePlaneOfASymmetricFaceAndNoAsymmetry) {
  for (const auto& [turn, roll] : {std::pair{6.0, 8.0}, std::pair{-9.0, -17.0}}) {
    FaceScan scan;
    scan.pose = test::sitting(turn, roll);
    const Asymmetry a = found(scan);
    expect_plane(a, scan.pose, 0.05, 0.05);
    EXPECT_LT(a.index.percent, a.index.floor);
    EXPECT_LT(a.index.raw, 2 * a.index.floor);
    EXPECT_LT(std::fabs(a.regions[0].directional), 0.02);
    EXPECT_LT(a.plane.twist, 0.2);
    EXPECT_LT(a.plane.glide, 0.2);
    EXPECT_GT(a.comparison.coverage, 0.95);
  }
}

TEST(Asymmetry, LargeFaceWithinFiveHundredths) {
  const Bump bump = test::cheek(6);
  FaceScan scan;
  scan.points = 100000;
  scan.pose = test::sitting();
  scan.added = [&](double x, double y) { return bump.at(x, y); };
  const Asymmetry a = found(scan);
  expect_plane(a, scan.pose, 0.05, 0.05);
  EXPECT_NEAR(a.regions[0].volume.net, bump.volume(), 0.01 * bump.volume());
}

TEST(Asymmetry, AScanThatIsItsOwnMirrorImageHasNone) {
  FaceScan scan;
  scan.points = 3000;
  Cloud cloud = test::face_scan(scan);
  const std::size_t n = cloud.points.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Point3 p = cloud.points[i];
    cloud.points.push_back({-p.x, p.y, p.z});
  }
  const Asymmetry a = asymmetry(cloud, seen_along_z(), {});
  EXPECT_LT(test::plane_error(a.plane, {}).degrees, 1e-4);
  EXPECT_LT(a.index.raw, 1e-4);
}

TEST(Asymmetry, ReturnsTheVolumeOfABumpAndGrowsWithIt) {
  double last = -1;
  for (const double height : {0.0, 1.0, 6.0}) {
    FaceScan scan;
    scan.points = 15000;
    scan.pose = test::sitting();
    const Bump bump = test::cheek(height);
    scan.added = [&](double x, double y) { return bump.at(x, y); };
    const Asymmetry a = found(scan);
    expect_plane(a, scan.pose, 0.05, 0.05);
    EXPECT_GT(a.index.percent, last);
    last = a.index.percent;
    if (height == 0) continue;
    EXPECT_NEAR(a.regions[0].volume.net, bump.volume(), 45) << height;  // 0.003 mm over one side
    EXPECT_LT(a.overlap, 1);
  }
}

TEST(Asymmetry, SidesAndRegionsAreTold) {
  FaceScan scan;
  const Bump bump = test::cheek(6);
  scan.added = [&](double x, double y) { return bump.at(-x, y); };
  AsymmetryOptions options;
  const Asymmetry a = found(scan, options);
  ASSERT_EQ(a.regions.size(), 4u);
  EXPECT_GT(a.plane.normal.x, 0.99);
  EXPECT_NEAR(a.regions[0].volume.net, -bump.volume(), 0.03 * bump.volume());  // the negative side stands out
  EXPECT_LT(std::fabs(a.regions[1].volume.net), 0.03 * bump.volume());         // not in the upper third
  EXPECT_NEAR(a.regions[2].volume.net + a.regions[3].volume.net, a.regions[0].volume.net, 0.03 * bump.volume());
  // Every point on the bump knows it, every point opposite too.
  const Cloud cloud = test::face_scan(scan);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const auto& [x, y, z] = cloud.points[i];
    if (std::hypot(x + 45, y + 31) < 6) {
      EXPECT_GT(a.of_point[i], 3) << z;
    }
    if (std::hypot(x - 45, y + 31) < 6) {
      EXPECT_LT(a.of_point[i], -3) << z;
    }
  }
  options.across = Point3{-1, 0, 0};
  const Asymmetry other = found(scan, options);
  EXPECT_LT(other.plane.normal.x, -0.99);
  EXPECT_NEAR(other.regions[0].volume.net, -a.regions[0].volume.net, 0.01 * bump.volume());
  options.parts = FaceParts::halves;
  EXPECT_EQ(found(scan, options).regions.size(), 3u);
}

TEST(Asymmetry, IsTheSameForScansOfDifferentDensity) {
  const Bump bump = test::cheek(6);
  std::vector<double> index;
  for (const auto& [points, noise] : {std::pair<std::size_t, double>{20000, 0.03}, {6000, 0.1}}) {
    FaceScan scan;
    scan.points = points;
    scan.noise = noise;
    scan.seed = points;
    scan.added = [&](double x, double y) { return bump.at(x, y); };
    index.push_back(found(scan).index.percent);
  }
  EXPECT_NEAR(index[1], index[0], 0.05 * index[0]);
}

TEST(Asymmetry, AnAsymmetricCropDoesNoHarm) {
  // mm beyond the plane on the short side; at 20 only a quarter of the face has another side (docs/use/asymmetry.md,
  // limits)
  for (const double limit : {25.0, 35.0, 50.0}) {
    SCOPED_TRACE(limit);
    FaceScan scan;
    scan.pose = test::sitting(3, 5);
    scan.seen = [&](double x, double y) { return x < limit && y > -95 + 0.4 * x; };
    const Asymmetry a = found(scan);
    expect_plane(a, scan.pose, 0.1, 0.1);
    EXPECT_LT(a.comparison.coverage, 0.85);
    EXPECT_LT(a.index.percent, a.index.floor);
  }
}

TEST(Asymmetry, NoiseAtTheRimDoesNotMoveThePlaneAndMayBeLeftOut) {
  FaceScan scan;
  const Bump bump = test::cheek(6);
  scan.added = [&](double x, double y) { return bump.at(x, y); };
  const double clean = found(scan).index.raw;
  const auto hair = [&](double x, double y) {
    const double r = std::hypot(x / 88, (y + 2) / 118);
    return bump.at(x, y) + (r > 0.9 ? 6 * std::sin(37 * x + 91 * y) + (x > 0 ? 3 : 0) : 0);
  };
  scan.added = hair;
  AsymmetryOptions options;
  const Asymmetry rough = found(scan, options);
  expect_plane(rough, {}, 0.1, 0.1);
  EXPECT_GT(rough.index.raw, 1.3 * clean);
  options.rim = 12;
  const Asymmetry inner = found(scan, options);
  expect_plane(inner, {}, 0.1, 0.1);
  EXPECT_LT(inner.comparison.b.points, rough.comparison.b.points);
  EXPECT_NEAR(inner.regions[0].volume.net, bump.volume(), 0.03 * bump.volume());
}

TEST(Asymmetry, AnyDirectionWillDo) {
  FaceScan scan;
  scan.points = 3000;
  const Bump bump = test::cheek(6);
  scan.added = [&](double x, double y) { return bump.at(x, y); };
  const Asymmetry plain = found(scan);
  Cloud cloud = test::face_scan(scan);
  for (Point3& p : cloud.points) p = {p.z, p.x, p.y};  // the viewer looks along x, across is y
  AsymmetryOptions options = seen_along_z();
  options.compare.project.direction.kind = Direction::Kind::axis_x;
  const Asymmetry turned = asymmetry(cloud, options, {});
  EXPECT_NEAR(turned.plane.normal.y, plain.plane.normal.x, 1e-6);
  EXPECT_NEAR(turned.index.percent, plain.index.percent, 1e-3 * plain.index.percent);
}

TEST(Asymmetry, TheSameBitsForAnyThreadsAndOrder) {
  FaceScan scan;
  scan.points = 2500;
  scan.pose = test::sitting();
  const Cloud cloud = test::face_scan(scan);
  const Asymmetry one = asymmetry(cloud, seen_along_z(), {});
  Context three;
  three.threads = 3;
  for (const Asymmetry& other :
       {asymmetry(cloud, seen_along_z(), three), asymmetry(test::shuffled(cloud, 5), seen_along_z(), {})}) {
    EXPECT_EQ(one.plane.normal, other.plane.normal);
    EXPECT_EQ(one.plane.offset, other.plane.offset);
    EXPECT_EQ(one.index.percent, other.index.percent);
    EXPECT_EQ(one.regions[0].volume.net, other.regions[0].volume.net);
  }
}

TEST(Asymmetry, ErrorsNameTheOption) {
  FaceScan scan;
  scan.points = 2000;
  const Cloud cloud = test::face_scan(scan);
  const auto message = [&](const AsymmetryOptions& options) -> std::string {
    try {
      (void)asymmetry(cloud, seen_along_z(options), {});
    } catch (const Error& error) {
      return error.what();
    }
    return "nothing";
  };
  AsymmetryOptions o;
  o.rim = 500;
  EXPECT_NE(message(o).find("@rim"), std::string::npos);
  o = {};
  o.rim = -1;
  EXPECT_NE(message(o).find("@rim"), std::string::npos);
  o = {};
  o.across = Point3{0, 0, 0};
  EXPECT_NE(message(o).find("@across"), std::string::npos);
  o.across = Point3{0, 0, 2};
  EXPECT_NE(message(o).find("@across"), std::string::npos);
  o = {};
  o.overlap = 2;
  EXPECT_NE(message(o).find("@overlap"), std::string::npos);
  Cloud feet = cloud;
  feet.vertical_unit = "ft";
  EXPECT_THROW((void)asymmetry(feet, seen_along_z(), {}), InputError);
}

}  // namespace
}  // namespace isopach
