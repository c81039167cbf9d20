// Normals and boundary of clouds: against known surfaces, dense eigenvectors and degenerate input.
#include "isopach/match/pairs/oriented.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "isopach/distance/vectors.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

OrientedCloud oriented(const Cloud& cloud, double thin = 0) {
  OrientedCloud o = order_points(cloud, Pose{}, Frame{}, {}, thin, {});
  orient(o, {});
  return o;
}

TEST(Oriented, NormalsAreLeastSquaresOverTheNearest) {
  const Cloud cloud = test::rough_cloud(test::uniform(200, 1), 2);
  const OrientedCloud o = oriented(cloud);
  for (std::size_t i = 0; i < o.points.size(); ++i) {
    std::vector<std::pair<double, Index>> near;
    for (std::size_t k = 0; k < o.points.size(); ++k)
      near.emplace_back(squared_length(o.points[k] - o.points[i]), static_cast<Index>(k));
    std::sort(near.begin(), near.end());
    Eigen::JacobiSVD<Eigen::MatrixXd> svd;
    for (std::size_t count = normal_neighbours; count <= 8 * normal_neighbours; count *= 2) {
      Eigen::MatrixXd d(3, count);
      for (std::size_t k = 0; k < count; ++k) {
        const Point3& p = o.points[near[k].second];
        d.col(static_cast<Eigen::Index>(k)) << p.x, p.y, p.z;
      }
      d.colwise() -= d.rowwise().mean().eval();
      svd.compute(d, Eigen::ComputeFullU);
      if (std::pow(svd.singularValues()(1) / svd.singularValues()(0), 2) > 0.1) break;
    }
    const Eigen::Vector3d n = svd.matrixU().col(2);
    if (svd.singularValues()(1) - svd.singularValues()(2) < 0.05) continue;  // no plane stands out
    EXPECT_NEAR(std::fabs(dot(o.normals[i], {n(0), n(1), n(2)})), 1, 1e-9);
  }
}

TEST(Oriented, RingsOfAScannerHaveNormals) {
  test::Random random(1);
  Cloud rings;  // on a slope, four to thirty times denser along than across: the next ring is farther than the last
  for (int ring = 0; ring < 20; ++ring)
    for (int i = 0; i < 400; ++i) {
      const double y = 0.35 * std::pow(1.12, ring);
      rings.points.push_back({0.01 * i, y, 0.5 * y + 0.0005 * random.uniform(-1, 1)});
    }
  const OrientedCloud o = oriented(rings);
  std::size_t inside = 0, open = 0;
  for (std::size_t i = 0; i < o.points.size(); ++i) {
    EXPECT_GT(std::fabs(dot(o.normals[i], {0, -0.44721, 0.89443})), 0.999);
    const Point3& p = o.points[i];
    if (p.x < 0.4 || p.x > 3.6 || p.y < 0.5 || p.y > 2) continue;
    ++inside, open += o.boundary[i] != 0 ? 1u : 0u;
  }
  EXPECT_GT(inside, 2500u);
  EXPECT_EQ(open, 0u) << "what is open to the next ring is no boundary";
}

// A point of a part four times as dense stands for a quarter of the area.
TEST(Oriented, AreasAreThoseOfTheSurface) {
  Cloud cloud;
  for (const Point2& p : test::uniform(2000, 1)) cloud.points.push_back({p.x, p.y, 0});
  for (const Point2& p : test::uniform(8000, 2)) cloud.points.push_back({p.x + 1, p.y, 0});
  const OrientedCloud o = oriented(cloud);
  double sparse = 0, all = 0;
  for (std::size_t i = 0; i < o.points.size(); ++i) {
    all += o.areas[i];
    if (o.points[i].x < 1) sparse += o.areas[i];
  }
  EXPECT_NEAR(all, 10000, 1e-6);
  EXPECT_NEAR(sparse / all, 0.5, 0.02);
}

TEST(Oriented, BoundaryOfASquare) {
  const OrientedCloud o =
      oriented(test::cloud_over(test::framed_square(3000, 1), [](const Point2& p) { return 0.3 * p.x; }));
  std::size_t inside = 0, missed = 0;
  for (std::size_t i = 0; i < o.points.size(); ++i) {
    const double rim = std::min({o.points[i].x, 1 - o.points[i].x, o.points[i].y, 1 - o.points[i].y});
    inside += rim > 0.05 && o.boundary[i] != 0 ? 1u : 0u;
    missed += rim == 0 && o.boundary[i] == 0 ? 1u : 0u;
  }
  EXPECT_LT(inside, 30u);
  EXPECT_EQ(missed, 0u);
}

TEST(Oriented, FewPointsLinesAndCopies) {
  Cloud line, copies, few;
  for (int i = 0; i < 50; ++i) line.points.push_back({0.1 * i, 0.2 * i, 0}), copies.points.push_back({1, 2, 3});
  few.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const Cloud* cloud : {&line, &copies, &few}) {
    const OrientedCloud o = oriented(*cloud);
    for (std::size_t i = 0; i < o.points.size(); ++i) {
      EXPECT_EQ(length(o.normals[i]), 0);
      EXPECT_EQ(o.boundary[i], 1);
    }
  }
}

TEST(Oriented, OnePointACube) {
  const Cloud cloud = test::rough_cloud(test::uniform(5000, 1), 2);
  const OrientedCloud o = order_points(cloud, Pose{}, Frame{}, {}, 0.5, {});
  EXPECT_GE(o.points.size(), 16u);
  EXPECT_LE(o.points.size(), 3u * 3u * 5u);
  const OrientedCloud other = order_points(test::shuffled(cloud, 7), Pose{}, Frame{}, {}, 0.5, {});
  ASSERT_EQ(other.points.size(), o.points.size());
  for (std::size_t i = 0; i < o.points.size(); ++i) EXPECT_EQ(length(o.points[i] - other.points[i]), 0);
}

}  // namespace
}  // namespace isopach
