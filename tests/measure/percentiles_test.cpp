// Percentiles by area against 10⁷ random points of the domain, and against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "isopach/base/error.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/measure/measures.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

struct Pair {
  SortedTriangulation mesh;
  std::vector<double> z1, z2;
  std::vector<unsigned char> in_domain;

  [[nodiscard]] CellView view() const { return {mesh.triangulation, mesh.xy, z1, z2, in_domain}; }
};

Pair over(const Points& xy, const std::function<double(const Point2&)>& d) {
  Pair p{triangulate_unsorted(xy, {}), {}, {}, {}};
  for (const Point2& q : p.mesh.xy) p.z1.push_back(0), p.z2.push_back(d(q));
  p.in_domain.assign(p.mesh.triangulation.real, 1);
  return p;
}

// (2k + 1)² nodes over [−1, 1]².
Points lattice(int k) {
  Points xy;
  for (int i = -k; i <= k; ++i)
    for (int j = -k; j <= k; ++j) xy.push_back({static_cast<double>(i) / k, static_cast<double>(j) / k});
  return xy;
}

TEST(Percentiles, AreWithinTheSamplingErrorOfTenMillionPoints) {
  Random random(491);
  const Pair p = over(uniform(500, 492), [&](const Point2& q) { return std::sin(7 * q.x) + 0.3 * random.bell(); });
  const std::vector<double> levels{97.5, 0.1, 99.99};
  const DifferenceStatistics d = measure(p.view(), {}, levels).difference;
  const CellView cells = p.view();
  std::vector<double> up_to;
  double area = 0;
  for (Index t = 0; t < cells.t.real; ++t) up_to.push_back(area += cell_at(cells, t).area);
  constexpr int n = 10'000'000;
  int below_median = 0, near_median = 0;
  std::array<int, 4> within{};
  std::array<int, 3> within_more{};
  for (int i = 0; i < n; ++i) {
    const auto found = std::upper_bound(up_to.begin(), up_to.end(), random.uniform() * area);
    const Cell cell =
        cell_at(cells, std::min<std::size_t>(static_cast<std::size_t>(found - up_to.begin()), up_to.size() - 1));
    double s = random.uniform(), t = random.uniform();
    if (s + t > 1) s = 1 - s, t = 1 - t;
    const double x = cell.d[0] + s * (cell.d[1] - cell.d[0]) + t * (cell.d[2] - cell.d[0]);
    below_median += x <= d.median ? 1 : 0;
    near_median += std::fabs(x - d.median) <= d.nmad / 1.4826 ? 1 : 0;
    for (std::size_t k = 0; k < 4; ++k) within[k] += std::fabs(x) <= d.abs_percentiles[k] ? 1 : 0;
    for (std::size_t k = 0; k < 3; ++k) within_more[k] += std::fabs(x) <= d.more_percentiles[k].value ? 1 : 0;
  }
  const auto expect_share = [&](int count, double share, const char* what) {
    EXPECT_NEAR(count / static_cast<double>(n), share, 4 * std::sqrt(share * (1 - share) / n)) << what;
  };
  expect_share(below_median, 0.5, "median");
  expect_share(near_median, 0.5, "nmad");
  for (std::size_t k = 0; k < 4; ++k) expect_share(within[k], percentile_levels[k] / 100.0, "percentile");
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(d.more_percentiles[k].level, levels[k]);
    expect_share(within_more[k], levels[k] / 100, "percentile asked for");
  }
}

TEST(Percentiles, OfAnyLevelAreExactAndLevelsThatAreNoneRefused) {
  // d = x + y over the square: see the next test.
  const Pair p = over(lattice(5), [](const Point2& q) { return q.x + q.y; });
  std::vector<double> levels;
  for (double level = 0.5; level < 100; level += 0.5) levels.push_back(level);
  const DifferenceStatistics d = measure(p.view(), {}, levels).difference;
  for (std::size_t i = 0; i < levels.size(); ++i)
    EXPECT_NEAR(d.more_percentiles[i].value, 2 - 2 * std::sqrt(1 - levels[i] / 100), 1e-13) << levels[i];
  for (const double level : {0.0, 100.0, -5.0, 101.0, std::nan("")})
    EXPECT_THROW((void)measure(p.view(), {}, std::vector<double>{level}), UsageError) << level;
}

TEST(Percentiles, OfATiltedPlaneAreThoseOfTwoUniformVariables) {
  // d = x + y over the square [−1, 1]²: half of it lies below 0, and |d| ≤ v on all but two corners of side 2 − v.
  const DifferenceStatistics d =
      measure(over(lattice(7), [](const Point2& q) { return q.x + q.y; }).view(), {}).difference;
  EXPECT_NEAR(d.median, 0, 1e-13);
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(d.abs_percentiles[k], 2 - 2 * std::sqrt(1 - percentile_levels[k] / 100.0), 1e-13);
  EXPECT_NEAR(d.nmad, 1.4826 * (2 - std::numbers::sqrt2), 1e-12);
}

TEST(Percentiles, OfAPyramidAreThoseOfItsClosedForm) {
  // d = 1 − max(|x|, |y|) on [−1, 1]², linear on four triangles: d ≤ v on all but a square of side 2 (1 − v).
  const DifferenceStatistics d =
      measure(over({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {0, 0}}, [](const Point2& q) { return q.x == 0 ? 1.0 : 0.0; })
                  .view(),
              {})
          .difference;
  EXPECT_NEAR(d.median, 1 - std::sqrt(0.5), 1e-14);
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(d.abs_percentiles[k], 1 - std::sqrt(1 - percentile_levels[k] / 100.0), 1e-14);
}

// Where the disc of radius r has `area` in common with [−1, 1]².
double radius_with_area(double area) {
  double low = 0, high = std::numbers::sqrt2;
  for (int i = 0; i < 100; ++i) {
    const double r = (low + high) / 2;
    const double cut = r <= 1 ? 0 : r * r * std::acos(1 / r) - std::sqrt(r * r - 1);  // of one cap
    (std::numbers::pi * r * r - 4 * cut < area ? low : high) = r;
  }
  return low;
}

TEST(Percentiles, OfAParaboloidAndAConeConvergeFromAbove) {
  // Both are convex: the surface through nodes on them lies above, by at most side²/8 times the largest second
  // derivative, where side is the longest of a cell. So does every percentile.
  for (const int k : {20, 80}) {
    const double h = 1.0 / k;
    const DifferenceStatistics bowl =
        measure(over(lattice(k), [](const Point2& q) { return q.x * q.x + q.y * q.y; }).view(), {}).difference;
    const DifferenceStatistics cone =
        measure(over(lattice(k), [](const Point2& q) { return std::hypot(q.x, q.y); }).view(), {}).difference;
    for (const auto& [share, in_bowl, in_cone] :
         {std::tuple{0.5, bowl.median, cone.median}, std::tuple{0.5, bowl.abs_percentiles[0], cone.abs_percentiles[0]},
          std::tuple{0.95, bowl.abs_percentiles[2], cone.abs_percentiles[2]}}) {
      const double r = radius_with_area(4 * share);
      EXPECT_GE(in_bowl, r * r - 1e-13);
      EXPECT_LE(in_bowl, r * r + h * h / 2 + 1e-13);
      EXPECT_GE(in_cone, r - 1e-13);
      EXPECT_LE(in_cone, r + h * h / 4 / (r - 2 * h));
    }
  }
}

}  // namespace
}  // namespace isopach::test
