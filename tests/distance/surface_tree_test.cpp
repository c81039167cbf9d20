// Closest points and crossings against every triangle, one by one, in long double.
#include "isopach/distance/surface_tree.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

using Real = long double;
struct Vec {
  Real x, y, z;
};
Vec vec(const Point3& p) { return {p.x, p.y, p.z}; }
Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Real dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(const Vec& a, const Vec& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

Real to_segment2(const Vec& p, const Vec& a, const Vec& b) {
  const Vec ab = b - a, ap = p - a;
  const Real l2 = dot(ab, ab), s = l2 > 0 ? std::clamp(dot(ap, ab) / l2, Real(0), Real(1)) : Real(0);
  const Vec r{ap.x - s * ab.x, ap.y - s * ab.y, ap.z - s * ab.z};
  return dot(r, r);
}

Real brute_distance(const Point3& q, const std::array<Point3, 3>& corners) {
  const Vec p = vec(q), c[3] = {vec(corners[0]), vec(corners[1]), vec(corners[2])};
  Real best = std::min({to_segment2(p, c[0], c[1]), to_segment2(p, c[1], c[2]), to_segment2(p, c[2], c[0])});
  const Vec n = cross(c[1] - c[0], c[2] - c[0]);
  const Real n2 = dot(n, n);
  bool inside = n2 > 0;
  for (int k = 0; k < 3 && inside; ++k) inside = dot(cross(c[(k + 1) % 3] - c[k], p - c[k]), n) > 0;
  if (inside) {
    const Real h = dot(p - c[0], n);
    best = std::min(best, h * h / n2);
  }
  return std::sqrt(best);
}

Mesh rough_mesh(const test::Points& points, double height, std::uint64_t seed) {
  Mesh mesh;
  const SortedTriangulation t = triangulate_unsorted(points, {});
  test::Random random(seed);
  for (const Point2& p : t.xy) mesh.points.push_back({p.x, p.y, random.uniform(-height, height)});
  for (Index i = 0; i < t.triangulation.real; ++i) mesh.faces.push_back(t.triangulation.triangles[i].v);
  return mesh;
}

double extent(const Mesh& mesh) {
  double largest = 0;
  for (const Point3& p : mesh.points) largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  return largest;
}

/// Random, on nodes, on edges, over the middle of faces, far away.
std::vector<Point3> queries(const Mesh& mesh, std::uint64_t seed) {
  test::Random random(seed);
  Box3 box;
  for (const Point3& p : mesh.points) box.add(p);
  const double dx = box.max.x - box.min.x, dy = box.max.y - box.min.y;
  std::vector<Point3> all;
  for (int i = 0; i < 60; ++i) {
    all.push_back({random.uniform(box.min.x - 0.2 * dx, box.max.x + 0.2 * dx),
                   random.uniform(box.min.y - 0.2 * dy, box.max.y + 0.2 * dy),
                   random.uniform(2 * box.min.z, 2 * box.max.z)});
    const auto c = mesh.corners(random.below(mesh.faces.size()));
    all.push_back(c[0]);
    all.push_back({(c[0].x + c[1].x) / 2, (c[0].y + c[1].y) / 2, (c[0].z + c[1].z) / 2});
    all.push_back({(c[0].x + c[1].x + c[2].x) / 3, (c[0].y + c[1].y + c[2].y) / 3, box.max.z});
  }
  all.push_back({box.max.x + 10 * dx, box.max.y + 10 * dy, 0});
  return all;
}

TEST(SurfaceTree, ClosestIsThatOfEveryTriangleTried) {
  for (const test::Family& family : test::families()) {
    if (family.collinear) continue;
    SCOPED_TRACE(family.name);
    for (const double height : {0.0, 0.3, 50.0}) {
      const Mesh mesh = rough_mesh(family.make(300, 7), height, 11);
      if (mesh.faces.empty()) continue;
      const SurfaceTree tree(mesh);
      const double scale = extent(mesh);
      for (const Point3& q : queries(mesh, 3)) {
        Real best = std::numeric_limits<Real>::infinity();
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) best = std::min(best, brute_distance(q, mesh.corners(f)));
        const Closest found = tree.closest(q);
        ASSERT_NE(found.face, no_index);
        const double distance = std::sqrt(found.at.distance2);
        // Relative to the coordinates, or to the distance where the query is farther away than these.
        EXPECT_NEAR(distance, static_cast<double>(best), 1e-12 * std::max(scale, distance));
        EXPECT_NEAR(static_cast<double>(brute_distance(found.at.point, mesh.corners(found.face))), 0, 1e-12 * scale);
      }
    }
  }
}

TEST(SurfaceTree, DegenerateFaces) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 5, 5}};
  mesh.faces = {{0, 1, 2}, {3, 3, 3}, {0, 0, 1}};
  const SurfaceTree tree(mesh);
  EXPECT_DOUBLE_EQ(tree.closest({1.5, 2, 0}).at.distance2, 4);
  EXPECT_DOUBLE_EQ(tree.closest({3, 0, 0}).at.distance2, 1);
  EXPECT_DOUBLE_EQ(tree.closest({6, 5, 5}).at.distance2, 1);
  EXPECT_EQ(tree.cross({1, 0, 1}, {0, 0, 1}).face, no_index);
}

TEST(SurfaceTree, SliversAreAsExactAsOthers) {
  for (const double width : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15}) {
    Mesh mesh;
    mesh.points = {{0, 0, 0}, {1, 0.3, 0.2}, {0.5, 0.15 + width, 0.1}};
    mesh.faces = {{0, 1, 2}};
    const SurfaceTree tree(mesh);
    test::Random random(5);
    for (int i = 0; i < 200; ++i) {
      const double u = random.uniform(), v = random.uniform() * (1 - u);
      const auto c = mesh.corners(0);
      const double lift = i % 2 == 0 ? 0 : random.uniform(-1, 1);
      const Point3 q{c[0].x + u * (c[1].x - c[0].x) + v * (c[2].x - c[0].x),
                     c[0].y + u * (c[1].y - c[0].y) + v * (c[2].y - c[0].y),
                     c[0].z + u * (c[1].z - c[0].z) + v * (c[2].z - c[0].z) + lift};
      EXPECT_NEAR(std::sqrt(tree.closest(q).at.distance2), static_cast<double>(brute_distance(q, c)), 1e-12) << width;
    }
  }
}

TEST(SurfaceTree, UprightLinesMeetTheSurfaceOnceEverywhereOverIt) {
  // Integer nodes: lines through nodes and edges are exact, and none may slip through.
  const Mesh mesh = rough_mesh(test::grid(400, 1), 3, 5);
  const SurfaceTree tree(mesh);
  for (double x = 0; x <= 19; x += 0.25)
    for (double y = 0; y <= 19; y += 0.25) {
      const Crossing c = tree.cross({x, y, 100}, {0, 0, 1});
      ASSERT_NE(c.face, no_index) << x << ' ' << y;
      EXPECT_NEAR(std::sqrt(tree.closest({x, y, 100 + c.t}).at.distance2), 0, 1e-12);
    }
  EXPECT_EQ(tree.cross({-0.001, 3, 0}, {0, 0, 1}).face, no_index);
}

TEST(SurfaceTree, SlantedLinesAgainstEveryTriangle) {
  const Mesh mesh = rough_mesh(test::uniform(400, 3), 0.3, 5);
  const SurfaceTree tree(mesh);
  test::Random random(9);
  int met = 0;
  for (int i = 0; i < 500; ++i) {
    const Point3 p{random.uniform(-0.2, 1.2), random.uniform(-0.2, 1.2), random.uniform(-0.5, 0.5)};
    const Point3 d{random.uniform(-1, 1), random.uniform(-1, 1), i % 3 == 0 ? 0 : random.uniform(-1, 1)};
    Real best = std::numeric_limits<Real>::infinity();
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto c = mesh.corners(f);
      const Vec a = vec(c[0]), e1 = vec(c[1]) - a, e2 = vec(c[2]) - a, s = vec(p) - a, w = vec(d);
      const Real det = dot(cross(w, e2), e1);
      if (det == 0) continue;
      const Real u = dot(cross(w, e2), s) / det, v = dot(cross(s, e1), w) / det, t = dot(cross(s, e1), e2) / det;
      if (u >= 0 && v >= 0 && u + v <= 1 && std::abs(t) < std::abs(best)) best = t;
    }
    const Crossing c = tree.cross(p, d);
    ASSERT_EQ(c.face == no_index, !std::isfinite(static_cast<double>(best)));
    if (c.face == no_index) continue;
    ++met;
    EXPECT_NEAR(c.t, static_cast<double>(best), 1e-10 * std::max(1.0, std::fabs(c.t)));
  }
  EXPECT_GT(met, 100);
}

TEST(SurfaceTree, AFaceIsFoundForAnySize) {
  for (std::size_t n = 1; n < 70; ++n) {  // one leaf, uneven leaves, several levels
    Mesh mesh;
    for (std::size_t i = 0; i < n; ++i) {
      const auto x = static_cast<double>(i);
      mesh.points.insert(mesh.points.end(), {{3 * x, 0, 0}, {3 * x + 1, 0, 0}, {3 * x, 1, 0}});
      mesh.faces.push_back({static_cast<Index>(3 * i), static_cast<Index>(3 * i + 1), static_cast<Index>(3 * i + 2)});
    }
    const SurfaceTree tree(mesh);
    for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(tree.closest({3.0 * static_cast<double>(i) + 0.2, 0.2, 1}).face, i);
  }
}

}  // namespace
}  // namespace isopach
