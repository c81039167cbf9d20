// Nominal meshes: told from scans by the points of the other scan, and matched without bias.
#include "isopach/match/surface/nominal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "isopach/base/random.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/match/match.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

constexpr double side = 100;

double hills(const Point2& p) { return 6 * std::sin(p.x / 12) * std::cos(p.y / 15); }

/// A mesh of few corners on the hills, with its faces.
struct Nominal {
  SortedTriangulation mesh;
  Array<double> z;
  Cloud cloud;

  Nominal(std::size_t corners, std::uint64_t seed) : mesh(triangulate_unsorted(places(corners, seed), {})) {
    for (const Point2& p : mesh.xy) {
      z.push_back(hills(p));
      cloud.points.push_back({p.x, p.y, z.back()});
    }
    for (Index i = 0; i < mesh.triangulation.real; ++i) cloud.faces.push_back(mesh.triangulation.triangles[i].v);
    cloud.format = "stl";
  }
  static test::Points places(std::size_t corners, std::uint64_t seed) {
    test::Points all = test::framed_square(corners, seed);
    for (Point2& p : all) p = {side * p.x, side * p.y};
    return all;
  }
  /// Points spread evenly over its facets, with noise along z.
  [[nodiscard]] Cloud sampled(std::size_t points, double noise, std::uint64_t seed) const {
    const RandomStream random(seed, 3);
    std::vector<double> up_to;
    double total = 0;
    const auto corner = [&](Index t, std::size_t k) { return mesh.triangulation.triangles[t].v[k]; };
    for (Index t = 0; t < mesh.triangulation.real; ++t) {
      const Point2 &a = mesh.xy[corner(t, 0)], &b = mesh.xy[corner(t, 1)], &c = mesh.xy[corner(t, 2)];
      up_to.push_back(total += (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
    }
    Cloud out;
    for (std::uint64_t i = 0; i < points; ++i) {
      const auto found = std::upper_bound(up_to.begin(), up_to.end(), total * random.uniform(5 * i));
      const auto t = std::min(static_cast<Index>(found - up_to.begin()), mesh.triangulation.real - 1);
      double u = random.uniform(5 * i + 1), v = random.uniform(5 * i + 2);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const double share[3] = {1 - u - v, u, v};
      Point3 p{0, 0, noise > 0 ? noise * RandomStream(seed, 4).normal(i) : 0};
      for (std::size_t k = 0; k < 3; ++k) {
        const Index node = corner(t, k);
        p = {p.x + share[k] * mesh.xy[node].x, p.y + share[k] * mesh.xy[node].y, p.z + share[k] * z[node]};
      }
      out.points.push_back(p);
    }
    return out;
  }
};

Cloud scan_of_hills(std::size_t points, double noise, std::uint64_t seed) {
  const RandomStream random(seed, 5);
  std::uint64_t i = 0;
  return test::cloud_over(Nominal::places(points, seed),
                          [&](const Point2& p) { return hills(p) + noise * random.normal(i++); });
}

MatchOptions with_scale() {
  MatchOptions options;
  options.freedom.scale = true;
  options.judge = false;
  return options;
}

TEST(Nominal, IsToldByThePointsOfTheOtherScan) {
  const Nominal nominal(300, 1);
  Cloud faces_of_a_scan = scan_of_hills(300, 0, 1);
  faces_of_a_scan.format = "stl";
  for (const double noise : {0.0, 0.05}) {
    const Matching on_facets = match(nominal.sampled(6000, noise, 2), nominal.cloud, with_scale(), {});
    EXPECT_TRUE(on_facets.nominal_fixed) << noise;
    EXPECT_FALSE(on_facets.nominal_moving);
    const Matching on_hills = match(scan_of_hills(6000, noise, 3), faces_of_a_scan, with_scale(), {});
    EXPECT_FALSE(on_hills.nominal_fixed) << noise;
  }
}

/// The hills sampled at `corners` places, with its triangulation as faces: a scan as scanners write it.
Cloud scan_with_faces(std::size_t corners, double noise, double detail) {
  Nominal made(corners, 1);
  const RandomStream random(7, 6);
  for (std::size_t i = 0; i < made.cloud.points.size(); ++i) {
    Point3& p = made.cloud.points[i];
    p.z += noise * random.normal(i) + detail * std::sin(1.7 * p.x) * std::cos(1.3 * p.y);
  }
  return made.cloud;
}

// The rise of facets that noise or detail finer than the points has bent is none that the other scan could show.
TEST(Nominal, ScansWithNoiseOrDetailAreNone) {
  struct Case {
    double noise, detail;
  };
  for (const Case& c : {Case{0.3, 0}, {0.05, 0}, {0, 0.3}, {0.02, 0.3}, {0.3, 0.3}})
    for (const std::size_t points : {2000, 20000}) {
      const RandomStream random(8, 7);
      std::uint64_t i = 0;
      const Cloud moving = test::cloud_over(Nominal::places(points, 3), [&](const Point2& p) {
        return hills(p) + c.noise * random.normal(i++) + c.detail * std::sin(1.7 * p.x) * std::cos(1.3 * p.y);
      });
      MatchOptions options;
      options.judge = false;
      const Matching m = match(moving, scan_with_faces(2000, c.noise, c.detail), options, {});
      EXPECT_FALSE(m.nominal_fixed || m.nominal_moving) << c.noise << " " << c.detail << " " << points;
    }
}

TEST(Nominal, OfTwoThatCouldBeTheOneThatIs) {
  const Nominal nominal(300, 1);
  const Cloud sampled = nominal.sampled(3000, 0.05, 2);
  test::Points places;
  for (const Point3& p : sampled.points) places.push_back({p.x, p.y});
  const SortedTriangulation t = triangulate_unsorted(places, {});
  std::map<std::pair<double, double>, double> height;
  for (const Point3& p : sampled.points) height[{p.x, p.y}] = p.z;
  Cloud scan;
  for (const Point2& p : t.xy) scan.points.push_back({p.x, p.y, height.at({p.x, p.y})});
  for (Index i = 0; i < t.triangulation.real; ++i) scan.faces.push_back(t.triangulation.triangles[i].v);
  scan.format = "stl";
  const Matching as_fixed = match(scan, nominal.cloud, with_scale(), {});
  EXPECT_TRUE(as_fixed.nominal_fixed);
  const Matching as_moving = match(nominal.cloud, scan, with_scale(), {});
  EXPECT_TRUE(as_moving.nominal_moving);
  EXPECT_FALSE(as_moving.nominal_fixed);
}

TEST(Nominal, WithoutFacesNothingIsNominal) {
  const Nominal nominal(300, 1);
  Cloud points = nominal.cloud;
  points.faces = {}, points.format = "xyz";
  EXPECT_FALSE(match(nominal.sampled(6000, 0, 2), points, with_scale(), {}).nominal_fixed);
}

TEST(Nominal, PointsOnFaces) {
  const Nominal nominal(60, 1);
  Cloud mesh = nominal.cloud;
  const Cloud points = points_on_faces(mesh, 2000, 7);
  EXPECT_NEAR(static_cast<double>(points.points.size()), 2000, 30);
  // On the facets, and as many in each half as it has area.
  double left = 0;
  for (const Point3& p : points.points) {
    left += p.x < side / 2 ? 1 : 0;
    double least = 1e9;
    for (const auto& face : mesh.faces) {
      const Point3 &a = mesh.points[face[0]], &b = mesh.points[face[1]], &c = mesh.points[face[2]];
      const double det = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
      const double v = ((p.x - a.x) * (c.y - a.y) - (p.y - a.y) * (c.x - a.x)) / det;
      const double w = ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) / det;
      if (v < -1e-9 || w < -1e-9 || v + w > 1 + 1e-9) continue;
      least = std::min(least, std::fabs(a.z + v * (b.z - a.z) + w * (c.z - a.z) - p.z));
    }
    ASSERT_LT(least, 1e-9);
  }
  EXPECT_NEAR(left / static_cast<double>(points.points.size()), 0.5, 0.08);
  std::reverse(mesh.faces.begin(), mesh.faces.end());
  for (auto& face : mesh.faces) std::swap(face[0], face[2]);
  const auto sorted = [](Cloud cloud) {
    std::sort(cloud.points.begin(), cloud.points.end(),
              [](const Point3& a, const Point3& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    return cloud.points;
  };
  EXPECT_EQ(sorted(points_on_faces(mesh, 2000, 7)), sorted(points));
  mesh.faces = {{0, 0, 1}};
  EXPECT_TRUE(points_on_faces(mesh, 2000, 7).points.empty());
}

// Scale of noise-free samples on the mesh they were taken from: the mean of many runs within one standard error of 1.
TEST(Nominal, ScaleIsUnbiased) {
  constexpr int runs = 30;
  double sum = 0, squares = 0;
  for (std::uint64_t run = 0; run < runs; ++run) {
    const Nominal nominal(200, 100 + run);
    const double off = match(nominal.sampled(3000, 0, 200 + run), nominal.cloud, with_scale(), {}).scale - 1;
    sum += off, squares += off * off;
  }
  const double mean = sum / runs, deviation = std::sqrt((squares / runs - mean * mean) * runs / (runs - 1));
  EXPECT_LT(std::fabs(mean), 1e-5);
  EXPECT_LT(std::fabs(mean), 2.5 * deviation / std::sqrt(runs)) << mean << " " << deviation;
}

TEST(Nominal, TheSameBitsForAnyThreadsAndOrder) {
  const Nominal nominal(200, 1);
  const Cloud points = nominal.sampled(3000, 0.02, 2);
  Context three;
  three.threads = 3;
  const Matching one = match(points, nominal.cloud, with_scale(), {});
  EXPECT_EQ(match(points, nominal.cloud, with_scale(), three).pose.m, one.pose.m);
  EXPECT_EQ(match(test::shuffled(points, 3), nominal.cloud, with_scale(), {}).pose.m, one.pose.m);
}

}  // namespace
}  // namespace isopach
