// The Gaussian filter against the sum over all pairs, and against what ISO 16610-61 says of sine waves.
#include "isopach/measure/texture/gaussian_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/measure/gaussian_sums.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

constexpr double turn = 2 * std::numbers::pi;

struct Nodes {
  Array<Point2> xy;
  Array<double> area, z;
};

Nodes random_nodes(std::size_t n, std::uint64_t seed, double side, double shift = 0) {
  test::Random random(seed);
  Nodes out;
  for (std::size_t i = 0; i < n; ++i) {
    out.xy.push_back({shift + random.uniform(0, side), shift + random.uniform(0, side)});
    out.area.push_back(random.uniform(0.2, 2));
    out.z.push_back(random.uniform(-1, 1));
  }
  return out;
}

/// By the definition: all pairs, the plane by a general least-squares solver.
double by_definition(const Nodes& n, std::size_t i, double cutoff, unsigned degree) {
  const double alpha = std::sqrt(std::numbers::ln2 / std::numbers::pi);
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t j = 0; j < n.xy.size(); ++j) {
    if (!(n.area[j] > 0)) continue;
    const double dx = (n.xy[j].x - n.xy[i].x) / cutoff, dy = (n.xy[j].y - n.xy[i].y) / cutoff;
    const double w = n.area[j] * std::exp(-std::numbers::pi * (dx * dx + dy * dy) / (alpha * alpha));
    const Eigen::Vector3d row(1, dx, dy);
    gram += w * row * row.transpose();
    right += w * n.z[j] * row;
  }
  if (degree == 0) return right(0) / gram(0, 0);
  return gram.colPivHouseholderQr().solve(right)(0);
}

void expect_definition(const Nodes& n, double cutoff, const std::string& what) {
  for (const unsigned degree : {0u, 1u}) {
    const Array<double> mean = gaussian_mean(n.xy, n.area, n.z, {cutoff, degree}, {});
    for (std::size_t i = 0; i < n.xy.size(); i += 1 + n.xy.size() / 300) {
      if (!(n.area[i] > 0))
        EXPECT_TRUE(std::isnan(mean[i])) << what;
      else
        EXPECT_NEAR(mean[i], by_definition(n, i, cutoff, degree), 1e-8)
            << what << " degree " << degree << " node " << i;
    }
  }
}

TEST(GaussianFilter, IsTheSumOverAllPairs) {
  // From kernels of a few points to kernels wider than the scan: both ways of summing.
  for (const double cutoff : {0.06, 0.1, 0.2, 0.4, 1.5})
    expect_definition(random_nodes(3000, 7, 1), cutoff, "random, cut-off " + std::to_string(cutoff));
  expect_definition(random_nodes(3000, 8, 1, 1e6), 0.3, "far away");
  Nodes grid = random_nodes(2500, 9, 1);
  for (std::size_t i = 0; i < grid.xy.size(); ++i)
    grid.xy[i] = {static_cast<double>(i % 50) / 50, static_cast<double>(i / 50) / 50};
  expect_definition(grid, 0.25, "grid");
  Nodes holes = random_nodes(2500, 10, 1);
  for (std::size_t i = 0; i < holes.xy.size(); i += 3) holes.area[i] = 0;
  expect_definition(holes, 0.25, "nodes without area");
  Nodes dense = random_nodes(3000, 11, 1);  // ever denser towards a corner, areas to match
  for (std::size_t i = 0; i < dense.xy.size(); ++i) {
    const double s = dense.xy[i].x * dense.xy[i].x;
    dense.area[i] *= 0.001 + s;
    dense.xy[i] = {dense.xy[i].x * s, dense.xy[i].y * s};
  }
  expect_definition(dense, 0.2, "graded");
}

TEST(GaussianFilter, BothWaysOfSummingAgree) {
  const Nodes n = random_nodes(4000, 3, 1);
  const double width = 0.06;
  const GaussianBoxes boxes(n.xy, n.area, width);
  Array<double> weight(n.z.size()), weighted(n.z.size());
  for (std::size_t i = 0; i < n.z.size(); ++i)
    weight[i] = n.area[i] / (width * width) / 4000, weighted[i] = weight[i] * n.z[i];
  for (const unsigned degree : {0u, 1u}) {
    const auto pairs = gaussian_moments(boxes, weight, weighted, degree, GaussianMethod::direct, {});
    const auto sums = gaussian_moments(boxes, weight, weighted, degree, GaussianMethod::boxes, {});
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      EXPECT_NEAR(pairs[k].a00, sums[k].a00, 1e-8);
      EXPECT_NEAR(pairs[k].z00, sums[k].z00, 1e-8);
      if (degree == 0) continue;
      EXPECT_NEAR(pairs[k].a10, sums[k].a10, 1e-8);
      EXPECT_NEAR(pairs[k].a01, sums[k].a01, 1e-8);
      EXPECT_NEAR(pairs[k].a20, sums[k].a20, 1e-8);
      EXPECT_NEAR(pairs[k].a11, sums[k].a11, 1e-8);
      EXPECT_NEAR(pairs[k].a02, sums[k].a02, 1e-8);
      EXPECT_NEAR(pairs[k].z10, sums[k].z10, 1e-8);
      EXPECT_NEAR(pairs[k].z01, sums[k].z01, 1e-8);
    }
  }
}

TEST(GaussianFilter, PassesSineWavesAsTheStandardSays) {
  EXPECT_DOUBLE_EQ(gaussian_transmission(0.8, 0.8), 0.5);
  // A jittered grid: areas are even enough, places are not.
  test::Random random(5);
  Nodes n;
  constexpr int side = 120;
  for (int i = 0; i < side * side; ++i) {
    n.xy.push_back({(i % side + random.uniform(-0.2, 0.2)) / side, (i / side + random.uniform(-0.2, 0.2)) / side});
    n.area.push_back(1);
    n.z.push_back(0);
  }
  for (const double wavelength : {0.1, 0.15, 0.2, 0.3}) {
    for (std::size_t i = 0; i < n.z.size(); ++i)
      n.z[i] = std::sin(turn * (0.6 * n.xy[i].x + 0.8 * n.xy[i].y) / wavelength);
    const Array<double> mean = gaussian_mean(n.xy, n.area, n.z, {0.15, 1}, {});
    double product = 0, square = 0;
    for (std::size_t i = 0; i < n.z.size(); ++i) {
      const Point2& p = n.xy[i];
      if (std::min(p.x, p.y) < 0.15 || std::max(p.x, p.y) > 0.85) continue;
      product += mean[i] * n.z[i], square += n.z[i] * n.z[i];
    }
    EXPECT_NEAR(product / square, gaussian_transmission(0.15, wavelength), 0.003) << wavelength;
  }
}

TEST(GaussianFilter, KeepsPlanesUpToTheRim) {
  Nodes n = random_nodes(3000, 4, 10);
  for (std::size_t i = 0; i < n.z.size(); ++i) n.z[i] = 5 + 2 * n.xy[i].x - 3 * n.xy[i].y;
  for (const double cutoff : {0.8, 6.0}) {
    const Array<double> mean = gaussian_mean(n.xy, n.area, n.z, {cutoff, 1}, {});
    double worst = 0, plain = 0;
    const Array<double> normalised = gaussian_mean(n.xy, n.area, n.z, {cutoff, 0}, {});
    for (std::size_t i = 0; i < n.z.size(); ++i) {
      worst = std::max(worst, std::fabs(mean[i] - n.z[i]));
      plain = std::max(plain, std::fabs(normalised[i] - n.z[i]));
    }
    EXPECT_LT(worst, 1e-6) << cutoff;
    EXPECT_GT(plain, 0.05) << cutoff;  // what degree 0 does there
  }
}

TEST(GaussianFilter, RobustMeanIsNotDrawnByValleys) {
  Nodes n = random_nodes(6000, 6, 10);
  Array<double> level(n.z.size());
  for (std::size_t i = 0; i < n.z.size(); ++i) {
    level[i] = 0.3 * std::sin(turn * n.xy[i].x / 20);
    n.z[i] = level[i] + 0.01 * n.z[i];
    if (std::fabs(n.xy[i].y - 5) < 0.3) n.z[i] -= 1;  // a groove
  }
  const Array<double> plain = gaussian_mean(n.xy, n.area, n.z, {3, 1}, {});
  const Array<double> robust = robust_gaussian_mean(n.xy, n.area, n.z, {3, 1}, {});
  double drawn = 0, error = 0;
  for (std::size_t i = 0; i < n.z.size(); ++i) {
    if (std::fabs(n.xy[i].y - 5) > 0.3) continue;
    drawn = std::max(drawn, std::fabs(plain[i] - level[i]));
    error = std::max(error, std::fabs(robust[i] - level[i]));
  }
  EXPECT_GT(drawn, 0.3);
  EXPECT_LT(error, 0.03);
}

/// The definition of the robust filter with sums over all pairs.
TEST(GaussianFilter, RobustMeanIsItsDefinition) {
  Nodes n = random_nodes(500, 12, 1);
  for (std::size_t i = 0; i < n.z.size(); i += 17) n.z[i] -= 20;
  Nodes weighted = n;
  Array<double> mean(n.z.size());
  double before = 1e300;
  for (int pass = 0; pass < 10; ++pass) {
    std::vector<double> sizes;
    for (std::size_t i = 0; i < n.z.size(); ++i) {
      mean[i] = by_definition(weighted, i, 0.4, 1);
      sizes.push_back(std::fabs(n.z[i] - mean[i]));
    }
    std::vector<double> sorted = sizes;
    std::sort(sorted.begin(), sorted.end());
    const double c = 4.4478 * sorted[sorted.size() / 2];
    if (std::fabs(before - c) < 1e-3 * c) break;
    before = c;
    for (std::size_t i = 0; i < n.z.size(); ++i) {
      const double t = sizes[i] / c;
      weighted.area[i] = t < 1 ? n.area[i] * (1 - t * t) * (1 - t * t) : 0;
    }
  }
  const Array<double> robust = robust_gaussian_mean(n.xy, n.area, n.z, {0.4, 1}, {});
  for (std::size_t i = 0; i < n.z.size(); ++i) EXPECT_NEAR(robust[i], mean[i], 1e-6) << i;
}

TEST(GaussianFilter, OnALineOrAloneIsTheWeightedMean) {
  Nodes line = random_nodes(200, 13, 1);
  for (Point2& p : line.xy) p = {p.x, 2 * p.x};
  const Array<double> mean = gaussian_mean(line.xy, line.area, line.z, {0.3, 1}, {});
  for (std::size_t i = 0; i < line.z.size(); ++i) EXPECT_NEAR(mean[i], by_definition(line, i, 0.3, 0), 1e-8);
  const Nodes one = random_nodes(1, 14, 1);
  EXPECT_NEAR(gaussian_mean(one.xy, one.area, one.z, {1, 1}, {})[0], one.z[0], 1e-12);
  EXPECT_TRUE(gaussian_mean({}, {}, {}, {1, 1}, {}).empty());
}

TEST(GaussianFilter, SameBitsForAnyNumberOfThreads) {
  const Nodes n = random_nodes(5000, 15, 1);
  for (const double cutoff : {0.04, 0.5}) {
    Array<double> first;
    for (const int threads : {1, 2, 5}) {
      Array<double> mean;
      run_with_threads(threads, [&] { mean = robust_gaussian_mean(n.xy, n.area, n.z, {cutoff, 1}, {}); });
      if (first.empty()) first = mean;
      EXPECT_EQ(first, mean);
    }
  }
}

TEST(GaussianFilter, RefusesCutOffsThatAreNone) {
  const Nodes n = random_nodes(10, 16, 1);
  for (const double cutoff : {0.0, -1.0, std::nan(""), 1e-12})
    EXPECT_THROW((void)gaussian_mean(n.xy, n.area, n.z, {cutoff, 1}, {}), UsageError) << cutoff;
}

}  // namespace
}  // namespace isopach
