// Metro's figures of coarse surfaces against closed forms.
#include "isopach/distance/surface_figures.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/random.hpp"
#include "isopach/distance/distance.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

/// A strip [0, 3] x [0, 1] of two triangles at the heights z(x), x = 0 and 3 alone.
Mesh strip(double left, double right) {
  Mesh m;
  m.points = {{0, 0, left}, {3, 0, right}, {3, 1, right}, {0, 1, left}};
  m.faces = {{0, 1, 2}, {0, 2, 3}};
  return m;
}
/// The plane z = 0, far wider.
Mesh floor_plane() {
  Mesh m;
  m.points = {{-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}};
  m.faces = {{0, 1, 2}, {0, 2, 3}};
  return m;
}

/// Of |z| where z is linear from a < 0 to b > 0: the mean, and the root of the mean square.
double mean_of(double a, double b) { return (a * a + b * b) / (2 * (b - a)); }
double rms_of(double a, double b) { return std::sqrt((b * b * b - a * a * a) / (3 * (b - a))); }

// Two planes that cross: the distance is a ridge roof, of which values on a pattern are low on average.
TEST(SurfaceFigures, PlanesThatCrossOnCoarseMeshes) {
  const Mesh other = floor_plane();
  const SurfaceTree tree(other);
  for (const double left : {-1.0, -0.6, -0.35, -0.2}) {
    const double right = left + 1.2;
    const SurfaceFigures f = surface_figures(strip(left, right), tree, {}, {});
    const double mean = mean_of(left, right), rms = rms_of(left, right);
    EXPECT_LE(f.mean_error, 1e-3 * f.mean);
    EXPECT_LE(f.rms_error, 1e-3 * f.rms);
    EXPECT_NEAR(f.mean, mean, 3e-3 * mean) << left;
    EXPECT_NEAR(f.rms, rms, 3e-3 * rms) << left;
    EXPECT_LE(f.samples, 100000U);
  }
}

// The standard errors are those of the figures: over many strips error / standard error has a variance of 1.
TEST(SurfaceFigures, ErrorsAreAsLargeAsTold) {
  const Mesh other = floor_plane();
  const SurfaceTree tree(other);
  const RandomStream random(3, 1);
  SurfaceSampling sampling;
  sampling.error = 1;  // whatever it is: the first pass
  double mean_pulls = 0, rms_pulls = 0, bias = 0;
  sampling.least = 4000;
  constexpr int strips = 400;
  for (std::uint64_t i = 0; i < strips; ++i) {
    const double left = -0.2 - 0.8 * random.uniform(2 * i), right = 0.2 + 0.8 * random.uniform(2 * i + 1);
    const SurfaceFigures f = surface_figures(strip(left, right), tree, sampling, {});
    // Parts lie along the ridge: where it cuts a sliver off them that no sample met, the error is told as 0.
    if (f.mean_error < 1e-9 * f.mean) {
      EXPECT_NEAR(f.mean, mean_of(left, right), 1e-3 * f.mean);
      continue;
    }
    const double pull = (f.mean - mean_of(left, right)) / f.mean_error;
    mean_pulls += pull * pull / strips, bias += (f.mean / mean_of(left, right) - 1) / strips;
    rms_pulls += std::pow((f.rms - rms_of(left, right)) / f.rms_error, 2) / strips;
  }
  EXPECT_GT(mean_pulls, 0.6);
  EXPECT_LT(mean_pulls, 2.5);  // two or three sets cross the ridge: few degrees of freedom
  EXPECT_GT(rms_pulls, 0.6);
  EXPECT_LT(rms_pulls, 2.5);
  EXPECT_LT(std::fabs(bias), 5e-4);
}

// A box around a smaller one: over its faces 0.25, farther at edges and corners of the outer one.
TEST(SurfaceFigures, OfABoxToOneInIt) {
  const auto box = [](double half) {
    Mesh m;
    for (int i = 0; i < 8; ++i)
      m.points.push_back({(i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half, (i & 4) != 0 ? half : -half});
    m.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
               {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return m;
  };
  const Mesh inner = box(1), outer = box(1.25);
  const SurfaceTree tree(inner);
  const SurfaceFigures f = surface_figures(outer, tree, {}, {});
  // By quarter of a face: square of side 1 at 0.25, two strips of 1 x 0.25 at sqrt(0.25² + t²), a square of side 0.25.
  constexpr int n = 1000;
  double strip_mean = 0, corner_mean = 0;
  for (int i = 0; i < n; ++i) {
    const double s = 0.25 * (i + 0.5) / n;
    strip_mean += std::hypot(0.25, s) / n;
    for (int j = 0; j < n; ++j) corner_mean += std::hypot(0.25, s, 0.25 * (j + 0.5) / n) / (double(n) * n);
  }
  const double mean = (0.25 + 2 * 0.25 * strip_mean + 0.0625 * corner_mean) / 1.5625;
  EXPECT_DOUBLE_EQ(f.area, 6 * 6.25);
  EXPECT_LE(f.mean_error, 1e-3 * f.mean);
  EXPECT_NEAR(f.mean, mean, 4 * f.mean_error + 1e-6);
}

TEST(SurfaceFigures, StopsWhereTheSurfacesAreTheSameOrTheSamplesUsedUp) {
  const Mesh other = floor_plane();
  const SurfaceTree tree(other);
  SurfaceSampling rounded;
  rounded.rounding = 1e-12;
  const SurfaceFigures same = surface_figures(other, tree, rounded, {});
  EXPECT_LT(same.mean, 1e-12);
  EXPECT_LT(same.mean_error, 1e-12);
  EXPECT_LE(same.samples, 40000U);
  SurfaceSampling few;
  few.error = 1e-9, few.most = 2000;
  const SurfaceFigures f = surface_figures(strip(-1, 0.2), tree, few, {});
  EXPECT_LE(f.samples, 4000U);
  EXPECT_GT(f.mean_error, 1e-9 * f.mean);  // and says so
}

// The same through the verb: default samples on a coarse pair.
TEST(Distance, MetrosMeanOfCoarseMeshesIsAsExactAsItSays) {
  Cloud a, b;
  a.points = {{0, 0, -0.35}, {3, 0, 0.85}, {3, 1, 0.85}, {0, 1, -0.35}};
  b.points = {{-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}};
  DistanceOptions options;
  options.measures.surface = true;
  options.border = BorderRule::hull;
  const SurfaceFigures f = distance(a, b, std::nullopt, options, {}).surface->a_to_b;
  EXPECT_NEAR(f.mean, mean_of(-0.35, 0.85), 3e-3 * mean_of(-0.35, 0.85));
}

}  // namespace
}  // namespace isopach::test
