// What a matching says of itself: covariance against errors that are known, stable points against a change that is
// known, weakly held motions; weights.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "isopach/base/error.hpp"
#include "isopach/match/match.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/formulas.hpp"

namespace isopach {
namespace {

Cloud noisy(std::size_t n, std::uint64_t seed, double noise, const std::function<double(const Point2&)>& height) {
  return test::cloud_over(test::framed_square(n, seed), [&, random = test::Random(seed)](const Point2& p) mutable {
    return height(p) + noise * std::sqrt(3.0) * random.uniform(-1, 1);
  });
}

double hills(const Point2& p) {
  return 0.05 * std::sin(11 * p.x) * std::cos(9 * p.y) + 0.03 * std::sin(5 * p.x + 7 * p.y);
}

MatchOptions quick() {
  MatchOptions options;
  options.compare.check_layers = false;
  options.judge = false;
  return options;
}

// Errors of scans with noise of their own, in the standard deviations that the matching gives: their mean square is
// about 1 (1 is what a covariance without sampling errors would give; 48 squares each).
TEST(MatchQuality, CovarianceTellsTheErrors) {
  constexpr int pairs = 16;
  double turns = 0, shifts = 0;
  for (int k = 0; k < pairs; ++k) {
    const auto seed = static_cast<std::uint64_t>(10 * k);
    const Matching m = match(noisy(3000, seed + 1, 0.002, hills), noisy(3000, seed + 2, 0.002, hills), quick(), {});
    const Point3 moved = m.pose.apply(m.centre);
    const double turn[3] = {m.pose.m[9], m.pose.m[2], m.pose.m[4]};
    const double shift[3] = {moved.x - m.centre.x, moved.y - m.centre.y, moved.z - m.centre.z};
    for (std::size_t i = 0; i < 3; ++i) {
      turns += turn[i] * turn[i] / m.covariance[7 * i];
      shifts += shift[i] * shift[i] / m.covariance[7 * (3 + i)];
    }
  }
  for (const double mean_square : {turns / (3 * pairs), shifts / (3 * pairs)}) {
    EXPECT_GT(mean_square, 0.5);
    EXPECT_LT(mean_square, 2.2);
  }
}

TEST(MatchQuality, StablePointsAreThoseThatDidNotChange) {
  const auto changed = [](const Point2& p) { return std::hypot(p.x - 0.7, p.y - 0.3) < 0.2; };
  const Cloud fixed = noisy(8000, 1, 0.001, hills),
              moving = noisy(8000, 2, 0.001, [&](const Point2&p) { return hills(p) + (changed(p) ? 0.02 : 0.0); });
  const Matching m = match(moving, fixed, quick(), {});
  double kept_there = 0, there = 0, kept_elsewhere = 0, elsewhere = 0;
  for (std::size_t i = 0; i < moving.points.size(); ++i) {
    const bool is_there = changed({moving.points[i].x, moving.points[i].y});
    (is_there ? there : elsewhere) += 1;
    (is_there ? kept_there : kept_elsewhere) += m.stable[i];
  }
  EXPECT_LT(kept_there / there, 0.02);
  EXPECT_GT(kept_elsewhere / elsewhere, 0.93);  // patches across the edge are left out as a whole: 250 patches in all
  EXPECT_LT(test::off_identity(m.pose, m.centre).shift, 2e-4);
}

TEST(MatchQuality, WithoutComparisonsThePoseIsTheSame) {
  const Cloud fixed = noisy(2000, 1, 0.001, hills),
              moving = test::posed(noisy(1500, 2, 0.001, hills),
                                   test::turn_and_shift({0, 0.1, 1}, 2, {0.5, 0.5, 0}, {0.02, 0.01, 0}));
  MatchOptions options = quick();
  const Matching pose_only = match(moving, fixed, options, {});
  options.judge = options.keep_comparisons = true;
  const Matching all = match(moving, fixed, options, {});
  EXPECT_EQ(pose_only.pose.m, all.pose.m);
  EXPECT_EQ(pose_only.covariance, all.covariance);
  EXPECT_TRUE(std::isnan(pose_only.before.rho) && std::isnan(pose_only.after.coverage));
  EXPECT_EQ(pose_only.moving.nodes, all.moving.nodes);
  EXPECT_EQ(pose_only.unit, all.unit);
  EXPECT_FALSE(pose_only.comparison_after.has_value());
  EXPECT_EQ(all.comparison_before->measures.rho, all.before.rho);
  EXPECT_EQ(all.comparison_after->measures.rho, all.after.rho);
  MatchOptions far = quick();
  far.start.m[3] = 50;
  far.freedom.turn_z = false;  // else the place is looked for
  EXPECT_THROW((void)match(moving, fixed, far, {}), OverlapError);
}

// Waves along x hold everything but the shift along y, which a hundredth of them holds.
TEST(MatchQuality, AWeaklyHeldShiftIsNamed) {
  const auto waves = [](const Point2& p) { return 0.05 * std::sin(12 * p.x) + 0.0015 * std::sin(10 * p.y); };
  const Matching m = match(noisy(6000, 1, 1e-5, waves), noisy(6000, 2, 1e-5, waves), quick(), {});
  EXPECT_TRUE(m.converged);
  ASSERT_FALSE(m.weak_directions.empty());
  EXPECT_NE(m.weak_directions[0].find("shift along y is weakly held"), std::string::npos) << m.weak_directions[0];
  const std::size_t of_verdict = m.verdict->trusted() ? 0 : 1;
  EXPECT_EQ(m.warnings.size(), m.weak_directions.size() + of_verdict);
  EXPECT_LT(test::off_identity(m.pose, m.centre).shift, 0.01);
  EXPECT_GT(m.covariance[28], 10 * m.covariance[21]);
}

// Half of MOVING is shifted; the weight says which half counts.
TEST(MatchQuality, WeightsSayWhatCounts) {
  const Cloud fixed = noisy(6000, 1, 0.0005, hills);
  Cloud moving = noisy(6000, 2, 0.0005, hills);
  Attribute left{"left", Array<double>(moving.points.size())};
  for (std::size_t i = 0; i < moving.points.size(); ++i) {
    Point3& p = moving.points[i];
    left.values[i] = p.x < 0.45 ? 1 : 0;
    if (p.x >= 0.5) p.z += 0.01;
  }
  moving.attributes.push_back(left);
  MatchOptions options = quick();
  options.overlap = 1;
  options.freedom = {false, false, true, false, false, false, false};
  EXPECT_GT(match(moving, fixed, options, {}).pose.m[11], -0.009);
  EXPECT_LT(match(moving, fixed, options, {}).pose.m[11], -0.001);
  using Kind = WeightSource::Kind;
  options.compare.weight = {Kind::attribute, WeightSource::Scan::any, "left"};
  EXPECT_NEAR(match(moving, fixed, options, {}).pose.m[11], 0, 1e-4);
  options.compare.weight = test::weight_by("x < 0.45");
  EXPECT_NEAR(match(moving, fixed, options, {}).pose.m[11], 0, 1e-4);
  options.compare.weight = test::weight_by("x > 0.55");
  EXPECT_NEAR(match(moving, fixed, options, {}).pose.m[11], -0.01, 1e-4);
  options.compare.weight = test::weight_by("x > 5");
  EXPECT_THROW((void)match(moving, fixed, options, {}), InputError);
  options.compare.weight = test::weight_by("x - 5");
  EXPECT_THROW((void)match(moving, fixed, options, {}), InputError);
  options.compare.weight = {Kind::attribute, WeightSource::Scan::a, "left"};
  EXPECT_THROW((void)match(moving, fixed, options, {}), InputError);
}

}  // namespace
}  // namespace isopach
