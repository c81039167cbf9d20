// Motions of a scan onto itself: every one that is found does what it says, and ordinary scans have none.
#include "isopach/match/coarse/repeats.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "isopach/distance/vectors.hpp"
#include "isopach/match/match.hpp"
#include "isopach/match/verdict/verdict.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

constexpr double pi = std::numbers::pi, noise = 0.002;

std::vector<Motion> repeats_of(const Cloud& cloud) { return repeats(judged_scan(cloud, {}, {}), {}); }

double waves(const Point2& p) { return 0.04 * std::sin(2 * pi * 5 * p.x) * std::cos(2 * pi * 3 * p.y) + 0.1 * p.x; }

double hills(const Point2& p) {
  return 0.12 * std::sin(5 * p.x + 1.3 * p.y) * std::cos(4 * p.y - p.x) + 0.05 * std::sin(13 * p.x * p.y + 2) +
         0.04 * std::cos(17 * p.y - 9 * p.x * p.x);
}

Cloud sampled(const std::function<double(const Point2&)>& height, std::size_t n, std::uint64_t seed) {
  test::Random random(seed + 50);
  return test::cloud_over(test::uniform(n, seed), [&](const Point2& p) {
    return height(p) + noise * (random.uniform(-1, 1) + random.uniform(-1, 1));
  });
}

/// Distance from the axis by angle: a wheel of `teeth` lobes.
double rim(double angle, double teeth) { return 1 + 0.12 * std::cos(teeth * angle); }

Cloud wheel(std::size_t n, double teeth, std::uint64_t seed) {
  test::Random random(seed);
  Cloud cloud;
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = random.uniform(-pi, pi), r = rim(angle, teeth) + noise * random.uniform(-1, 1);
    cloud.points.push_back({r * std::cos(angle), r * std::sin(angle), random.uniform(-0.3, 0.3)});
  }
  return cloud;
}

TEST(Repeats, ShiftsOfAPatternBringItOntoItself) {
  const Cloud cloud = sampled(waves, 6000, 1);
  const JudgedScan scan = judged_scan(cloud, {}, {});
  const std::vector<Motion> found = repeats(scan, {});
  ASSERT_FALSE(found.empty());
  for (const Motion& motion : found) {
    double squares = 0, count = 0;
    for (const Point3& p : scan.points) {
      const Point3 q = motion.apply(p);
      const Point2 at{q.x + scan.origin.x, q.y + scan.origin.y};
      if (at.x < 0 || at.y < 0 || at.x > 1 || at.y > 1) continue;
      const double d = q.z + scan.origin.z - waves(at);
      squares += d * d, count += 1;
    }
    ASSERT_GT(count, 0.2 * static_cast<double>(scan.points.size()));
    EXPECT_LT(std::sqrt(squares / count), 3 * noise);  // the relief is ten times that
  }
}

TEST(Repeats, TurnsOfAWheelBringItOntoItself) {
  const Cloud cloud = wheel(8000, 7, 2);
  const JudgedScan scan = judged_scan(cloud, {}, {});
  const std::vector<Motion> found = repeats(scan, {});
  ASSERT_FALSE(found.empty());
  for (const Motion& motion : found) {
    double squares = 0;
    for (const Point3& p : scan.points) {
      const Point3 q = motion.apply(p) + scan.origin;
      const double d = std::hypot(q.x, q.y) - rim(std::atan2(q.y, q.x), 7);
      squares += d * d;
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(scan.points.size())), 5 * noise);
  }
}

TEST(Repeats, AnOrdinarySurfaceHasNone) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) EXPECT_TRUE(repeats_of(sampled(hills, 4000, seed)).empty());
  const auto lobed = [](double x) {
    return 1 + 0.2 * std::cos(x) + 0.1 * std::sin(3 * x + 1) + 0.07 * std::cos(5 * x);
  };
  Cloud body = wheel(8000, 0, 3);
  for (Point3& p : body.points) {
    const double r = lobed(std::atan2(p.y, p.x)) * (1 + 0.4 * p.z);
    p.x *= r, p.y *= r;
  }
  EXPECT_TRUE(repeats_of(body).empty());
}

TEST(Repeats, FewPointsHaveNone) { EXPECT_TRUE(repeats_of(sampled(waves, 40, 1)).empty()); }

TEST(Repeats, TheSameBitsForAnyNumberOfThreads) {
  const Cloud cloud = sampled(waves, 3000, 7);
  Context one, four;
  one.threads = 1, four.threads = 4;
  const std::vector<Motion> a = repeats(judged_scan(cloud, {}, one), one),
                            b = repeats(judged_scan(cloud, {}, four), four);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].rotation, b[k].rotation);
    EXPECT_EQ(a[k].shift, b[k].shift);
  }
}

// A start between two waves ends at one of them, where everything agrees: that used to be trusted.
TEST(Repeats, AMatchFromBetweenTwoWavesHasARival) {
  const Cloud fixed = sampled(waves, 5000, 11), moving = sampled(waves, 5000, 12);
  MatchOptions o;
  o.judge = false;
  o.start.m[3] = 1.4 / 5;
  const Matching far = match(moving, fixed, o, {});
  ASSERT_TRUE(far.verdict);
  EXPECT_EQ(far.verdict->grade, Grade::rival) << sentence(*far.verdict, "units");
  o.start.m[3] = 0.001;  // the start decides
  const Matching near = match(moving, fixed, o, {});
  EXPECT_EQ(near.verdict->grade, Grade::trusted) << sentence(*near.verdict, "units");
  EXPECT_LT(std::fabs(near.pose.m[3]), 0.002);
}

}  // namespace
}  // namespace isopach
