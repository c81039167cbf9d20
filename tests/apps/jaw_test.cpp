#include "isopach/apps/jaw.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/apps/motions.hpp"
#include "isopach/distance/vectors.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;

TEST(Jaw, PureHingeIsFoundExactly) {
  const Point3 axis = (1 / std::sqrt(14.0)) * Point3{1, 2, 3}, on{5, -4, 2};
  std::vector<Pose> motions;
  for (const double angle : {0.0, 3.0, 9.0, 20.0, 11.0})
    motions.push_back(test::turn_and_shift(axis, angle, on, {0, 0, 0}));
  const auto found = hinge_axis(motions, {30, 10, 0}, degree);
  ASSERT_TRUE(found);
  EXPECT_NEAR(dot(found->direction, axis), 1, 1e-12);
  EXPECT_LT(length(cross(found->point - on, axis)), 1e-9);
  EXPECT_NEAR(found->rest, 0, 1e-9);
  EXPECT_NEAR(dot(found->point - Point3{30, 10, 0}, axis), 0, 1e-9) << "the nearest point of the line";
  // Turned the other way, the direction turns too: the widest opening is positive.
  for (Pose& m : motions) m = inverted(m);
  EXPECT_NEAR(dot(hinge_axis(motions, {30, 10, 0}, degree)->direction, axis), -1, 1e-12);
}

/// Oracle: no other point across the axis has a smaller sum, by trying.
TEST(Jaw, AxisMovesLeast) {
  test::Random random(4);
  std::vector<Pose> motions;
  for (int i = 0; i < 12; ++i)
    motions.push_back(test::turn_and_shift({10, random.uniform(-1, 1), random.uniform(-1, 1)}, random.uniform(0, 25),
                                           {1, 2, 3},
                                           {random.uniform(-1, 1), random.uniform(-3, 3), random.uniform(-3, 3)}));
  const auto sum = [&](const Point3& p) {
    double s = 0;
    for (const Pose& m : motions) s += squared_length(m.apply(p) - p);
    return s;
  };
  const HingeAxis found = *hinge_axis(motions, {0, 0, 0}, degree);
  EXPECT_NEAR(found.rest, std::sqrt(sum(found.point) / 12), 1e-12);
  for (int i = 0; i < 500; ++i) {
    Point3 d{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
    d = d - dot(d, found.direction) * found.direction;
    EXPECT_GE(sum(found.point + d), sum(found.point));
  }
  // Along no direction does the sum grow more slowly than along the axis.
  const auto growth = [&](const Point3& d) {
    double s = 0;
    for (const Pose& m : motions) s += squared_length(turned(m, d) - d);
    return s;
  };
  for (int i = 0; i < 500; ++i) {
    const Point3 d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    EXPECT_GE(growth((1 / length(d)) * d) * (1 + 1e-12), growth(found.direction));
  }
}

TEST(Jaw, SlidesHaveNoAxis) {
  const std::vector<Pose> motions{test::turn_and_shift({1, 0, 0}, 0.5, {0, 0, 0}, {1, 2, 3}),
                                  test::turn_and_shift({1, 0, 0}, 0, {0, 0, 0}, {4, 2, 3})};
  EXPECT_FALSE(hinge_axis(motions, {0, 0, 0}, degree));
  EXPECT_FALSE(hinge_axis(std::vector<Pose>{Pose{}, Pose{}}, {0, 0, 0}, 0));
}

TEST(Jaw, TurnAboutAnAxisIsSigned) {
  for (const double angle : {-170.0, -20.0, 0.0, 5.0, 120.0}) {
    const Pose m = test::turn_and_shift({0, 0, 1}, angle, {1, 1, 1}, {2, 2, 2});
    EXPECT_NEAR(turn_about(m, {0, 0, 1}), angle * degree, 1e-12);
    EXPECT_NEAR(turn_about(m, {0, 0, -1}), -angle * degree, 1e-12);
    EXPECT_NEAR(turn_about(m, {1, 0, 0}), 0, 1e-12);
  }
  // A swing across the axis does not count.
  const Pose both = composed(test::turn_and_shift({1, 0, 0}, 10, {0, 0, 0}, {0, 0, 0}),
                             test::turn_and_shift({0, 0, 1}, 30, {0, 0, 0}, {0, 0, 0}));
  EXPECT_NEAR(turn_about(both, {0, 0, 1}), 30 * degree, 1e-12);
}

TEST(Jaw, HingeFrame) {
  const HingeAxis axis{{1, 2, 3}, {1, 0, 0}, 0};
  const Pose f = hinge_frame(axis, {7, 2, 9});
  EXPECT_EQ(f.apply({0, 0, 0}), (Point3{1, 2, 3}));
  EXPECT_EQ(f.apply({1, 0, 0}), (Point3{2, 2, 3}));
  EXPECT_EQ(f.apply({0, 0, 1}), (Point3{1, 2, 4}));
  EXPECT_EQ(f.apply({0, 1, 0}), (Point3{1, 3, 3}));
  const Pose on = hinge_frame(axis, {9, 2, 3});  // front on the axis: some frame, a right-handed one
  const Point3 x = turned(on, {1, 0, 0}), y = turned(on, {0, 1, 0}), z = turned(on, {0, 0, 1});
  EXPECT_NEAR(length(cross(x, y) - z), 0, 1e-12);
}

TEST(Jaw, SmoothPathKeepsParabolasAndCalmsNoise) {
  std::vector<double> times;
  std::vector<Point3> curve, noisy;
  test::Random random(9);
  for (int i = 0; i < 40; ++i) {
    if (i == 7 || i == 8) continue;  // skipped frames
    const double t = i;
    times.push_back(t);
    curve.push_back({3 + 2 * t - 0.1 * t * t, t, 5});
    noisy.push_back({random.uniform(-1, 1), 0, 0});
  }
  const auto same = smooth_path(times, curve, 3);
  for (std::size_t i = 0; i < curve.size(); ++i) EXPECT_NEAR(length(same[i] - curve[i]), 0, 1e-9);
  EXPECT_EQ(smooth_path(times, noisy, 0), noisy);
  const auto calm = smooth_path(times, noisy, 4);
  double before = 0, after = 0;
  for (std::size_t i = 0; i < noisy.size(); ++i) before += noisy[i].x * noisy[i].x, after += calm[i].x * calm[i].x;
  EXPECT_LT(after, 0.6 * before);
  EXPECT_EQ(smooth_path(std::vector<double>{0, 1}, std::vector<Point3>{{1, 1, 1}, {2, 2, 2}}, 2).size(), 2u);
}

}  // namespace
}  // namespace isopach
