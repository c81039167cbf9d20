// Triangles as a current, against the surface they are of.
#include "isopach/measure/currents/current.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "tests/support/polygons.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

struct Mesh {
  Array<Point2> xy;
  Array<double> z;
  Triangulation t;
};

/// Random nodes in a square of side 10 with its corners, on the plane z = 1 + a x + b y.
Mesh plane(double a, double b) {
  Random random(3);
  Array<Point2> all{{0, 0}, {10, 0}, {0, 10}, {10, 10}};
  for (int i = 0; i < 500; ++i) all.push_back({random.uniform(0, 10), random.uniform(0, 10)});
  Box2 bounds;
  for (const Point2& p : all) bounds.add(p);
  Mesh m;
  const CurveBox box = curve_box(bounds);
  (void)curve_order(all, box, nullptr, &m.xy);
  for (const Point2& p : m.xy) m.z.push_back(1 + a * p.x + b * p.y);
  m.t = triangulate(m.xy, box, {});
  return m;
}

TEST(SurfaceCurrent, OfAPlaneIsItsAreaAlongItsNormal) {
  const Mesh m = plane(0.5, -2);
  const SurfaceCurrent s = surface_current(m.t, m.xy, m.z, {});
  ASSERT_EQ(s.centroids.size(), m.t.real);
  double x = 0, y = 0, z = 0;
  for (std::size_t i = 0; i < s.centroids.size(); ++i) {
    const Point3 &c = s.centroids[i], &n = s.normals[i];
    EXPECT_NEAR(c.z, 1 + 0.5 * c.x - 2 * c.y, 1e-12);
    EXPECT_NEAR(n.x, -0.5 * n.z, 1e-12);
    EXPECT_NEAR(n.y, 2 * n.z, 1e-12);
    EXPECT_GT(n.z, 0);
    x += n.x, y += n.y, z += n.z;
  }
  EXPECT_NEAR(x, -50, 1e-10);
  EXPECT_NEAR(y, 200, 1e-10);
  EXPECT_NEAR(z, 100, 1e-10);
}

Domain clip_to(const Rings& rings, std::size_t cells) {
  Region region{edges_of(rings), {}};
  region.parts = trapezoids(region.edges).value();
  Domain domain;
  domain.keep(Regions({region}, cells));
  return domain;
}

TEST(SurfaceCurrent, OfATriangleThatIsCutThePartInsideCounts) {
  const Mesh m = plane(0.5, -2);
  const Rings rings{star(RandomStream(5, 0), 0, {5, 5}, 4, 30), star(RandomStream(5, 1), 0, {5, 5}, 1, 9)};
  ASSERT_TRUE(is_valid(rings));
  const OGRPolygon polygon = to_ogr(rings);
  const Domain domain = clip_to(rings, m.t.real);
  const SurfaceCurrent whole = surface_current(m.t, m.xy, m.z, {});
  std::size_t cut = 0, count = 0;
  for (Index i = 0; i < m.t.real; ++i) {  // one by one, by another library
    Array<unsigned char> kept(m.t.real, 0);
    kept[i] = 1;
    const SurfaceCurrent s = surface_current(m.t, m.xy, m.z, kept, domain);
    count += s.centroids.size();
    const auto& v = m.t.triangles[i].v;
    const Geometry shared(triangle(m.xy[v[0]], m.xy[v[1]], m.xy[v[2]])->Intersection(&polygon));
    const double area = area_of(shared.get());
    if (s.centroids.empty()) {
      EXPECT_NEAR(area, 0, 1e-12);
      continue;
    }
    const Point3 &c = s.centroids[0], &n = s.normals[0];
    EXPECT_NEAR(n.z, area, 1e-12);
    EXPECT_NEAR(n.x, -0.5 * n.z, 1e-12);
    EXPECT_NEAR(n.y, 2 * n.z, 1e-12);
    EXPECT_NEAR(c.z, 1 + 0.5 * c.x - 2 * c.y, 1e-12);
    OGRPoint centre;
    if (area > 1e-6 && shared->Centroid(&centre) == OGRERR_NONE) {
      EXPECT_NEAR(c.x, centre.getX(), 1e-8);
      EXPECT_NEAR(c.y, centre.getY(), 1e-8);
    }
    const bool is_whole = c.x == whole.centroids[i].x && c.y == whole.centroids[i].y && n.z == whole.normals[i].z;
    cut += is_whole ? 0 : 1;
  }
  EXPECT_GT(cut, 50U);
  EXPECT_GT(count - cut, 50U);
  EXPECT_EQ(surface_current(m.t, m.xy, m.z, {}, domain).centroids.size(), count);
}

TEST(SurfaceCurrent, ADomainThatHoldsAllChangesNothing) {
  const Mesh m = plane(1, 1);
  const Domain domain = clip_to({{{-1, -1}, {11, -1}, {11, 11}, {-1, 11}}}, m.t.real);
  const SurfaceCurrent s = surface_current(m.t, m.xy, m.z, {}, domain), whole = surface_current(m.t, m.xy, m.z, {});
  ASSERT_EQ(s.centroids.size(), whole.centroids.size());
  EXPECT_EQ(s.mean_edge, whole.mean_edge);
  for (std::size_t i = 0; i < s.centroids.size(); ++i) EXPECT_EQ(s.normals[i].z, whole.normals[i].z);
  const Domain nothing = clip_to({{{20, 20}, {30, 20}, {30, 30}}}, m.t.real);
  EXPECT_TRUE(surface_current(m.t, m.xy, m.z, {}, nothing).centroids.empty());
}

TEST(SurfaceCurrent, HoldsTheTrianglesKeptAndTheirMeanEdge) {
  const Mesh m = plane(0, 0);
  Array<unsigned char> kept(m.t.real);
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = i % 3 == 0 ? 1 : 0;
  const SurfaceCurrent s = surface_current(m.t, m.xy, m.z, kept);
  ASSERT_EQ(s.centroids.size(), (m.t.real + 2) / 3);
  double edges = 0;
  for (std::size_t i = 0; i < m.t.real; i += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const Point2 &p = m.xy[m.t.triangles[i].v[k]], &q = m.xy[m.t.triangles[i].v[(k + 1) % 3]];
      edges += std::hypot(p.x - q.x, p.y - q.y);
    }
  EXPECT_NEAR(s.mean_edge, edges / (3.0 * static_cast<double>(s.centroids.size())), 1e-12);
  const SurfaceCurrent none = surface_current(m.t, m.xy, m.z, Array<unsigned char>(m.t.real, 0));
  EXPECT_EQ(none.mean_edge, 0);
  EXPECT_EQ(default_sigma(s, none), 5 * s.mean_edge);
}

TEST(SurfaceCurrent, LeavesOutTrianglesThatAreLines) {
  Mesh m;
  m.xy = {{0, 0}, {10, 0}, {5, -1e-12}, {5, 8}};
  m.z = {0, 0, 7, 0};
  Box2 bounds;
  for (const Point2& p : m.xy) bounds.add(p);
  m.t = triangulate(m.xy, curve_box(bounds), {});
  EXPECT_EQ(m.t.real, 2U);
  m.xy[2] = {5, 1e-12};  // now the hull has a sliver below it
  m.t = triangulate(m.xy, curve_box(bounds), {});
  EXPECT_EQ(m.t.real, 3U);
  EXPECT_EQ(surface_current(m.t, m.xy, m.z, {}).centroids.size(), 2U);
}

}  // namespace
}  // namespace isopach::test
