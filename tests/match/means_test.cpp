// Large scans by means of their points, and what hurries steps of points: against the definitions, and against searches
// of all points.
#include "isopach/match/pairs/means.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "isopach/distance/vectors.hpp"
#include "isopach/match/pairs/anderson.hpp"
#include "isopach/match/pairs/icp.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

/// Hills with a relief of `detail`, two bricks of 16384 means across.
Cloud hills(std::size_t n, std::uint64_t seed, double noise, double detail) {
  test::Random random(seed);
  Cloud cloud;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = random.uniform(0, 1), y = random.uniform(0, 1);
    const double z = 0.1 * std::sin(7 * x + 1) * std::cos(6 * y) + 0.05 * std::sin(15 * (x - y)) +
                     detail * std::sin(400 * x) * std::sin(400 * y + 1) + noise * random.bell();
    cloud.points.push_back({x, y, z});
  }
  return cloud;
}

OrientedCloud ordered(const Cloud& cloud) { return order_points(cloud, Pose{}, Frame{}, {}, 0, {}); }

TEST(Means, AreMeansOfAllTheirPoints) {
  const OrientedCloud points = ordered(hills(5000, 1, 0.001, 0));
  for (const std::size_t most : {1u, 10u, 700u, 4000u, 5000u}) {
    const Means means = means_of(points, most);
    EXPECT_LE(means.cloud.points.size(), most);
    EXPECT_GT(means.cloud.points.size() * 8, most);
    std::vector<Point3> sums(means.cloud.points.size(), {0, 0, 0});
    std::vector<double> counts(sums.size(), 0);
    for (std::size_t i = 0; i < points.points.size(); ++i) {
      sums[means.of_point[i]] = sums[means.of_point[i]] + points.points[i];
      counts[means.of_point[i]] += 1;
    }
    for (std::size_t k = 0; k < sums.size(); ++k) {
      ASSERT_GT(counts[k], 0);
      EXPECT_LT(length((1 / counts[k]) * sums[k] - means.cloud.points[k]), 1e-14);
    }
  }
}

TEST(Means, OfOnePlaceAreOne) {
  Cloud cloud;
  cloud.points.assign(100, {1, 2, 3});
  const Means means = means_of(ordered(cloud), 10);
  ASSERT_EQ(means.cloud.points.size(), 1u);
  EXPECT_EQ(length(means.cloud.points[0] - ordered(cloud).points[0]), 0);
}

MatchOptions by(Objective objective) {
  MatchOptions o;
  o.objective = objective;
  return o;
}

Motion away() { return moved(Motion{}, {0.004, -0.003, 0.01, 0.01, -0.008, 0.004, 0}, {0.5, 0.5, 0}); }

IcpFound found_by(const Cloud& moving, const Cloud& fixed, Objective objective) {
  OrientedCloud b = ordered(moving);
  for (Point3& p : b.points) p = away().undo(p);
  return find_by_pairs(std::move(b), ordered(fixed), by(objective), {});
}

double off(const Motion& found) {
  double most = 0;
  for (const Point3& p : {Point3{0, 0, 0}, Point3{1, 0, 0}, Point3{0, 1, 0}, Point3{1, 1, 0}})
    most = std::max(most, length(found.apply(away().undo(p)) - p));
  return most;
}

// Noise is in the means as in the points, by the square root of their number. It takes a second: these are the smallest
// scans that are taken by means.
TEST(Means, SayWhatNoisyPointsSay) {
  for (const Objective objective : {Objective::icp_plane, Objective::icp_gicp}) {
    const IcpFound found = found_by(hills(60000, 2, 0.002, 0), hills(60000, 1, 0.002, 0), objective);
    EXPECT_TRUE(found.moving.of_means);
    EXPECT_LT(found.moving.points.size(), 16385u);
    EXPECT_TRUE(found.state.converged) << found.state.reason;
    EXPECT_LT(off(found.state.motion), 4e-4);
  }
}

// What is finer than the bricks is noise in the means, but says where the scans lie. Two seconds: it takes many points.
TEST(Means, PointsGoOnWhereDetailIsFinerThanBricks) {
  const IcpFound found = found_by(hills(120000, 2, 0, 0.003), hills(120000, 1, 0, 0.003), Objective::icp_plane);
  EXPECT_FALSE(found.moving.of_means);
  EXPECT_EQ(found.moving.points.size(), 120000u);
  EXPECT_EQ(found.of_point[4711], 4711u);
  EXPECT_LT(off(found.state.motion), 4e-5);
}

TEST(Means, SameBitsForAnyThreadsAndOrder) {
  const Cloud fixed = hills(40000, 1, 0.002, 0),
              moving =
                  test::posed(hills(30000, 2, 0.002, 0), test::turn_and_shift({1, 1, 0}, 1, {0, 0, 0}, {0.01, 0, 0}));
  for (const Objective objective : {Objective::icp_plane, Objective::icp_gicp}) {
    const auto run = [&](int threads, const Cloud& b, const Cloud& a) {
      Context context;
      context.threads = threads;
      return icp(b, a, Pose{}, by(objective), context);
    };
    const Matching one = run(1, moving, fixed);
    EXPECT_EQ(one.stable.size(), moving.points.size());
    for (const int threads : {2, 7}) {
      const Matching m = run(threads, moving, fixed);
      EXPECT_EQ(m.pose.m, one.pose.m);
      EXPECT_EQ(m.covariance, one.covariance);
      EXPECT_TRUE(std::equal(m.stable.begin(), m.stable.end(), one.stable.begin(), one.stable.end()));
    }
    EXPECT_EQ(run(2, test::shuffled(moving, 3), test::shuffled(fixed, 4)).pose.m, one.pose.m);
  }
}

// A linear step with a fixed point: in seven motions, as many differences of steps say all of it.
TEST(Anderson, LeadsWhereLinearStepsLead) {
  const Point3 centre{1, 2, 3};
  const Motion base = moved(Motion{}, {0.3, -0.2, 0.4, 1, 2, -1, 0}, centre);
  const Twist shares = {0.9, 0.8, 0.95, 0.5, 0.85, 0.99, 1};
  const Twist goal = {1e-4, -2e-4, 3e-4, 0.01, -0.02, 0.03, 0};
  const auto at = [&](const Twist& left) {  // how far from the goal, turns small: they commute to 1e-7
    Twist t = goal;
    for (std::size_t i = 0; i < 7; ++i) t[i] += left[i];
    return moved(base, t, centre);
  };
  Twist left = {0, 0, -1e-4, 0.01, 0.01, -0.02, 0};  // four shares: five differences find them all
  Anderson ahead(base, centre, 10);
  Motion found;
  for (int step = 0; step < 7; ++step) {  // plain steps all along: six of them, and five differences
    Twist next = left;
    for (std::size_t i = 0; i < 7; ++i) next[i] *= shares[i];
    found = ahead.next(at(left), at(next));
    left = next;
  }
  const Motion end = at({}), plain = at(left);
  const auto far = [&](const Motion& m) { return length(m.apply({4, 0, 1}) - end.apply({4, 0, 1})); };
  EXPECT_LT(far(found), far(plain) / 20);
  ahead.forget();
  const Motion one = ahead.next(at(left), at(left));
  EXPECT_LT(length(one.apply({4, 0, 1}) - plain.apply({4, 0, 1})), 1e-12);
}

}  // namespace
}  // namespace isopach
