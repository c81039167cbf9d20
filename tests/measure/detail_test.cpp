// ρ_dV against its definition: every node of the finer mesh tried in every triangle of the coarser one, exactly.
#include "isopach/measure/volume/detail.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/measure/domain.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/oracle.hpp"

namespace isopach::test {
namespace {

struct Side {
  SortedTriangulation mesh;
  std::vector<double> z;
  std::vector<unsigned char> kept;
  Locations in_other;
  Array<double> other_z;

  [[nodiscard]] OverlayMesh view() const { return {mesh.triangulation, mesh.xy, z, in_other, other_z, kept}; }
};

struct Pair {
  Side a, b;
  Pair(const Points& in_a, const Points& in_b, std::uint64_t seed, double removed) {
    Random random(seed);
    a.mesh = triangulate_unsorted(in_a, {}), b.mesh = triangulate_unsorted(in_b, {});
    for (Side* s : {&a, &b}) {
      for (std::size_t i = 0; i < s->mesh.xy.size(); ++i) s->z.push_back(random.uniform(-1, 1));
      if (removed > 0)
        for (Index i = 0; i < s->mesh.triangulation.real; ++i) s->kept.push_back(random.uniform() < removed ? 0 : 1);
    }
    locate(a, b), locate(b, a);
  }
  static void locate(Side& s, const Side& other) {
    s.in_other = localise_in_order(s.mesh.xy, other.mesh.triangulation, other.mesh.xy, {});
    s.other_z = interpolate(s.in_other, s.mesh.xy, other.mesh.triangulation, other.mesh.xy, other.z, {});
  }
};

std::array<Point2, 3> corners(const OverlayMesh& m, std::size_t t) {
  const auto& v = m.t.triangles[t].v;
  return {m.xy[v[0]], m.xy[v[1]], m.xy[v[2]]};
}
bool kept(const OverlayMesh& m, std::size_t t) { return m.kept.empty() || m.kept[t] != 0; }
bool touches(const std::array<Point2, 3>& c, const Point2& q) {
  return exact_orientation(c[0], c[1], q) >= 0 && exact_orientation(c[1], c[2], q) >= 0 &&
         exact_orientation(c[2], c[0], q) >= 0;
}
long double area(const std::array<Point2, 3>& c) { return polygon_area({c[0], c[1], c[2]}); }

struct Brute {
  long double area = 0, sum = 0, sizes = 0;
  Index averaged = 0, bare = 0;
};

Brute brute_detail(const OverlayMesh& coarse, const OverlayMesh& fine, bool extrapolate) {
  const std::size_t nodes = fine.xy.size();
  std::vector<long double> weight(nodes, 0);
  std::vector<int> share(nodes, 0);
  for (std::size_t q = 0; q < nodes; ++q) {
    for (Index t = 0; t < fine.t.real; ++t)
      for (const Point2& corner : corners(fine, t))
        if (kept(fine, t) && corner == fine.xy[q]) weight[q] += area(corners(fine, t)) / 3;
    for (Index t = 0; t < coarse.t.real; ++t)
      share[q] += kept(coarse, t) && touches(corners(coarse, t), fine.xy[q]) ? 1 : 0;
  }
  Brute found;
  for (Index t = 0; t < coarse.t.real; ++t) {
    if (!kept(coarse, t)) continue;
    bool known = true;
    long double at_nodes = 0;
    for (const Index node : coarse.t.triangles[t].v) {
      bool inside = extrapolate;
      for (Index s = 0; s < fine.t.real; ++s) inside |= kept(fine, s) && touches(corners(fine, s), coarse.xy[node]);
      known &= inside;
      at_nodes += static_cast<long double>(coarse.other_z[node]) - coarse.z[node];
    }
    if (!known) continue;
    long double w = 0, sum = 0;
    for (std::size_t q = 0; q < nodes; ++q) {
      if (!(weight[q] > 0) || !touches(corners(coarse, t), fine.xy[q])) continue;
      w += weight[q] / share[q];
      sum += weight[q] / share[q] * (static_cast<long double>(fine.z[q]) - fine.other_z[q]);
    }
    const long double delta = w > 0 ? sum / w : at_nodes / 3;
    ++(w > 0 ? found.averaged : found.bare);
    found.area += area(corners(coarse, t));
    found.sum += area(corners(coarse, t)) * delta;
    found.sizes += area(corners(coarse, t)) * std::fabs(delta);
  }
  return found;
}

void expect_as_defined(const Pair& p, bool extrapolate) {
  const auto found = detail_measure(p.a.view(), p.b.view(), extrapolate, Domain::everything(), {});
  const auto mean_area = [](const OverlayMesh& m) {
    long double sum = 0;
    for (Index t = 0; t < m.t.real; ++t) sum += kept(m, t) ? area(corners(m, t)) : 0;
    return sum / static_cast<long double>(m.xy.size());
  };
  const bool coarser_is_b = mean_area(p.b.view()) > mean_area(p.a.view());
  const Brute brute = coarser_is_b ? brute_detail(p.b.view(), p.a.view(), extrapolate)
                                   : brute_detail(p.a.view(), p.b.view(), extrapolate);
  if (!(brute.area > 0)) {
    EXPECT_FALSE(found);
    return;
  }
  ASSERT_TRUE(found);
  EXPECT_EQ(found->coarser_is_b, coarser_is_b);
  EXPECT_EQ(found->averaged, brute.averaged);
  EXPECT_EQ(found->bare, brute.bare);
  const auto close = [](double value, long double expected, long double scale) {
    EXPECT_NEAR(value, static_cast<double>(expected), 1e-11 * static_cast<double>(scale));
  };
  close(found->area, brute.area, brute.area);
  close(found->rho, brute.sizes / brute.area, 1);
  close(found->mean, (coarser_is_b ? -1 : 1) * brute.sum / brute.area, 1);
}

TEST(Detail, IsTheMeanOfTheFinerNodesInEachCoarserTriangle) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(100 + seed);
    const std::size_t n = 5 + random.below(60), m = 5 + random.below(150);
    for (const double removed : {0.0, 0.2})
      for (const bool extrapolate : {false, true})
        expect_as_defined({framed_square(n, seed), uniform(m, 900 + seed), seed, removed}, extrapolate);
  }
}

// Nodes on edges and nodes of the other mesh, collinear runs, shared nodes, large coordinates.
TEST(Detail, SharesNodesOnEdgesAndNodesEqually) {
  const Points fine = grid(144, 0);
  Points coarse, moved_fine, moved_coarse;
  for (const Point2& p : fine)
    if (std::fmod(p.x, 3) == 0 && std::fmod(p.y, 3) == 0) coarse.push_back(p);
  for (const Point2& p : fine) moved_fine.push_back({p.x + 1e6, p.y - 4e6});
  for (const Point2& p : coarse) moved_coarse.push_back({p.x + 1e6, p.y - 4e6});
  for (const double removed : {0.0, 0.3}) {
    expect_as_defined({coarse, fine, 7, removed}, false);
    expect_as_defined({fine, coarse, 7, removed}, false);
    expect_as_defined({moved_coarse, moved_fine, 8, removed}, false);
    expect_as_defined({fine, fine, 9, removed}, false);
    expect_as_defined({coarse_lattice(60, 3), coarse_lattice(150, 4), 10, removed}, false);
    expect_as_defined({few_lines(40, 3), coarse_lattice(150, 4), 11, removed}, true);
  }
}

// Areas at a node that no two doubles hold the sum of.
TEST(Detail, AddsAreasThatAreOrdersOfMagnitudeApart) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Points fine = framed_square(30, seed);
    for (const Point2& p : uniform(60, 50 + seed)) fine.push_back({0.5 + 1e-9 * p.x, 0.5 + 1e-9 * p.y});
    expect_as_defined({framed_square(12, 90 + seed), fine, seed, 0}, false);
    expect_as_defined({fine, framed_square(12, 90 + seed), seed, 0.1}, false);
  }
}

TEST(Detail, HasNoValueWhereNothingIsShared) {
  Points far;
  for (const Point2& p : uniform(30, 2)) far.push_back({p.x + 5, p.y});
  const Pair p(uniform(20, 1), far, 3, 0);
  EXPECT_FALSE(detail_measure(p.a.view(), p.b.view(), false, Domain::everything(), {}));
}

TEST(Detail, DoesNotDependOnRolesOrThreads) {
  const Pair p(uniform(3000, 1), uniform(20000, 2), 3, 0.1);
  const auto once = detail_measure(p.a.view(), p.b.view(), false, Domain::everything(), {});
  const auto swapped = detail_measure(p.b.view(), p.a.view(), false, Domain::everything(), {});
  ASSERT_TRUE(once && swapped);
  EXPECT_FALSE(once->coarser_is_b);
  EXPECT_TRUE(swapped->coarser_is_b);
  EXPECT_EQ(once->rho, swapped->rho);
  EXPECT_EQ(once->mean, -swapped->mean);
  EXPECT_EQ(once->area, swapped->area);
  for (const int threads : {1, 3, 8})
    run_with_threads(threads, [&] {
      const auto again = detail_measure(p.a.view(), p.b.view(), false, Domain::everything(), {});
      EXPECT_EQ(again->rho, once->rho);
      EXPECT_EQ(again->mean, once->mean);
    });
}

Comparison compared(const Cloud& a, const Cloud& b) {
  CompareOptions o;
  o.check_layers = false;
  return compare(a, b, o, {});
}

TEST(Detail, OfALiftedPlaneIsTheLift) {
  const Comparison c = compared(cloud_over(framed_square(200, 1), [](const Point2& p) { return p.x; }),
                                cloud_over(framed_square(5000, 2), [](const Point2& p) { return p.x + 0.25; }));
  ASSERT_TRUE(c.detail);
  EXPECT_NEAR(c.detail->rho, 0.25, 1e-12);
  EXPECT_NEAR(c.detail->mean, 0.25, 1e-12);
  EXPECT_NEAR(c.detail->area, 1, 0.01);
}

// The reason for the measure: waves that the coarse scan cannot hold are most of ρ_V and little of ρ_dV; a bias is
// there in both.
TEST(Detail, CancelsWhatTheCoarserScanCannotHold) {
  const auto waves = [](double lift) {
    return [lift](const Point2& p) { return lift + 0.1 * std::sin(150 * p.x) * std::sin(150 * p.y); };
  };
  const Cloud coarse = cloud_over(framed_square(100, 1), [](const Point2&) { return 0; });
  const Comparison same = compared(coarse, cloud_over(framed_square(40000, 2), waves(0)));
  EXPECT_GT(same.measures.rho, 0.03);
  EXPECT_LT(same.detail->rho, 0.1 * same.measures.rho);
  const Comparison lifted = compared(coarse, cloud_over(framed_square(40000, 2), waves(0.02)));
  EXPECT_GT(lifted.measures.rho, 0.03) << "says nothing of the bias";
  EXPECT_NEAR(lifted.detail->rho, 0.02, 0.001);
}

TEST(Detail, DoesNotDependOnTheOrderOfThePoints) {
  const Cloud a = rough_cloud(uniform(500, 1), 2), b = rough_cloud(uniform(4000, 3), 4);
  const Comparison once = compared(a, b), again = compared(shuffled(a, 5), shuffled(b, 6));
  EXPECT_EQ(once.detail->rho, again.detail->rho);
  EXPECT_EQ(once.detail->mean, again.detail->mean);
}

// With the locations by the interface nothing of ρ_dV is searched for: the number of triangles visited, which it is a
// pass over, stays linear where that of the tree is quadratic (see also ByInterface.IsLinearWhereTheTreeIsQuadratic).
TEST(Detail, VisitsALinearNumberOfTrianglesInTheWorstCase) {
  const auto visited = [](std::size_t n, LocateMethod method) {
    SceneOptions o;
    o.points_a = o.points_b = n;
    const Scene scene = make_scene("worst-case", o, {});
    CompareOptions c;
    c.check_layers = false;
    c.border = BorderRule::hull;
    c.domain = DomainKind::hull;  // no triangle of the far columns lies in the zigzag
    c.locate = method;
    const Comparison found = compare(scene.a, scene.b, c, {});
    EXPECT_TRUE(found.detail);
    return static_cast<double>(found.visited_1_in_2 + found.visited_2_in_1) / static_cast<double>(n);
  };
  EXPECT_LE(visited(16000, LocateMethod::interface), 40);
  EXPECT_LE(visited(16000, LocateMethod::interface), 1.2 * visited(1000, LocateMethod::interface));
  EXPECT_GT(visited(2000, LocateMethod::tree), 1.8 * visited(1000, LocateMethod::tree));
}

}  // namespace
}  // namespace isopach::test
