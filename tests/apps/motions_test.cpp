// Chains, inverses and screws against motions that are built from what they should give.
#include "isopach/apps/motions.hpp"

#include <gtest/gtest.h>

#include "isopach/distance/vectors.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

Point3 some_point(test::Random& random) {
  return {random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9)};
}

void expect_near(const Point3& a, const Point3& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Motions, ChainsAndInverses) {
  test::Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Pose a =
        test::turn_and_shift(some_point(random), random.uniform(0, 180), some_point(random), some_point(random));
    const Pose b =
        test::turn_and_shift(some_point(random), random.uniform(0, 180), some_point(random), some_point(random));
    const Point3 p = some_point(random);
    expect_near(composed(b, a).apply(p), b.apply(a.apply(p)), 1e-12);
    expect_near(inverted(a).apply(a.apply(p)), p, 1e-12);
    Motion m, n;
    m = moved(m, {0.3, -0.2, 0.5, 1, 2, 3, 0.1}, p);
    n = moved(n, {-0.1, 0.7, 0.2, 3, 2, 1, 0}, p);
    expect_near(composed(n, m).apply(p), n.apply(m.apply(p)), 1e-12);
    expect_near(inverted(m).apply(m.apply(p)), p, 1e-12);
  }
}

TEST(Motions, ScrewGivesBackAxisAngleAndSlide) {
  test::Random random(2);
  for (const double angle : {1e-6, 0.01, 1.0, 60.0, 179.0, 179.9999}) {
    Point3 axis = some_point(random);
    axis = (1 / length(axis)) * axis;
    const Point3 on = some_point(random), near = some_point(random);
    const double slide = random.uniform(-5, 5);
    const Screw s = screw_of(test::turn_and_shift(axis, angle, on, slide * axis), near);
    EXPECT_NEAR(s.angle * 180 / std::acos(-1.0), angle, 1e-9 * angle + 1e-12);
    const double loose = 1e-13 / (angle * 0.017) + 1e-9;
    expect_near(s.direction, axis, loose);
    EXPECT_NEAR(s.slide, slide, 10 * loose);
    // The point lies on the line, and nearest to the one asked about.
    EXPECT_LT(length(cross(s.point - on, axis)), 20 * loose);
    EXPECT_NEAR(dot(s.point - near, axis), 0, 20 * loose);
  }
  const Screw none = screw_of(test::turn_and_shift({1, 0, 0}, 0, {0, 0, 0}, {1, 2, 3}), {4, 5, 6});
  EXPECT_EQ(none.angle, 0);
  EXPECT_EQ(none.direction, (Point3{0, 0, 0}));
}

}  // namespace
}  // namespace isopach
