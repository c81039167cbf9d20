#include "isopach/apps/evidence.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "isopach/distance/vectors.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

using Near = std::array<Index, Evidence::neighbours>;

/// Oracle: the same sum of squares written out as one dense system.
TEST(SmoothField, IsTheMinimumOfItsSum) {
  test::Random random(1);
  constexpr std::size_t n = 60;
  std::vector<Near> near(n);
  std::vector<double> own(n), certainty(n);
  for (std::size_t i = 0; i < n; ++i) {
    near[i].fill(no_index);
    for (std::size_t k = 0; k < i % 9 && k < near[i].size(); ++k)
      near[i][k] = static_cast<Index>(random.uniform(0, 0.999) * n);
    for (Index& j : near[i])
      if (j == i) j = no_index;
    own[i] = random.uniform(0, 1);
    certainty[i] = i % 5 == 0 ? 0 : random.uniform(0, 100);
  }
  const double stiffness = 7;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto r = static_cast<Eigen::Index>(i);
    a(r, r) += certainty[i] + 1e-9 * stiffness;
    b(r) += certainty[i] * own[i];
    for (const Index j : near[i]) {
      if (j == no_index) continue;
      Eigen::VectorXd edge = Eigen::VectorXd::Zero(n);
      edge(r) += 1, edge(static_cast<Eigen::Index>(j)) -= 1;
      a += stiffness * edge * edge.transpose();
    }
  }
  const Eigen::VectorXd expected = a.fullPivLu().solve(b);
  const Array<double> found = smooth_field(near, own, certainty, stiffness, 0);
  for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(found[i], expected(static_cast<Eigen::Index>(i)), 1e-6);
}

TEST(SmoothField, FillsWhatNobodyKnowsAndLeavesTheLonely) {
  // A chain 0 − 1 − 2 with known ends, and a point alone.
  std::vector<Near> near(4);
  for (Near& one : near) one.fill(no_index);
  near[0][0] = 1, near[1][0] = 2;
  const std::vector<double> own{0, 0.9, 1, 0.3}, certainty{1e9, 0, 1e9, 0};
  const Array<double> found = smooth_field(near, own, certainty, 1, 0.25);
  EXPECT_NEAR(found[1], 0.5, 1e-6);
  EXPECT_NEAR(found[3], 0.25, 1e-6);
}

OrientedCloud oriented(const Array<Point3>& points) {
  Cloud cloud;
  cloud.points = points;
  const Frame frame = choose_frame(cloud, cloud, Pose{}, {}, {});
  OrientedCloud result = order_points(cloud, Pose{}, frame, {}, 0, {});
  orient(result, {});
  return result;
}

/// A wavy strip whose right half is lifted: the blend is 0 on the left, 1 on the right.
TEST(Evidence, TellsWhoMoved) {
  test::Random random(3);
  Array<Point3> rest, lifted;
  for (int i = 0; i < 2500; ++i) {
    for (Array<Point3>* side : {&rest, &lifted}) {
      const double x = random.uniform(-10, 10), y = random.uniform(-5, 5);
      const double lift = side == &lifted && x > 0 ? 1 : 0;
      side->push_back({x, y, 0.5 * std::sin(x) * std::cos(y) + lift + 0.01 * random.uniform(-1, 1)});
    }
  }
  const OrientedCloud model = oriented(rest), frame = oriented(lifted);
  Evidence evidence(model);
  Motion up;
  up.shift = {0, 0, 1};
  for (int k = 0; k < 3; ++k) evidence.add(frame, Motion{}, up, 0.02, 1);
  EXPECT_EQ(evidence.frames(), 3u);
  const Array<double> blend = evidence.blend();
  for (std::size_t i = 0; i < blend.size(); ++i)
    // Nearer the step the sixteen neighbours of a plane (mean radius 0.64) lie on both sides.
    if (std::fabs(model.points[i].x) > 1.2) {
      EXPECT_EQ(blend[i] > 0.5, model.points[i].x > 0) << model.points[i].x;
    }
  evidence.clear();
  for (const double b : evidence.blend()) EXPECT_NEAR(b, 0, 1e-12);
}

TEST(Evidence, DistanceIsToThePlaneNearbyAndToThePointFarAway) {
  Array<Point3> grid;
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) grid.push_back({0.1 * i, 0.1 * j, 0});
  const OrientedCloud plane = oriented(grid);
  const Point3 origin = plane.points[0];
  const Point3 near = origin + Point3{0.04, 0.04, 0.2}, far{origin.x, origin.y, origin.z + 7};
  EXPECT_NEAR(surface_distance(plane, near, 1), 0.2, 1e-12);
  EXPECT_NEAR(surface_distance(plane, far, 1), 7, 1e-12);
  EXPECT_GT(surface_distance(plane, near, 0.1), 0.2);
}

}  // namespace
}  // namespace isopach
