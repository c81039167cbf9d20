// match: known poses come back, whatever the start, the change between the scans, the threads and the order of points.
#include "isopach/match/match.hpp"

#include <gtest/gtest.h>

#include <string>

#include "isopach/base/error.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

using test::chained;
using test::off_identity;
using test::PoseError;

constexpr double kilometre = 1000;

Scene scene(const std::string& name, const std::string& variant, std::size_t n, double noise, std::uint64_t seed = 1) {
  SceneOptions o;
  o.points_a = n, o.points_b = n + n / 4;
  o.noise_a = o.noise_b = noise;
  o.variant = variant;
  Context context;
  context.seed = seed;
  return make_scene(name, o, context);
}

/// `b` moved away by `away`, matched on `a`.
struct Try {
  Matching m;
  PoseError error;
};
Try match_back(const Cloud& a, const Cloud& b, const Pose& away, MatchOptions options = {}, int threads = 0) {
  options.compare.check_layers = false;
  Context context;
  context.threads = threads;
  Try t{match(test::posed(b, away), a, options, context), {}};
  t.error = off_identity(chained(t.m.pose, away), test::middle_of(b));
  return t;
}

Cloud part(Cloud cloud, bool (*keep)(const Point3&)) {
  std::erase_if(cloud.points, [&](const Point3& p) { return !keep(p); });
  cloud.attributes.clear();
  return cloud;
}

// Noise a thousandth of the relief; the accuracy of 10⁵ points (0.005 degrees, 2·10⁻⁵ of the extent), scaled by the
// square root of the number of points.
TEST(Match, ReliefFromStartsInTheBasin) {
  const Scene s = scene("relief", "unchanged", 10000, 0.07);
  for (const auto& [degrees, shift] : {std::pair{10.0, Point3{20, -45, 10}}, std::pair{-7.0, Point3{-30, 10, -20}}}) {
    const Pose away = test::turn_and_shift({0.1, -0.2, 1}, degrees, test::middle_of(s.b), shift);
    const Try t = match_back(s.a, s.b, away);
    EXPECT_TRUE(t.m.converged) << t.m.reason;
    EXPECT_LT(t.error.degrees, 0.015);
    EXPECT_LT(t.error.shift, 6e-5 * kilometre);
    EXPECT_LT(t.m.after.rho, 0.1 * t.m.before.rho);
    EXPECT_TRUE(t.m.weak_directions.empty());
  }
}

TEST(Match, FortyFiveDegreesAboutTheAxis) {
  const Scene s = scene("relief", "unchanged", 8000, 0.07);
  for (const double degrees : {45.0, -45.0, 30.0}) {
    const Pose away = test::turn_and_shift({0, 0, 1}, degrees, test::middle_of(s.b), {20, -20, 5});
    EXPECT_LT(match_back(s.a, s.b, away).error.degrees, 0.02) << degrees;
  }
}

TEST(Match, FaceAndTiltsOfTenDegrees) {
  const Scene s = scene("face", "", 10000, 0.03);
  const Pose away = test::turn_and_shift({1, 2, 3}, 10, test::middle_of(s.b), {5, -6, 4});
  const Try t = match_back(s.a, s.b, away);
  EXPECT_TRUE(t.m.converged) << t.m.reason;
  EXPECT_LT(t.error.degrees, 0.015);
  EXPECT_LT(t.error.shift, 6e-5 * 236);
  EXPECT_TRUE(t.m.weak_directions.empty()) << t.m.weak_directions[0];
}

TEST(Match, SixtyPerCentOverlap) {
  const Scene s = scene("relief", "unchanged", 12000, 0.07);
  const Cloud a = part(s.a, [](const Point3&p) { return p.x < 750; }),
              b = part(s.b, [](const Point3&p) { return p.x > 250; });
  const Pose away = test::turn_and_shift({0, 0.2, 1}, 5, test::middle_of(b), {20, 10, 0});
  const Try t = match_back(a, b, away);
  EXPECT_LT(t.error.degrees, 0.02);
  EXPECT_LT(t.error.shift, 1e-4 * kilometre);
}

// The change itself does not drag the pose; fitting everything does.
TEST(Match, RealChangeDoesNotPull) {
  const Scene s = scene("terrain", "", 20000, 0.03);
  const Pose away = test::turn_and_shift({0.1, 0.1, 1}, 3, test::middle_of(s.b), {10, -15, 3});
  const Try robust = match_back(s.a, s.b, away);
  MatchOptions all;
  all.overlap = 1;
  const Try everything = match_back(s.a, s.b, away, all);
  EXPECT_LT(robust.error.degrees, 0.002);
  EXPECT_LT(robust.error.shift, 2e-5 * kilometre);
  EXPECT_GT(everything.error.shift, 3 * robust.error.shift);
  EXPECT_EQ(everything.m.overlap, 1);
  MatchOptions share;
  share.overlap = 0.8;
  const Try eighty = match_back(s.a, s.b, away, share);
  EXPECT_LT(eighty.error.shift, 0.5 * everything.error.shift);
  EXPECT_LE(eighty.m.overlap, 0.81);
}

TEST(Match, ForwardAndBackAreInverse) {
  const Scene s = scene("terrain", "", 10000, 0.03);
  const Cloud b = test::posed(s.b, test::turn_and_shift({0, 0.1, 1}, 2, test::middle_of(s.b), {10, 5, 1}));
  MatchOptions options;
  options.compare.check_layers = false;
  const Pose there = match(b, s.a, options, {}).pose, back = match(s.a, b, options, {}).pose;
  const PoseError error = off_identity(chained(there, back), test::middle_of(s.a));
  EXPECT_LT(error.degrees, 5e-4);
  EXPECT_LT(error.shift, 1e-5 * kilometre);
}

// Large map coordinates and millimetres: the pose, applied to the points, gives the reported measure.
TEST(Match, RoundTripInLargeCoordinates) {
  Scene s = scene("terrain", "", 4000, 0.001);
  const Pose away = test::turn_and_shift({0, 0.1, 1}, 1, test::middle_of(s.b), {12, -7, 2});
  const Cloud moving = test::posed(s.b, away);
  MatchOptions options;
  const Matching m = match(moving, s.a, options, {});
  const Comparison again = compare(s.a, test::posed(moving, m.pose), options.compare, {});
  EXPECT_EQ(again.measures.rho, m.after.rho);
  EXPECT_EQ(again.coverage, m.after.coverage);
  const Comparison before = compare(s.a, moving, options.compare, {});
  EXPECT_EQ(before.measures.rho, m.before.rho);
  EXPECT_EQ(m.stable.size(), s.b.points.size());
}

TEST(Match, SameBitsForAnyThreadsAndOrder) {
  const Scene s = scene("terrain", "", 6000, 0.03);
  const Pose away = test::turn_and_shift({0.1, 0, 1}, 2, test::middle_of(s.b), {10, -5, 2});
  const Matching one = match_back(s.a, s.b, away, {}, 1).m;
  for (const int threads : {2, 3}) {
    const Matching other = match_back(s.a, s.b, away, {}, threads).m;
    EXPECT_EQ(other.pose.m, one.pose.m);
    EXPECT_EQ(other.covariance, one.covariance);
    EXPECT_EQ(other.after.rho, one.after.rho);
  }
  Cloud a = s.a, b = s.b;
  a.attributes.clear(), b.attributes.clear();
  EXPECT_EQ(match_back(test::shuffled(a, 3), test::shuffled(b, 4), away).m.pose.m, one.pose.m);
}

// From 20000 nodes on a sample of the patches goes first.
TEST(Match, SampledScansHaveTheSameBitsForAnyThreadsLarge) {
  const Scene s = scene("relief", "unchanged", 22000, 0.07);
  const Pose away = test::turn_and_shift({0.3, -0.2, 1}, 8, test::middle_of(s.b), {30, -20, 5});
  MatchOptions options;
  options.judge = false;
  const Try one = match_back(s.a, s.b, away, options, 1), three = match_back(s.a, s.b, away, options, 3);
  EXPECT_TRUE(one.m.converged) << one.m.reason;
  EXPECT_LT(one.error.degrees, 0.005);
  EXPECT_LT(one.error.shift, 4e-5 * kilometre);
  EXPECT_EQ(three.m.pose.m, one.m.pose.m);
  EXPECT_EQ(three.m.covariance, one.m.covariance);
  EXPECT_EQ(three.m.stable, one.m.stable);
  EXPECT_EQ(match_back(test::shuffled(s.a, 3), test::shuffled(s.b, 4), away, options).m.pose.m, one.m.pose.m);
  // As near as steps of the full tolerance lead, compared with what noise does.
  options.tolerance = 1e-8;
  const Pose finest = match_back(s.a, s.b, away, options).m.pose;
  const auto moved = [&](const Pose& pose) { return off_identity(chained(pose, away), test::middle_of(s.b)); };
  EXPECT_NEAR(moved(one.m.pose).degrees, moved(finest).degrees, 3e-4);
}

// The measure never rises between accepted steps.
TEST(Match, HistoryFalls) {
  const Scene s = scene("relief", "unchanged", 5000, 0.07);
  MatchOptions all;
  all.overlap = 1;
  all.tolerance = 1e-10;  // or the history may hold no step: the weights have settled near the end before it begins
  const Matching m = match_back(s.a, s.b, test::turn_and_shift({0, 0, 1}, 1, test::middle_of(s.b), {5, 5, 1}), all).m;
  ASSERT_GE(m.history.size(), 2u);
  for (std::size_t i = 1; i < m.history.size(); ++i)
    EXPECT_LE(m.history[i].rho, m.history[i - 1].rho * (1 + 1e-12)) << i;
}

TEST(Match, ScaleIsFreeWhenAskedFor) {
  const Scene s = scene("relief", "unchanged", 8000, 0.02);
  Pose away = test::turn_and_shift({0, 0, 1}, 2, {500, 500, 0}, {5, 5, 1});
  for (std::size_t i : {0, 1, 2, 4, 5, 6, 8, 9, 10}) away.m[i] *= 1.01;
  MatchOptions options;
  options.freedom.scale = true;
  const Matching m = match_back(s.a, s.b, away, options).m;
  EXPECT_NEAR(m.scale * 1.01, 1, 2e-4);
  EXPECT_EQ(match_back(s.a, s.b, away).m.scale, 1);
}

TEST(Match, FreedomIsKept) {
  const Scene s = scene("relief", "unchanged", 4000, 0.05);
  MatchOptions shifts;
  shifts.freedom = {true, true, true, false, false, false, false};
  const Pose away = test::turn_and_shift({0, 0, 1}, 0, {500, 500, 0}, {8, 5, 1});
  const Try t = match_back(s.a, s.b, away, shifts);
  EXPECT_EQ(off_identity(t.m.pose, {0, 0, 0}).degrees, 0);
  EXPECT_LT(t.error.shift, 0.1);
  shifts.freedom.shift_x = false;
  EXPECT_EQ(match_back(s.a, s.b, away, shifts).m.pose.m[3], 0);
}

// Nothing holds a plane in its own plane: those motions are named and stay as they were.
TEST(Match, PlaneStaysWhereItIs) {
  const auto tilted = [](double lift, std::uint64_t seed) {
    return [lift, random = test::Random(seed)](const Point2& p) mutable {
      return 0.1 * p.x - 0.2 * p.y + lift + random.uniform(-0.002, 0.002);
    };
  };
  const Cloud a = test::cloud_over(test::framed_square(4000, 1), tilted(0, 5)),
              b = test::cloud_over(test::framed_square(3000, 2), tilted(0.05, 6));
  const Try t = match_back(a, b, Pose{});
  EXPECT_GE(t.m.weak_directions.size(), 3u);
  EXPECT_NEAR(t.m.pose.apply({0.5, 0.5, 0.05}).x, 0.5, 0.02);
  EXPECT_NEAR(t.m.pose.apply({0.5, 0.5, 0.05}).y, 0.5, 0.02);
  EXPECT_LT(std::fabs(std::asin(t.m.pose.m[1])), 2e-3);
  EXPECT_LT(t.m.after.rho, 0.002);
}

TEST(Match, NothingTurnsABowl) {
  const auto bowl = [](const Point2& p) { return std::pow(p.x - 0.5, 2) + std::pow(p.y - 0.5, 2); };
  const Cloud a = test::cloud_over(test::framed_square(4000, 1), bowl),
              b = test::cloud_over(test::framed_square(3000, 2), bowl);
  const Try t = match_back(a, b, test::turn_and_shift({0, 0, 1}, 0, {0.5, 0.5, 0}, {0.03, -0.02, 0.01}));
  ASSERT_EQ(t.m.weak_directions.size(), 1u);
  EXPECT_NE(t.m.weak_directions[0].find("turn about z"), std::string::npos) << t.m.weak_directions[0];
  EXPECT_LT(t.error.shift, 1e-3);
  EXPECT_LT(t.error.degrees, 1);
}

TEST(Match, OfAScanWithItself) {
  const Scene s = scene("relief", "unchanged", 3000, 0.05);
  const Try t = match_back(s.a, s.a, Pose{});
  EXPECT_TRUE(t.m.converged);
  EXPECT_EQ(t.m.after.rho, 0);
  EXPECT_TRUE(t.m.pose.is_identity());
}

TEST(Match, Refusals) {
  const Scene s = scene("relief", "unchanged", 500, 0.05);
  // Where all motions are free, scans that lie apart are looked for; where some are held, they are not.
  MatchOptions held;
  held.freedom.turn_z = false;
  EXPECT_THROW((void)match(test::shifted(s.b, {5000, 0, 0}), s.a, held, {}), OverlapError);
  MatchOptions bad;
  bad.overlap = 1.5;
  EXPECT_THROW((void)match(s.b, s.a, bad, {}), UsageError);
  bad = {};
  bad.freedom = {false, false, false, false, false, false, false};
  EXPECT_THROW((void)match(s.b, s.a, bad, {}), UsageError);
  bad = {};
  bad.max_iterations = 0;
  EXPECT_THROW((void)match(s.b, s.a, bad, {}), UsageError);
  bad = {};
  bad.tolerance = -1;
  EXPECT_THROW((void)match(s.b, s.a, bad, {}), UsageError);
  bad = {};
  bad.compare.pose.m[3] = 1;
  EXPECT_THROW((void)match(s.b, s.a, bad, {}), UsageError);
}

TEST(Match, StopsWhenItMay) {
  const Scene s = scene("relief", "unchanged", 3000, 0.05);
  MatchOptions one;
  one.max_iterations = 1;
  const Try t = match_back(s.a, s.b, test::turn_and_shift({0, 0, 1}, 3, {500, 500, 0}, {8, 5, 1}), one);
  EXPECT_FALSE(t.m.converged);
  EXPECT_NE(t.m.reason.find("@max-iterations"), std::string::npos);
}

}  // namespace
}  // namespace isopach
