// The covariance of a pose covers its errors: pulls of scans that a generator of the tests makes. bench/pulls.py has
// more kinds of scans and more of each; docs/evidence/pulls.md its table.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "isopach/match/match.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/support/pose_pulls.hpp"

namespace isopach {
namespace {

constexpr int pairs = 12;

void expect_covered(const test::PosePairs& p, double least = 0.65, double most = 1.35) {
  const test::PosePulls found = test::pose_pulls(p, pairs, 1);
  EXPECT_EQ(found.without, 0);
  EXPECT_GT(found.rms, least);
  EXPECT_LT(found.rms, most);
}

TEST(MatchPulls, TheSameArea) { expect_covered({}); }

// Four in ten of such pairs had a motion named as not determined, left where it was: errors ten times as large.
TEST(MatchPulls, SeventyPercentInCommonAreDetermined) {
  test::PosePairs p;
  p.moving_from = 0.3;
  p.moving_points = p.fixed_points = 3000;
  const test::PosePulls found = test::pose_pulls(p, pairs, 1);
  EXPECT_EQ(found.without, 0);
  EXPECT_LT(found.rms_error, 0.001);
  EXPECT_LT(found.rms, 1.5);
}

// What is cut off depends on the pose: 2.3 times the deviation that fixed patches would have.
TEST(MatchPulls, AShareOfSeventyPercentCoversWhatTheCutAdds) {
  test::PosePairs p;
  p.options.overlap = 0.7;
  expect_covered(p);
}

TEST(MatchPulls, StripsThatErrAsAWholeAreInTheCovariance) {
  test::PosePairs p;
  p.errors = [](test::Random& random) {
    std::array<double, 60> strip{};
    for (double& s : strip) s = 0.003 * random.bell();
    return [strip](const Point2& q) { return strip[static_cast<std::size_t>(10 + q.x / 0.04)]; };
  };
  expect_covered(p);
}

TEST(MatchPulls, PlanesOfPointsThatShareTheirNoise) {
  test::PosePairs p;
  p.options.objective = Objective::icp_plane;
  p.moving_points = 4500;
  expect_covered(p);
}

TEST(MatchPulls, PlanesOnPlanes) {
  test::PosePairs p;
  p.options.objective = Objective::icp_gicp;
  p.moving_points = 4500;
  expect_covered(p);
}

// Points of a dense FIXED lie above and below one another within its noise, so a partner lies as the point does: the
// matrix of the steps, which takes pairs as fixed, promises 1.4 times too much.
TEST(MatchPulls, PlanesOfAFixedScanThatIsMuchDenser) {
  test::PosePairs p;
  p.options.objective = Objective::icp_plane;
  p.moving_points = 1000, p.fixed_points = 4000;
  expect_covered(p, 0.65, 1.25);
}

}  // namespace
}  // namespace isopach
