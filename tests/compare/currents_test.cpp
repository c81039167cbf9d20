// Which part of both scans is compared as currents.
#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/error.hpp"
#include "isopach/compare/compare.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

constexpr double wide = 1e6;  // against 10: at this width of the kernel the norm of a plane is its area

CompareOptions as_currents(BorderRule border) {
  CompareOptions options;
  options.measure = MeasureKind::currents;
  options.border = border;
  options.currents.sigma = wide;
  options.surface = Surface::overlay;
  return options;
}

/// The plane z = 0.75 x + lift: its area is 1.25 times that under it.
Cloud plane(const Points& xy, double lift) {
  return cloud_over(xy, [lift](const Point2& p) { return 0.75 * p.x + lift; });
}

// Of two coarse scans with rims of their own most triangles hang over the rim of the other.
TEST(Currents, TrianglesAtTheRimOfTheOtherScanAreCut) {
  const Cloud a = plane(uniform(40, 1), 0), b = plane(uniform(40, 2), 0.01);
  for (const BorderRule border : {BorderRule::trim, BorderRule::hull}) {
    const Comparison c = compare(a, b, as_currents(border), {});
    const double area = 1.25 * c.domain_area;  // of the exact overlay of both footprints
    ASSERT_GT(area, 0.5);
    EXPECT_NEAR(std::sqrt(c.currents->sums.norm_a2), area, 1e-9);
    EXPECT_NEAR(std::sqrt(c.currents->sums.norm_b2), area, 1e-9);
    EXPECT_LT(c.currents->relative(), 1e-6);
  }
}

TEST(Currents, AScanOverOneTriangleOfTheOtherCutsIt) {
  const Cloud b = plane(framed_square(100, 3), 0);
  const Cloud a = plane({{-9, -9}, {10, -9}, {10, 10}, {-9, 10}}, 1);
  const Comparison c = compare(a, b, as_currents(BorderRule::hull), {});
  EXPECT_LE(c.currents->triangles_a, 2U);
  EXPECT_NEAR(std::sqrt(c.currents->sums.norm_a2), 1.25, 1e-9);
  EXPECT_NEAR(std::sqrt(c.currents->sums.norm_b2), 1.25, 1e-9);
}

// The centroid of what is cut is that of the part over the other scan: of two halves of a square, not of the square.
TEST(Currents, WhatIsCutLiesWhereItsPartLies) {
  const Cloud a = cloud_over({{0, 0}, {2, 0}, {2, 2}, {0, 2}}, [](const Point2&) { return 0.0; });
  const Cloud b = cloud_over({{0, 0}, {1, 0}, {1, 2}, {0, 2}}, [](const Point2&) { return 0.0; });
  CompareOptions options = as_currents(BorderRule::hull);
  options.currents = {1, 1e-9};
  const Comparison c = compare(a, b, options, {});
  // A is cut along x = 1 into a triangle of area 1/2 and one of 3/2, B is two of area 1.
  const auto kernel = [](const Point2& p, const Point2& q) {
    return std::exp(-((p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y)));
  };
  ASSERT_EQ(c.currents->triangles_a, 2U);
  const double apart_b = kernel({1.0 / 3, 2.0 / 3}, {2.0 / 3, 4.0 / 3});
  EXPECT_NEAR(c.currents->sums.norm_b2, 2 + 2 * apart_b, 1e-6);
  // With the diagonal from (0, 0): below it the triangle (0, 0), (1, 0), (1, 1); with the other one the mirror image.
  const Point2 small{2.0 / 3, 1.0 / 3}, large{(1 - 1.0 / 3) / 1.5, (2 - 1.0 / 6) / 1.5};
  const double apart_a = kernel(small, large);
  EXPECT_NEAR(c.currents->sums.norm_a2, 0.25 + 2.25 + 2 * 0.5 * 1.5 * apart_a, 1e-6);
}

TEST(Currents, TheSameBitsForAnyThreadsAndOrderAndTheOtherWayRound) {
  const Cloud a = plane(uniform(300, 1), 0), b = plane(uniform(200, 2), 0.01);
  CompareOptions options;
  options.measure = MeasureKind::currents;
  const Comparison one = compare(a, b, options, {});
  Context three;
  three.threads = 3;
  for (const Comparison& c : {compare(a, b, options, three), compare(shuffled(a, 3), shuffled(b, 4), options, {})}) {
    EXPECT_EQ(c.currents->sums.rho, one.currents->sums.rho);
    EXPECT_EQ(c.currents->sums.inner, one.currents->sums.inner);
  }
  const Comparison turned = compare(b, a, options, {});
  EXPECT_EQ(turned.currents->triangles_a, one.currents->triangles_b);
  EXPECT_NEAR(turned.currents->sums.norm_a2, one.currents->sums.norm_b2, 1e-12 * one.currents->sums.norm_b2);
}

}  // namespace
}  // namespace isopach::test
