// The chewing face against its own definition: every point of a frame, moved back, lies on the face at rest.
#include "isopach/simulate/chewing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "isopach/base/parallel.hpp"
#include "isopach/simulate/scene.hpp"

namespace isopach {
namespace {

ChewingOptions small() {
  ChewingOptions o;
  o.frames = 20;
  o.points = 3000;
  o.noise = 0;
  return o;
}

/// The place that a rigid pose takes to p.
Point3 undone(const Pose& pose, const Point3& p) {
  const auto& m = pose.m;
  const Point3 d{p.x - m[3], p.y - m[7], p.z - m[11]};
  return {m[0] * d.x + m[4] * d.y + m[8] * d.z, m[1] * d.x + m[5] * d.y + m[9] * d.z,
          m[2] * d.x + m[6] * d.y + m[10] * d.z};
}

TEST(Chewing, EveryPointComesFromTheFaceAtRest) {
  const Chewing chewing(small(), 3);
  const auto face = scene_surface("face", "", 1);
  for (const std::size_t k : {std::size_t{0}, std::size_t{4}, std::size_t{10}}) {
    const Cloud frame = chewing.frame(k);
    const auto& blend = frame.find_attribute("blend")->values;
    ASSERT_EQ(blend.size(), frame.points.size());
    std::size_t still = 0, moving = 0;
    for (std::size_t i = 0; i < blend.size(); ++i) {
      if (blend[i] > 0 && blend[i] < 1) continue;
      Point3 p = undone(chewing.head(k), frame.points[i]);
      if (blend[i] == 1) p = undone(chewing.jaw(k), p);
      EXPECT_NEAR(p.z, face(p.x, p.y), 1e-9);
      EXPECT_EQ(Chewing::blend(p.x, p.y) > 0.5, blend[i] == 1);
      ++(blend[i] == 1 ? moving : still);
    }
    EXPECT_GT(still, 1500u);
    EXPECT_GT(moving, 400u);
    EXPECT_LT(still + moving, frame.points.size()) << "there is a zone in between";
  }
}

TEST(Chewing, MotionIsRigidAndWidestInTheMiddleOfACycle) {
  const Chewing chewing(small(), 1);
  EXPECT_TRUE(chewing.head(0).is_identity());
  EXPECT_TRUE(chewing.jaw(0).is_identity());
  const auto& m = chewing.jaw(10).m;
  EXPECT_NEAR(std::acos((m[0] + m[5] + m[10] - 1) / 2) * 180 / std::acos(-1.0), 18, 1e-9);
  // At its widest the hinge has slid 8 forward and 3 down.
  const Point3 h = chewing.jaw(10).apply(Chewing::hinge);
  EXPECT_NEAR(h.y, -3, 1e-9);
  EXPECT_NEAR(h.z, 18, 1e-9);
}

TEST(Chewing, NoiseIsAlongTheView) {
  ChewingOptions o = small();
  const Cloud clean = Chewing(o, 1).frame(7);
  o.noise = 0.2;
  const Cloud noisy = Chewing(o, 1).frame(7);
  ASSERT_EQ(clean.points.size(), noisy.points.size());
  double sum = 0;
  for (std::size_t i = 0; i < clean.points.size(); ++i) {
    EXPECT_EQ(clean.points[i].x, noisy.points[i].x);
    sum += std::pow(clean.points[i].z - noisy.points[i].z, 2);
  }
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(clean.points.size())), 0.2, 0.02);
}

TEST(Chewing, SameBitsForAnyThreads) {
  const Chewing chewing(small(), 5);
  Cloud one, three;
  run_with_threads(1, [&] { one = chewing.frame(6); });
  run_with_threads(3, [&] { three = chewing.frame(6); });
  EXPECT_EQ(one.points, three.points);
  EXPECT_NE(one.points, Chewing(small(), 6).frame(6).points);
}

TEST(Chewing, RefusesWhatMakesNoSense) {
  const auto refused = [](auto&& change) {
    ChewingOptions o;
    change(o);
    EXPECT_THROW(Chewing(o, 1), UsageError);
  };
  refused([](ChewingOptions& o) { o.frames = 0; });
  refused([](ChewingOptions& o) { o.points = 99; });
  refused([](ChewingOptions& o) { o.noise = -1; });
  refused([](ChewingOptions& o) { o.noise = std::numeric_limits<double>::quiet_NaN(); });
  refused([](ChewingOptions& o) { o.opening = 0; });
  refused([](ChewingOptions& o) { o.opening = 41; });
  refused([](ChewingOptions& o) { o.frames_a_cycle = 1; });
}

}  // namespace
}  // namespace isopach
