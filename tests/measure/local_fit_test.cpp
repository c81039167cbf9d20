// Local fits against Eigen's QR over all nodes by distance, against cubics they must reproduce, and on known noise.
#include "isopach/measure/uncertainty/local_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <set>

#include "isopach/delaunay/triangulate.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

struct Scan {
  Points xy;
  Triangulation t;
  explicit Scan(const Points& points, double side = 1) {
    const CurveBox box{{0, 0}, std::ldexp(1.0, 32) / side};
    xy = in_order(points, box);
    t = triangulate(xy, box, {});
  }
  [[nodiscard]] LocalFits fit(const std::vector<double>& z) const {
    return local_fits(t, xy, z, std::vector<double>(xy.size(), 0.0), {});
  }
};

double cubic(double x, double y) { return 1 + 2 * x - y + 3 * x * x - x * y + y * y * 2 + x * x * x - 4 * x * y * y; }

TEST(LocalFits, ReproduceACubic) {
  const Scan scan(uniform(500, 1));
  std::vector<double> z;
  for (const Point2& p : scan.xy) z.push_back(cubic(p.x, p.y));
  const LocalFits fits = scan.fit(z);
  Random random(2);
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (std::max(std::fabs(scan.xy[i].x - 0.5), std::fabs(scan.xy[i].y - 0.5)) > 0.4) continue;  // a rim: fewer nodes
    EXPECT_NEAR(fits.residual[i], 0, 1e-10);
    const double dx = random.uniform(-0.05, 0.05), dy = random.uniform(-0.05, 0.05);
    EXPECT_NEAR(z[i] + LocalFits::value(fits.shape[i], dx, dy), cubic(scan.xy[i].x + dx, scan.xy[i].y + dy), 1e-8);
  }
}

// The rings by the set of triangles instead of by walking round nodes; the fit by QR; the residual from its influence.
TEST(LocalFits, EqualWeightedLeastSquaresByQR) {
  const Scan scan(uniform(300, 3));
  Random random(4);
  std::vector<double> z, noise;
  for (std::size_t i = 0; i < scan.xy.size(); ++i) z.push_back(random.bell()), noise.push_back(random.bell());
  const LocalFits fits = local_fits(scan.t, scan.xy, z, noise, {});
  std::vector<std::set<Index>> ring(z.size());
  for (Index i = 0; i < scan.t.real; ++i)
    for (const Index a : scan.t.triangles[i].v)
      for (const Index b : scan.t.triangles[i].v) ring[a].insert(b);
  int checked = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    std::set<Index> gathered;
    for (const Index k : ring[i]) gathered.insert(ring[k].begin(), ring[k].end());
    if (gathered.size() < 14) continue;  // a rim may take a lower degree
    std::vector<std::pair<double, Index>> near;
    for (const Index k : gathered)
      near.emplace_back(std::hypot(scan.xy[k].x - scan.xy[i].x, scan.xy[k].y - scan.xy[i].y), k);
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), LocalFits::most_neighbours + 1));
    const double radius = near.back().first;
    const auto rows = static_cast<Eigen::Index>(near.size());
    Eigen::MatrixXd m(rows, 10);
    Eigen::VectorXd height(rows), echo(rows), root(rows);
    for (Eigen::Index r = 0; r < rows; ++r) {
      const Index k = near[static_cast<std::size_t>(r)].second;
      const double x = (scan.xy[k].x - scan.xy[i].x) / radius, y = (scan.xy[k].y - scan.xy[i].y) / radius;
      root[r] = 1 - 0.8 * (x * x + y * y);
      m.row(r) << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
      m.row(r) *= root[r];
      height[r] = root[r] * z[k], echo[r] = root[r] * noise[k];
    }
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(m);
    const Eigen::MatrixXd influence = qr.solve(Eigen::MatrixXd(root.asDiagonal()));  // coefficients by heights
    const Eigen::RowVectorXd at_node = influence.row(0);
    if (1 - at_node[0] < 0.1) continue;
    double variance = (1 - at_node[0]) * (1 - at_node[0]);
    for (Eigen::Index r = 1; r < rows; ++r) variance += at_node[r] * at_node[r];
    const Eigen::VectorXd c = qr.solve(height), e = qr.solve(echo);
    EXPECT_NEAR(fits.residual[i], (z[i] - c[0]) / std::sqrt(variance), 1e-7);
    EXPECT_NEAR(fits.shape[i][0] * radius, c[1], 1e-6 * (1 + std::fabs(c[1])));
    EXPECT_NEAR(fits.shape[i][8] * radius * radius * radius, c[9], 1e-6 * (1 + std::fabs(c[9])));
    EXPECT_NEAR(fits.echo[i][3] * radius * radius, e[4], 1e-6 * (1 + std::fabs(e[4])));
    ++checked;
  }
  EXPECT_GT(checked, 200);
}

TEST(LocalFits, ResidualsOfNoiseHaveItsDeviation) {
  const Scan scan(uniform(10000, 5));
  Random random(6);
  std::vector<double> z;
  for (const Point2& p : scan.xy) z.push_back(cubic(p.x, p.y) + 0.3 * random.bell());
  const LocalFits fits = scan.fit(z);
  double squares = 0;
  for (const double r : fits.residual) squares += r * r;
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(z.size())), 0.3, 0.01);
}

TEST(LocalFits, TakeALowerDegreeOrNoneWhereNodesAreFewOrInLine) {
  for (const Family& family : families())
    for (const std::size_t n : {1UL, 2UL, 3UL, 4UL, 9UL, 200UL}) {
      const Points points = distinct(family.make(n, 7));
      double side = 1;
      for (const Point2& p : points) side = std::max({side, std::fabs(p.x), std::fabs(p.y)});
      std::vector<Point2> moved;
      for (const Point2& p : points) moved.push_back({(p.x / side + 1) / 2, (p.y / side + 1) / 2});
      const Scan scan(distinct(moved));
      std::vector<double> z;
      for (const Point2& p : scan.xy) z.push_back(3 * p.x - p.y);
      const LocalFits fits = scan.fit(z);
      for (std::size_t i = 0; i < z.size(); ++i) {
        EXPECT_TRUE(std::isfinite(fits.residual[i])) << family.name;
        for (const double c : fits.shape[i]) EXPECT_TRUE(std::isfinite(c)) << family.name;
        EXPECT_NEAR(fits.residual[i], 0, 1e-6) << family.name << n;  // a plane, whatever the degree
      }
    }
}

}  // namespace
}  // namespace isopach::test
