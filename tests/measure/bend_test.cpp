// What the cells leave out of two surfaces that bend: against dense quadrature by brute force, drawn cells against all.
#include "isopach/measure/volume/bend.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/overlay/localise.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

struct Compared {
  Comparison c;
  isopach::Pair meshes;
};

CompareOptions cubic_options() {
  CompareOptions o;
  o.interpolation = Interpolation::cubic;
  o.border = BorderRule::hull;
  o.check_layers = false;
  return o;
}

Compared compared(const Cloud& a, const Cloud& b, const CompareOptions& o = cubic_options()) {
  Compared p;
  p.c = compare(a, b, o, {}, p.meshes);
  return p;
}

/// Waves of a length of several to one and a half distances of nodes, a lift so that d changes sign or does not.
Compared wavy_pair(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  const double k = random.uniform(2, 12), phase = random.uniform(0, 6), lift = random.uniform(-0.3, 0.3),
               change = random.uniform(0, 0.4);
  const auto f1 = [=](const Point2& p) { return std::sin(k * p.x + phase) * std::cos(0.7 * k * p.y); };
  const auto f2 = [=](const Point2& p) { return f1(p) + lift + change * std::sin(0.6 * k * p.y - k * p.x); };
  return compared(cloud_over(uniform(n, 3 * seed + 1), f1), cloud_over(uniform(n + n / 3, 3 * seed + 2), f2));
}

struct SmoothPair {
  SmoothSurface s1, s2;
  explicit SmoothPair(const isopach::Pair& m)
      : s1(m.scan[0].t, m.scan[0].field.xy, m.scan[0].field.z, {}),
        s2(m.scan[1].t, m.scan[1].field.xy, m.scan[1].field.z, {}) {}
};

BendError bend(const Compared& p) {
  const SmoothPair smooth(p.meshes);
  return bend_error(p.c.cells.view(), smooth.s1, smooth.s2, {});
}

/// Brute force: every cell cut into `steps`² triangles of one size, the heights at their centroids, no zero line. Every
/// point is looked for in all triangles of either scan.
Volume dense(const Compared& p, unsigned steps) {
  const CellView cells = p.c.cells.view();
  Array<Point2> points;
  std::vector<double> areas;
  for_common(cells, [&](const CommonCell& cell) {
    const Corner o = cell.corner(0), q = cell.corner(1), r = cell.corner(2);
    const auto add = [&](double s, double t) {
      s /= steps, t /= steps;
      points.push_back({o.x + s * (q.x - o.x) + t * (r.x - o.x), o.y + s * (q.y - o.y) + t * (r.y - o.y)});
      areas.push_back(cell.cell().area / (steps * steps));
    };
    for (unsigned j = 0; j < steps; ++j)
      for (unsigned k = 0; j + k < steps; ++k) {
        add(k + 1. / 3, j + 1. / 3);
        if (j + k + 2 <= steps) add(k + 2. / 3, j + 2. / 3);
      }
  });
  const auto heights = [&](const Triangulation& t, const Array<Point2>& xy, const Array<double>& z) {
    Locations where;
    where.kind.assign(points.size(), Location::Kind::none);
    where.id.assign(points.size(), no_index);
    for (std::size_t i = 0; i < points.size(); ++i) {
      double best = -HUGE_VAL;
      for (Index k = 0; k < t.real; ++k) {
        const auto& v = t.triangles[k].v;
        const double least =
            std::min({triangle_area(points[i], xy[v[1]], xy[v[2]]), triangle_area(xy[v[0]], points[i], xy[v[2]]),
                      triangle_area(xy[v[0]], xy[v[1]], points[i])});
        if (least > best) best = least, where.id[i] = k;
      }
      where.kind[i] = Location::Kind::triangle;
    }
    return interpolate_smooth(where, points, t, xy, z, {});
  };
  const Array<double> z1 = heights(p.meshes.scan[0].t, p.meshes.scan[0].field.xy, p.meshes.scan[0].field.z),
                      z2 = heights(p.meshes.scan[1].t, p.meshes.scan[1].field.xy, p.meshes.scan[1].field.z);
  Volume v;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double d = z2[i] - z1[i];
    (d > 0 ? v.above : v.below) += areas[i] * std::fabs(d);
  }
  v.net = v.above - v.below, v.absolute = v.above + v.below;
  return v;
}

double largest_difference(const Volume& v, const Volume& w) {
  return std::max({std::fabs(v.above - w.above), std::fabs(v.below - w.below), std::fabs(v.net - w.net),
                   std::fabs(v.absolute - w.absolute)});
}
Volume sum(const Volume& v, const Volume& w) {
  return {v.above + w.above, v.below + w.below, v.net + w.net, v.absolute + w.absolute};
}

TEST(Bend, IsThatOfDenseQuadrature) {
  const int pairs = 100;
  int bounded = 0;
  double left = 0, all = 0, bounds = 0;
  for (int i = 0; i < pairs; ++i) {
    const Compared p = wavy_pair(16 + static_cast<std::size_t>(i) % 30, 500 + static_cast<std::uint64_t>(i));
    const Volume truth = dense(p, 16), of_cells = p.c.measures.volume;
    const BendError e = bend(p);
    const double error = largest_difference(truth, of_cells);
    bounded += error <= e.bound ? 1 : 0;
    left += largest_difference(truth, sum(of_cells, e.correction));
    all += error, bounds += e.bound;
    EXPECT_EQ(p.c.measures.error_estimate, e.bound / p.c.domain_area);
  }
  EXPECT_GE(bounded, 99);
  EXPECT_LT(left, 0.04 * all) << "the correction is not what the cells leave out";
  EXPECT_LT(bounds, 2 * all) << "the bound is no use";
}

TEST(Bend, OfDrawnCellsBoundsThatOfAll) {
  int bounded = 0, draws = 0;
  double bounds = 0, bounds_of_all = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Compared p = wavy_pair(400, seed);
    const SmoothPair smooth(p.meshes);
    const BendError all = bend_error(p.c.cells.view(), smooth.s1, smooth.s2, {});
    for (int i = 0; i < 30; ++i, ++draws) {
      Context context;
      context.seed = 1000 * seed + static_cast<std::uint64_t>(i);
      const BendError drawn = bend_error(p.c.cells.view(), smooth.s1, smooth.s2, context, 200);
      bounded += largest_difference(all.correction, {}) <= drawn.bound ? 1 : 0;
      bounds += drawn.bound, bounds_of_all += all.bound;
    }
  }
  EXPECT_GE(bounded, 0.99 * draws);
  EXPECT_LT(bounds, 4 * bounds_of_all) << "of an eighth of the cells: the bound is no use";
}

TEST(Bend, IsNoneOfPlanesNorOfLinearInterpolation) {
  const auto plane = [](const Point2& p) { return 2 * p.x - p.y; };
  const auto other = [](const Point2& p) { return p.x + p.y - 0.4; };
  const Cloud a = cloud_over(uniform(300, 1), plane), b = cloud_over(uniform(400, 2), other);
  const Compared p = compared(a, b);
  EXPECT_LT(p.c.measures.error_estimate, 1e-11);
  const auto bent = [](const Point2& q) { return q.x * q.x; };
  CompareOptions linear = cubic_options();
  EXPECT_GT(compared(a, cloud_over(uniform(400, 2), bent)).c.measures.error_estimate, 1e-4);
  linear.interpolation = Interpolation::linear;
  EXPECT_EQ(compare(a, cloud_over(uniform(400, 2), bent), linear, {}).measures.error_estimate, 0);
}

// With more cells than are drawn.
TEST(Bend, KeepsTheLawsOfAComparison) {
  const auto f1 = [](const Point2& p) { return std::sin(20 * p.x) * std::cos(30 * p.y); };
  const auto f2 = [&](const Point2& p) { return f1(p) + 0.2 * (p.x - 0.4); };
  const Cloud a = cloud_over(uniform(9000, 5), f1), b = cloud_over(uniform(7000, 6), f2);
  const CompareOptions o = cubic_options();
  const Compared there = compared(a, b), back = compared(b, a);
  EXPECT_GT(there.c.measures.error_estimate, 0);
  EXPECT_EQ(there.c.measures.error_estimate, back.c.measures.error_estimate);
  const BendError e = bend(there), f = bend(back);
  EXPECT_EQ(e.correction.above, f.correction.below);
  EXPECT_EQ(e.correction.below, f.correction.above);
  EXPECT_EQ(e.correction.net, -f.correction.net);
  // T may be numbered otherwise: of few cells all count.
  const Cloud few_a = cloud_over(uniform(900, 7), f1), few_b = cloud_over(uniform(700, 8), f2);
  const double of_few = compare(few_a, few_b, o, {}).measures.error_estimate;
  for (const LocateMethod method : {LocateMethod::tree, LocateMethod::interface}) {
    CompareOptions other = o;
    other.locate = method;
    EXPECT_NEAR(compare(few_a, few_b, other, {}).measures.error_estimate, of_few, 1e-12 * of_few);
  }
  Context seven;
  seven.threads = 7;
  const Comparison again = compare(shuffled(a, 1), shuffled(b, 2), o, seven);
  EXPECT_EQ(again.measures.error_estimate, there.c.measures.error_estimate);
  EXPECT_EQ(again.measures.rho, there.c.measures.rho);
}

TEST(Bend, IsFoundOverHullsThatDifferAndGrids) {
  CompareOptions o = cubic_options();
  const auto bowl = [](const Point2& p) { return p.x * p.x + p.y * p.y; };
  Points wide = uniform(300, 9);
  for (Point2& p : wide) p = {1.5 * p.x - 0.4, 1.2 * p.y};
  o.domain = DomainKind::hull;
  const Comparison c = compare(cloud_over(uniform(200, 8), bowl), cloud_over(wide, bowl), o, {});
  EXPECT_TRUE(std::isfinite(c.measures.error_estimate));
  EXPECT_GT(c.measures.error_estimate, 0);
  const Cloud g = cloud_over(grid(400, 1), bowl);
  EXPECT_LT(compare(g, g, cubic_options(), {}).measures.error_estimate, 1e-12);
}

}  // namespace
}  // namespace isopach::test
