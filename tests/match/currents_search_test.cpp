// match --objective currents: known poses come back without pairs, from where
// no triangle lies near its place.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/match/match.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/formulas.hpp"

namespace isopach {
namespace {

using test::chained;
using test::off_identity;
using test::PoseError;

Scene relief(std::size_t n, double noise, std::uint64_t seed = 1) {
  SceneOptions o;
  o.points_a = n, o.points_b = n + n / 4;
  o.noise_a = o.noise_b = noise;
  o.variant = "unchanged";
  Context context;
  context.seed = seed;
  return make_scene("relief", o, context);
}

struct Try {
  Matching m;
  PoseError error;
};
/// `b` moved away, matched on `a` by currents.
Try match_back(const Cloud& a, const Cloud& b, const Pose& away, MatchOptions options = {}, int threads = 0) {
  options.compare.check_layers = false;
  options.objective = Objective::currents;
  Context context;
  context.threads = threads;
  Try t{match(test::posed(b, away), a, options, context), {}};
  t.error = off_identity(chained(t.m.pose, away), test::middle_of(b));
  return t;
}

TEST(CurrentsMatch, ReliefComesBack) {
  const Scene s = relief(1500, 0.07);
  const Pose away = test::turn_and_shift({0.1, -0.2, 1}, 4, test::middle_of(s.b), {20, -45, 10});
  const Try t = match_back(s.a, s.b, away);
  EXPECT_TRUE(t.m.converged) << t.m.reason;
  EXPECT_LT(t.error.degrees, 0.3);
  EXPECT_LT(t.error.shift, 2);
  EXPECT_LT(t.m.after.rho, 0.2 * t.m.before.rho);
  EXPECT_LT(t.m.history.back().rho, t.m.history.front().rho);
  EXPECT_EQ(t.m.overlap, 1);
}

// Equal points: the minimum is 0, and the pose is exact.
TEST(CurrentsMatch, OfAScanAndItselfIsExact) {
  const Scene s = relief(1000, 0);
  const Pose away = test::turn_and_shift({0, 0, 1}, 2, test::middle_of(s.a), {12, -7, 5});
  const Try t = match_back(s.a, s.a, away);
  EXPECT_TRUE(t.m.converged) << t.m.reason;
  EXPECT_LT(t.error.degrees, 1e-4);
  EXPECT_LT(t.error.shift, 1e-3);
}

TEST(CurrentsMatch, HasTheSameBitsForAnyThreads) {
  const Scene s = relief(600, 0.07);
  const Pose away = test::turn_and_shift({0, 0, 1}, 1, test::middle_of(s.b), {5, -7, 2});
  EXPECT_EQ(match_back(s.a, s.b, away, {}, 1).m.pose.m, match_back(s.a, s.b, away, {}, 3).m.pose.m);
}

TEST(CurrentsMatch, FreedomAndSigmaAct) {
  const Scene s = relief(600, 0.07);
  const Pose away = test::turn_and_shift({0, 0, 1}, 0, test::middle_of(s.b), {5, -7, 2});
  MatchOptions shifts;
  shifts.freedom.turn_x = shifts.freedom.turn_y = shifts.freedom.turn_z = false;
  const Try t = match_back(s.a, s.b, away, shifts);
  EXPECT_LT(t.error.degrees, 1e-9);
  EXPECT_LT(t.error.shift, 5);
  EXPECT_EQ(t.m.covariance[0], 0);
  MatchOptions wide = shifts;
  wide.sigma = 150;
  const Try u = match_back(s.a, s.b, away, wide);
  EXPECT_GT(std::fabs(u.m.history.back().rho / t.m.history.back().rho - 1), 0.05);
}

TEST(CurrentsMatch, RefusesWhatCurrentsDoNotKnow) {
  const Scene s = relief(300, 0.07);
  const auto fails = [&](MatchOptions o, const std::string& name) {
    try {
      (void)match_back(s.a, s.b, Pose{}, o);
      ADD_FAILURE() << name;
    } catch (const UsageError& e) {
      EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
    }
  };
  MatchOptions scale, overlap, sigma, weight;
  weight.compare.weight = test::weight_by("1");
  fails(weight, "@weight");
  scale.freedom.scale = true, overlap.overlap = 0.5, sigma.sigma = -1;
  fails(scale, "@freedom scale"), fails(overlap, "@overlap"), fails(sigma, "@sigma");
}

// The stated deviations against the spread of the found poses over seeds of the
// noise and of the sampling.
TEST(CurrentsMatch, CovarianceIsOfTheSizeOfTheSpread) {
  constexpr int tries = 8;
  std::array<double, 3> spread{}, stated{};
  for (int i = 0; i < tries; ++i) {
    const Scene s = relief(500, 0.5, static_cast<std::uint64_t>(i + 1));
    const Try t = match_back(s.a, s.b, Pose{});
    const Point3 c = t.m.centre, p = t.m.pose.apply(c);
    const double off[3] = {p.x - c.x, p.y - c.y, p.z - c.z};
    for (std::size_t k = 0; k < 3; ++k) {
      spread[k] += off[k] * off[k] / tries;
      stated[k] += t.m.covariance[7 * (k + 3)] / tries;
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_GT(std::sqrt(stated[k] / spread[k]), 0.4) << k;
    EXPECT_LT(std::sqrt(stated[k] / spread[k]), 2.5) << k;
  }
}

}  // namespace
}  // namespace isopach
