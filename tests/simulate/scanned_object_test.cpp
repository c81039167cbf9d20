// Scans of the object have the errors that were asked for.
#include "isopach/simulate/scanned_object.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {

TEST(ScannedObject, BiasNoiseScaleAndPlaceAreThoseAskedFor) {
  ObjectScanner s;
  s.points = 4000, s.noise = 0.05, s.bias = 0.2, s.scale = 1.01, s.reach = 0.5, s.moved = true;
  const Cloud scan = scan_object(s, 3, 0);
  const Pose back = object_pose(s);
  double sum = 0, squares = 0, farthest = 0;
  for (const Point3& p : scan.points) {
    const Point3 q = back.apply(p);
    const double d = q.z - object_height(q.x, q.y);
    sum += d, squares += d * d, farthest = std::max(farthest, q.x);
  }
  const auto n = static_cast<double>(scan.points.size());
  EXPECT_EQ(n, 4000);
  EXPECT_NEAR(sum / n, 0.2, 0.003);
  EXPECT_NEAR(std::sqrt(squares / n - sum / n * sum / n), 0.05, 0.002);
  EXPECT_NEAR(farthest, object_width / 2, 1e-9);
  const Point3 origin = back.apply({0, 0, 0}), unit = back.apply({1, 0, 0});
  EXPECT_NEAR(std::hypot(unit.x - origin.x, unit.y - origin.y, unit.z - origin.z), 1 / 1.01, 1e-12);
}

TEST(ScannedObject, ASpotHidesTheTexture) {
  ObjectScanner point, spot;
  point.points = spot.points = 2000;
  spot.spot = 12;
  const Cloud sharp = scan_object(point, 3, 0), blurred = scan_object(spot, 3, 0);
  double squares = 0;
  for (std::size_t i = 0; i < 2000; ++i) {
    EXPECT_EQ(sharp.points[i].x, blurred.points[i].x);
    const double d = sharp.points[i].z - blurred.points[i].z;
    squares += d * d / 2000;
  }
  EXPECT_NEAR(std::sqrt(squares), 0.1, 0.05);  // the texture, and some of the hills
}

TEST(ScannedObject, SeedsScansAndErrors) {
  const ObjectScanner s;
  EXPECT_EQ(scan_object(s, 3, 0).points, scan_object(s, 3, 0).points);
  EXPECT_NE(scan_object(s, 3, 0).points, scan_object(s, 3, 1).points);
  EXPECT_NE(scan_object(s, 3, 0).points, scan_object(s, 4, 0).points);
  const auto wrong = [](auto change) {
    ObjectScanner w;
    change(w);
    EXPECT_THROW((void)scan_object(w, 1, 0), UsageError);
  };
  wrong([](ObjectScanner& w) { w.points = 99; });
  wrong([](ObjectScanner& w) { w.noise = -1; });
  wrong([](ObjectScanner& w) { w.bias = std::numeric_limits<double>::infinity(); });
  wrong([](ObjectScanner& w) { w.spot = -1; });
  wrong([](ObjectScanner& w) { w.reach = 1.5; });
  wrong([](ObjectScanner& w) { w.scale = 0; });
}

}  // namespace
}  // namespace isopach
