// Interpolation reproduces planes within its stated bound, stays between the heights it is made from, and clamps
// outside.
#include "isopach/overlay/interpolate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "isopach/delaunay/triangulate.hpp"
#include "isopach/overlay/localise.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

using Kind = Location::Kind;

struct Asked {
  SortedTriangulation mesh, points;
  Locations where;
};
Asked ask(const Points& mesh, const Points& points) {
  Asked a{triangulate_unsorted(mesh, {}), triangulate_unsorted(points, {}), {}};
  a.where = localise(a.points.xy, spanning_tree(a.points.triangulation, a.points.xy, {}), a.mesh.triangulation,
                     a.mesh.xy, {});
  return a;
}
Array<double> interpolate_all(const Asked& a, const std::vector<double>& z) {
  return interpolate(a.where, a.points.xy, a.mesh.triangulation, a.mesh.xy, z, {});
}

Points over_the_box(const Points& mesh, std::size_t n, std::uint64_t seed) {
  Box2 box;
  for (const Point2& p : mesh) box.add(p);
  Random random(seed);
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    points.push_back({box.min.x + (box.max.x - box.min.x) * random.uniform(-0.1, 1.1),
                      box.min.y + (box.max.y - box.min.y) * random.uniform(-0.1, 1.1)});
    const Point2 &p = mesh[random.below(mesh.size())], &q = mesh[random.below(mesh.size())];
    points.push_back({(p.x + q.x) / 2, (p.y + q.y) / 2});
  }
  return points;
}

/// How many times longer than wide the triangle round point i is: weights are quotients of areas, so this is the factor
/// by which they lose.
double conditioning(const Asked& a, std::size_t i) {
  const auto& v = a.mesh.triangulation.triangles[a.where.id[i]].v;
  const Point2 &p = a.mesh.xy[v[0]], &q = a.mesh.xy[v[1]], &r = a.mesh.xy[v[2]];
  const auto square = [](const Point2& s, const Point2& t) {
    return (s.x - t.x) * (s.x - t.x) + (s.y - t.y) * (s.y - t.y);
  };
  return std::max({square(p, q), square(q, r), square(r, p)}) / static_cast<double>(2 * polygon_area({p, q, r}));
}

class InterpolateFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, InterpolateFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(InterpolateFamilies, ReproducesPlanesWithinTheBound) {
  const Points nodes = GetParam().make(1000, 91);
  const Asked a = ask(nodes, over_the_box(nodes, 2000, 92));
  Box2 box;
  for (const Point2& p : nodes) box.add(p);
  const double w = std::max(box.max.x - box.min.x, box.max.y - box.min.y);
  const auto plane = [&](const Point2& p) {
    return static_cast<double>(3 + 2 * (static_cast<long double>(p.x) - box.min.x) / w -
                               5 * (static_cast<long double>(p.y) - box.min.y) / w);
  };
  std::vector<double> z;
  for (const Point2& p : a.mesh.xy) z.push_back(plane(p));
  const Array<double> found = interpolate_all(a, z);
  std::size_t inside = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (a.where.kind[i] != Kind::triangle) continue;
    ++inside;
    const auto& v = a.mesh.triangulation.triangles[a.where.id[i]].v;
    const auto [low, high] = std::minmax({z[v[0]], z[v[1]], z[v[2]]});
    // The heights given are themselves rounded to one ulp of their size.
    const double bound = conditioning(a, i) < 1e6 ? plane_interpolation_bound : 1e-14 * conditioning(a, i);
    EXPECT_NEAR(found[i], plane(a.points.xy[i]), std::min(1.0, bound) * (high - low) + 8e-16);
  }
  if (!GetParam().collinear) {
    EXPECT_GT(inside, 0u);
  }
}

TEST_P(InterpolateFamilies, StaysBetweenTheHeightsItIsMadeFrom) {
  const Points nodes = GetParam().make(1000, 93);
  const Asked a = ask(nodes, over_the_box(nodes, 2000, 94));
  Random random(95);
  std::vector<double> z;
  for (std::size_t i = 0; i < a.mesh.xy.size(); ++i) z.push_back(random.uniform(-1, 1));
  const Array<double> found = interpolate_all(a, z);
  const Triangulation& t = a.mesh.triangulation;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Location at = a.where[i];
    double low = 0, high = 0;
    if (at.kind == Kind::node) {
      EXPECT_EQ(found[i], z[at.id]);
      continue;
    }
    if (at.kind == Kind::triangle) {
      const auto& v = t.triangles[at.id].v;
      std::tie(low, high) = std::minmax({z[v[0]], z[v[1]], z[v[2]]});
    } else {
      std::tie(low, high) = std::minmax({z[t.origin(at.id)], z[t.target(at.id)]});
    }
    // One rounding of the sum za + s·(zb − za).
    EXPECT_GE(found[i], low - 2e-16);
    EXPECT_LE(found[i], high + 2e-16);
  }
}

TEST_P(InterpolateFamilies, EqualsTheOracleInsideAndOutside) {
  if (GetParam().collinear) return;  // the oracle has no surface over a line
  const Points nodes = GetParam().make(40, 96);
  const Asked a = ask(nodes, over_the_box(nodes, 200, 97));
  Random random(98);
  std::vector<double> z;
  for (std::size_t i = 0; i < a.mesh.xy.size(); ++i) z.push_back(random.uniform(-1, 1));
  const BruteSurface surface = brute_surface(Points(a.mesh.xy.begin(), a.mesh.xy.end()), z);
  const Array<double> found = interpolate_all(a, z);
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i], static_cast<double>(surface.clamped_at(a.points.xy[i])),
                a.where.kind[i] == Kind::triangle ? 1e-14 * conditioning(a, i) : 1e-9)
        << a.points.xy[i].x << " " << a.points.xy[i].y;
}

// Triangles of one ulp: points on y = x/3 but for the last bit. Weights made of rounded areas are noise there.
TEST(Interpolate, ReproducesPlanesInSliversOfOneUlp) {
  const Points nodes = nearly_diagonal(1000, 91);
  const Asked a = ask(nodes, over_the_box(nodes, 2000, 92));
  std::vector<double> z;
  for (const Point2& p : a.mesh.xy) z.push_back(p.x + 3 * p.y);
  const Array<double> found = interpolate_all(a, z);
  std::size_t inside = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (a.where.kind[i] != Kind::triangle) continue;
    ++inside;
    const auto& v = a.mesh.triangulation.triangles[a.where.id[i]].v;
    const auto [low, high] = std::minmax({z[v[0]], z[v[1]], z[v[2]]});
    EXPECT_NEAR(found[i], a.points.xy[i].x + 3 * a.points.xy[i].y, plane_interpolation_bound * (high - low) + 4e-12);
  }
  EXPECT_GT(inside, 0u);
}

TEST(Interpolate, IsTheSameFromBothSidesOfAnEdge) {
  // Points exactly on edges of an integer mesh: the value must not depend on which half-edge names the edge.
  const Points nodes = coarse_lattice(200, 99);
  Points doubled;
  for (const Point2& p : nodes) doubled.push_back({2 * p.x, 2 * p.y});
  const SortedTriangulation mesh = triangulate_unsorted(doubled, {});
  Points middles;
  for (const auto& [p, q] : edge_set(triangle_set(mesh.triangulation, mesh.xy)))
    middles.push_back({(p.x + q.x) / 2, (p.y + q.y) / 2});
  const Asked a = ask(doubled, middles);
  std::vector<double> z;
  for (const Point2& p : a.mesh.xy) z.push_back(p.x * 3 - p.y);
  const Array<double> found = interpolate_all(a, z);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_TRUE(a.where.kind[i] == Kind::edge || a.where.kind[i] == Kind::node);
    EXPECT_DOUBLE_EQ(found[i], a.points.xy[i].x * 3 - a.points.xy[i].y);
  }
}

TEST(Interpolate, OfASingleNodeIsItsHeightAndOfNoneNotANumber) {
  const Asked one = ask({{1, 1}}, {{1, 1}, {5, 5}});
  for (const double value : interpolate_all(one, {7})) EXPECT_EQ(value, 7);
  const Asked none = ask({}, {{1, 1}});
  EXPECT_TRUE(std::isnan(interpolate_all(none, {})[0]));
}

}  // namespace
}  // namespace isopach::test
