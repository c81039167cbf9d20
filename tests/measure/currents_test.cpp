// Currents by cubes and grids against the double sum over all pairs, on surfaces of every kind.
#include "isopach/measure/currents/currents.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/measure/currents/currents_kernel.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

struct Surface {
  std::vector<Point3> centroids, normals;
  [[nodiscard]] Current view() const { return {centroids, normals}; }
  void add(const Point3& c, const Point3& n) { centroids.push_back(c), normals.push_back(n); }
};

/// Mean distance of neighbours 1. Kinds: waves, flat, grid, duplicates, clustered, outlier, steep.
Surface make(const std::string& kind, int n, std::uint64_t seed) {
  Random random(seed);
  Surface s;
  const double side = std::sqrt(n);
  for (int i = 0; i < n; ++i) {
    double x = random.uniform(0, side), y = random.uniform(0, side);
    if (kind == "grid") x = i % static_cast<int>(side), y = i / static_cast<int>(side);
    if (kind == "duplicates") x = std::floor(x / 8) * 8, y = std::floor(y / 8) * 8;
    if (kind == "clustered" && i % 2 == 0) x = 3 + x / side / 50, y = 5 + y / side / 50;
    double z =
        kind == "flat" || kind == "grid" ? 0.1 * static_cast<double>(seed) : 2 * std::sin(x / 7) * std::cos(y / 5);
    if (kind == "steep") z = 8 * std::sin(x) + random.uniform(-8, 8);
    if (kind == "outlier" && i == 0) x = 1e6, y = -1e6, z = 1e5;
    s.add({x, y, z}, {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(0.2, 1)});
  }
  return s;
}

double plain_sum(const Surface& a, const Surface& b, double sigma) {
  long double total = 0;
  for (std::size_t i = 0; i < a.centroids.size(); ++i)
    for (std::size_t j = 0; j < b.centroids.size(); ++j) {
      const Point3 &p = a.centroids[i], &q = b.centroids[j], &m = a.normals[i], &n = b.normals[j];
      const double dx = (p.x - q.x) / sigma, dy = (p.y - q.y) / sigma, dz = (p.z - q.z) / sigma;
      total += (m.x * n.x + m.y * n.y + m.z * n.z) * std::exp(-(dx * dx + dy * dy + dz * dz));
    }
  return static_cast<double>(total);
}

TEST(CurrentsKernel, EqualsTheExponential) {
  Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const double y = random.uniform(0, i % 2 == 0 ? 2 : 690);
    ASSERT_NEAR(exp_minus(y), std::exp(-y), 1e-13 * std::exp(-y)) << y;
  }
  EXPECT_EQ(exp_minus(0), 1);
  EXPECT_LT(exp_minus(1e300), 1e-300);
}

TEST(Currents, DirectEqualsThePlainDoubleSum) {
  const Surface a = make("waves", 700, 1), b = make("waves", 900, 2);
  for (const double sigma : {0.5, 5.0, 100.0}) {
    const Currents c = currents(a.view(), b.view(), {sigma, 1e-6, CurrentsMethod::direct}, {});
    const double aa = plain_sum(a, a, sigma), bb = plain_sum(b, b, sigma), ab = plain_sum(a, b, sigma);
    EXPECT_NEAR(c.norm_a2, aa, 1e-12 * aa);
    EXPECT_NEAR(c.norm_b2, bb, 1e-12 * bb);
    EXPECT_NEAR(c.inner, ab, 1e-12 * std::sqrt(aa * bb));
    EXPECT_NEAR(c.rho, aa + bb - 2 * ab, 1e-12 * (aa + bb));
  }
}

TEST(Currents, AreWithinTheErrorAskedForAndWithinTheirBound) {
  for (const char* kind : {"waves", "flat", "grid", "duplicates", "clustered", "outlier", "steep"})
    for (const double sigma : {0.5, 2.0, 5.0, 20.0, 100.0}) {
      const Surface a = make(kind, 900, 1), b = make(kind, 625, 2);
      const Currents exact = currents(a.view(), b.view(), {sigma, 1e-6, CurrentsMethod::direct}, {});
      for (const double error : {1e-3, 1e-6, 1e-9}) {
        const Currents c = currents(a.view(), b.view(), {sigma, error}, {});
        SCOPED_TRACE(std::string(kind) + " " + std::to_string(sigma) + " " + std::to_string(error));
        EXPECT_TRUE(c.reached);
        EXPECT_LE(c.norm_a2_bound, error * c.norm_a2);
        EXPECT_LE(std::fabs(c.norm_a2 - exact.norm_a2), c.norm_a2_bound + exact.norm_a2_bound);
        EXPECT_LE(std::fabs(c.norm_b2 - exact.norm_b2), c.norm_b2_bound + exact.norm_b2_bound);
        EXPECT_LE(std::fabs(c.inner - exact.inner), c.inner_bound + exact.inner_bound);
        EXPECT_LE(std::fabs(c.rho - exact.rho), c.error_bound + exact.error_bound);
        EXPECT_LE(c.inner_bound, error * std::sqrt(c.norm_a2 * c.norm_b2));
      }
    }
}

TEST(Currents, HaveTheSameBitsForAnyThreadsAndForSwappedScans) {
  const Surface a = make("waves", 3000, 1), b = make("steep", 2000, 2);
  for (const double sigma : {1.0, 20.0}) {
    Currents one, four, swapped;
    run_with_threads(1, [&] { one = currents(a.view(), b.view(), {sigma}, {}); });
    run_with_threads(4, [&] { four = currents(a.view(), b.view(), {sigma}, {}); });
    run_with_threads(4, [&] { swapped = currents(b.view(), a.view(), {sigma}, {}); });
    EXPECT_EQ(one.rho, four.rho);
    EXPECT_EQ(one.inner, four.inner);
    EXPECT_EQ(one.norm_a2, four.norm_a2);
    EXPECT_NEAR(swapped.rho, one.rho, 1e-12 * one.norm_a2);
    EXPECT_NEAR(swapped.norm_b2, one.norm_a2, 1e-12 * one.norm_a2);
  }
}

TEST(Currents, OfEqualSurfacesDifferByRoundingAlone) {
  const Surface a = make("waves", 3000, 1);
  for (const double sigma : {0.5, 5.0, 50.0}) {
    const Currents c = currents(a.view(), a.view(), {sigma}, {});
    EXPECT_NEAR(c.rho, 0, 1e-13 * c.norm_a2);
    EXPECT_NEAR(c.inner, c.norm_a2, 1e-12 * c.norm_a2);
  }
}

TEST(Currents, OfNothingAreZero) {
  const Surface a = make("waves", 100, 1), none;
  const Currents c = currents(a.view(), none.view(), {5.0}, {});
  EXPECT_TRUE(c.reached);
  EXPECT_EQ(c.norm_b2, 0);
  EXPECT_EQ(c.inner, 0);
  EXPECT_EQ(c.rho, c.norm_a2);
  EXPECT_EQ(currents(none.view(), none.view(), {5.0}, {}).rho, 0);
}

TEST(Currents, SayWhenNormalsCancelTooFar) {
  Surface a = make("waves", 500, 1);
  const std::size_t n = a.centroids.size();
  for (std::size_t i = 0; i < n; ++i) a.add(a.centroids[i], {-a.normals[i].x, -a.normals[i].y, -a.normals[i].z});
  EXPECT_FALSE(currents(a.view(), a.view(), {5.0}, {}).reached);
}

TEST(Currents, RefuseWidthsAndErrorsThatAreNone) {
  const Surface a = make("waves", 10, 1);
  for (const double sigma : {0.0, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_THROW((void)currents(a.view(), a.view(), {sigma}, {}), UsageError);
  for (const double error : {0.0, 1e-13, 1.0, std::nan("")})
    EXPECT_THROW((void)currents(a.view(), a.view(), {1.0, error}, {}), UsageError);
}

}  // namespace
}  // namespace isopach::test
