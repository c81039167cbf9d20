// The gradient of the distance of two currents against finite differences and against the direct sum.
#include "isopach/measure/currents/currents_gradient.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

struct Surface {
  std::vector<Point3> centroids, normals;
  [[nodiscard]] Current view() const { return {centroids, normals}; }
};

/// Mean distance of neighbours 1, far from the origin by `far`.
Surface make(int n, std::uint64_t seed, double thickness, double far) {
  Random random(seed);
  Surface s;
  const double side = std::sqrt(n);
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform(0, side), y = random.uniform(0, side);
    const double z = 2 * std::sin(x / 7) * std::cos(y / 5) + random.uniform(-thickness, thickness);
    s.centroids.push_back({far + x, y - far, z});
    s.normals.push_back({random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(0.2, 1)});
  }
  return s;
}

/// Turned about an axis through the centre, or shifted along it.
Surface moved(const Surface& s, std::size_t parameter, double by, const Point3& centre) {
  Surface out = s;
  const std::size_t u = (parameter % 3 + 1) % 3, v = (parameter % 3 + 2) % 3;
  const auto component = [](Point3& p, std::size_t k) -> double& { return k == 0 ? p.x : k == 1 ? p.y : p.z; };
  const auto turn = [&](Point3& p) {
    const double a = component(p, u), b = component(p, v);
    component(p, u) = std::cos(by) * a - std::sin(by) * b;
    component(p, v) = std::sin(by) * a + std::cos(by) * b;
  };
  for (std::size_t i = 0; i < s.centroids.size(); ++i) {
    Point3& c = out.centroids[i];
    if (parameter >= 3) {
      component(c, parameter - 3) += by;
      continue;
    }
    c = {c.x - centre.x, c.y - centre.y, c.z - centre.z};
    turn(c), turn(out.normals[i]);
    c = {c.x + centre.x, c.y + centre.y, c.z + centre.z};
  }
  return out;
}

double entry(const CurrentsGradient& g, std::size_t parameter) {
  return parameter < 3 ? g.turn[parameter] : g.shift[parameter - 3];
}

struct Scale {
  double norms, length;  // ‖a‖ ‖b‖; of the scans
};
Scale scale_of(const Surface& a, const Surface& b, double sigma) {
  const Currents c = currents(a.view(), b.view(), {sigma}, {});
  return {std::sqrt(c.norm_a2 * c.norm_b2), std::sqrt(static_cast<double>(a.centroids.size()))};
}

TEST(CurrentsGradient, OfTheDirectSumEqualsFiniteDifferences) {
  const Surface a = make(300, 1, 0.5, 10), b = make(250, 2, 0.5, 10);
  const Point3 centre{12, -3, 1};
  for (const double sigma : {1.0, 5.0, 40.0}) {
    const CurrentsOptions direct{sigma, 1e-6, CurrentsMethod::direct};
    const CurrentsGradient g = currents_gradient(a.view(), b.view(), centre, direct, {});
    const Scale scale = scale_of(a, b, sigma);
    EXPECT_NEAR(g.inner, currents(a.view(), b.view(), direct, {}).inner, 1e-12 * scale.norms);
    for (std::size_t k = 0; k < 6; ++k) {
      const double h = 1e-4 * (k < 3 ? sigma / scale.length : sigma);
      const double plus = currents(moved(a, k, h, centre).view(), b.view(), direct, {}).rho,
                   minus = currents(moved(a, k, -h, centre).view(), b.view(), direct, {}).rho;
      EXPECT_NEAR(entry(g, k), (plus - minus) / (2 * h), 1e-7 * scale.norms * 1e-4 / h) << k << " " << sigma;
    }
  }
}

TEST(CurrentsGradient, ByCubesAndGridsEqualsTheDirectSum) {
  for (const double thickness : {0.0, 0.5, 6.0})
    for (const double far : {0.0, 1e6}) {
      const Surface a = make(900, 1, thickness, far), b = make(625, 2, thickness, far);
      const Point3 centre{far + 20, 20 - far, 0};
      for (const double sigma : {0.5, 2.0, 5.0, 20.0, 100.0}) {
        const CurrentsGradient exact =
            currents_gradient(a.view(), b.view(), centre, {sigma, 1e-6, CurrentsMethod::direct}, {});
        const Scale scale = scale_of(a, b, sigma);
        for (const double error : {1e-3, 1e-6, 1e-9}) {
          const CurrentsGradient g = currents_gradient(a.view(), b.view(), centre, {sigma, error}, {});
          SCOPED_TRACE(std::to_string(thickness) + " " + std::to_string(sigma) + " " + std::to_string(error));
          EXPECT_NEAR(g.inner, exact.inner, error * scale.norms);
          for (std::size_t k = 0; k < 6; ++k)
            EXPECT_NEAR(entry(g, k), entry(exact, k), error * scale.norms / sigma * (k < 3 ? scale.length + sigma : 1))
                << k;
        }
      }
    }
}

TEST(CurrentsGradient, IsZeroWhereASurfaceLiesOnItself) {
  const Surface a = make(3000, 1, 0.5, 0);
  const CurrentsGradient g = currents_gradient(a.view(), a.view(), {20, 20, 0}, {4.0, 1e-9}, {});
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(entry(g, k), 0, 1e-8 * g.inner) << k;
}

TEST(CurrentsGradient, ByCubeAddsUpAndItsOrderIsThatOfTheFirstCurrent) {
  const Surface a = make(2000, 1, 0.5, 0), b = make(1500, 2, 0.5, 0);
  const Point3 centre{20, 20, 0};
  const auto of_b = currents_gradient_by_cube(a.view(), b.view(), centre, {2.0}, {}),
             of_a = currents_gradient_by_cube(a.view(), a.view(), centre, {2.0}, {});
  const CurrentsGradient g = currents_gradient(a.view(), b.view(), centre, {2.0}, {});
  EXPECT_EQ(of_b.size(), of_a.size());
  EXPECT_GT(of_b.size(), 50U);
  double inner = 0, shift = 0, turn = 0;
  for (const CurrentsGradient& part : of_b) inner += part.inner, shift += part.shift[0], turn += part.turn[2];
  EXPECT_NEAR(inner, g.inner, 1e-12 * g.inner);
  EXPECT_NEAR(shift, g.shift[0], 1e-10 * g.inner);
  EXPECT_NEAR(turn, g.turn[2], 1e-9 * g.inner);
}

TEST(CurrentsGradient, HasTheSameBitsForAnyThreads) {
  const Surface a = make(3000, 1, 0.5, 0), b = make(2000, 2, 2, 0);
  CurrentsGradient one, four;
  run_with_threads(1, [&] { one = currents_gradient(a.view(), b.view(), {0, 0, 0}, {5.0}, {}); });
  run_with_threads(4, [&] { four = currents_gradient(a.view(), b.view(), {0, 0, 0}, {5.0}, {}); });
  EXPECT_EQ(one.inner, four.inner);
  EXPECT_EQ(one.turn, four.turn);
  EXPECT_EQ(one.shift, four.shift);
}

TEST(CurrentsGradient, OfNothingIsZeroAndOptionsAreChecked) {
  const Surface a = make(100, 1, 0.5, 0), none;
  const CurrentsGradient g = currents_gradient(a.view(), none.view(), {0, 0, 0}, {5.0}, {});
  EXPECT_EQ(g.inner, 0);
  EXPECT_EQ(g.shift, (std::array<double, 3>{}));
  EXPECT_THROW((void)currents_gradient(a.view(), a.view(), {0, 0, 0}, {0.0}, {}), UsageError);
}

}  // namespace
}  // namespace isopach::test
