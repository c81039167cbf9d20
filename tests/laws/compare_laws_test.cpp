// Laws of a whole comparison: it equals the oracle; self = 0; swapping mirrors; planes, paraboloid and cone come out
// right; order of points, threads and offsets do not matter.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "isopach/compare/compare.hpp"
#include "isopach/delaunay/validate.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/oracle.hpp"

namespace isopach::test {
namespace {

CompareOptions over(DomainKind domain) {
  CompareOptions options;
  options.domain = domain;
  options.border = BorderRule::hull;  // the oracles integrate over convex hulls
  options.check_layers = false;
  return options;
}
Comparison compare_over(DomainKind domain, const Cloud& a, const Cloud& b, const Context& context = {}) {
  return compare(a, b, over(domain), context);
}
constexpr DomainKind both_domains[] = {DomainKind::overlap, DomainKind::hull};

BruteSurface surface_of(const Cloud& cloud) {
  Points xy;
  std::vector<double> z;
  for (const Point3& p : cloud.points) {
    xy.push_back({p.x, p.y});
    z.push_back(p.z);
  }
  return brute_surface(xy, z);
}

void expect_same_bits(const Comparison& c, const Comparison& expected) {
  EXPECT_EQ(c.domain_area, expected.domain_area);
  EXPECT_EQ(c.area_union, expected.area_union);
  EXPECT_EQ(c.coverage, expected.coverage);
  EXPECT_EQ(c.measures.rho, expected.measures.rho);
  EXPECT_EQ(c.measures.volume.above, expected.measures.volume.above);
  EXPECT_EQ(c.measures.volume.below, expected.measures.volume.below);
  EXPECT_EQ(c.measures.difference.rms, expected.measures.difference.rms);
  EXPECT_EQ(c.measures.difference.median, expected.measures.difference.median);
  EXPECT_EQ(c.measures.difference.nmad, expected.measures.difference.nmad);
  EXPECT_EQ(c.measures.difference.abs_percentiles, expected.measures.difference.abs_percentiles);
  EXPECT_EQ(c.measures.difference.histogram.areas, expected.measures.difference.histogram.areas);
  EXPECT_EQ(c.visited_1_in_2, expected.visited_1_in_2);
  EXPECT_EQ(c.cells.xy, expected.cells.xy);
  EXPECT_EQ(c.cells.z1, expected.cells.z1);
  EXPECT_EQ(c.cells.z2, expected.cells.z2);
  EXPECT_EQ(c.cells.in_domain, expected.cells.in_domain);
  EXPECT_TRUE(same_bytes(c.cells.triangulation, expected.cells.triangulation));
}

class CompareFamilies : public testing::TestWithParam<Family> {
 protected:
  static Points make(std::size_t n, std::uint64_t seed) { return GetParam().make(n, seed); }
  static Cloud rough(std::size_t n, std::uint64_t seed) { return rough_cloud(distinct(make(n, seed)), seed); }
};
INSTANTIATE_TEST_SUITE_P(All, CompareFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(CompareFamilies, EqualsTheOracle) {
  if (GetParam().collinear) {
    EXPECT_THROW((void)compare_over(DomainKind::overlap, rough(20, 1), rough(25, 2)), OverlapError);
    return;
  }
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    for (const DomainKind domain : both_domains) {
      const Cloud a = rough(14, 200 + seed), b = rough(19, 300 + seed);
      const Parts expected = brute_common_measure(surface_of(a), surface_of(b), domain == DomainKind::hull);
      const double area = static_cast<double>(expected.area);
      Comparison c;
      try {
        c = compare_over(domain, a, b);
      } catch (const OverlapError&) {
        EXPECT_EQ(area, 0) << "seed " << seed;
        continue;
      }
      // Areas of cells are rounded: what is lost is small beside the box, not beside a domain of slivers.
      Box2 box;
      for (const Point2& p : c.cells.xy) box.add(p);
      const double tolerance = 1e-7 * area + 1e-15 * (box.max.x - box.min.x) * (box.max.y - box.min.y);
      EXPECT_NEAR(c.domain_area, area, std::max(1e-10 * area, tolerance - 1e-7 * area)) << "seed " << seed;
      EXPECT_NEAR(c.measures.volume.above, static_cast<double>(expected.above), tolerance) << "seed " << seed;
      EXPECT_NEAR(c.measures.volume.below, static_cast<double>(expected.below), tolerance) << "seed " << seed;
      EXPECT_EQ(validate(c.cells.triangulation, c.cells.xy).value_or("valid"), "valid");
    }
}

TEST_P(CompareFamilies, SelfIsExactlyZero) {
  if (GetParam().collinear) return;
  for (const DomainKind domain : both_domains) {
    const Cloud a = rough_cloud(make(2000, 141), 142);  // duplicates included
    const Comparison c = compare_over(domain, a, shuffled(a, 143));
    EXPECT_EQ(c.measures.rho, 0);
    EXPECT_EQ(c.measures.volume.absolute, 0);
    EXPECT_EQ(c.measures.difference.max_above, 0);
    EXPECT_EQ(c.measures.difference.max_below, 0);
    EXPECT_NEAR(c.coverage, 1, 1e-9);
    EXPECT_EQ(c.interface, 0u);
    EXPECT_EQ(c.common, c.t1);
  }
}

TEST_P(CompareFamilies, SwappingMirrorsToTheLastBit) {
  if (GetParam().collinear) return;
  for (const DomainKind domain : both_domains) {
    const Cloud a = rough(1500, 144), b = rough(1800, 145);
    const Comparison ab = compare_over(domain, a, b), ba = compare_over(domain, b, a);
    EXPECT_EQ(ba.measures.volume.above, ab.measures.volume.below);
    EXPECT_EQ(ba.measures.volume.below, ab.measures.volume.above);
    EXPECT_EQ(ba.measures.rho, ab.measures.rho);
    EXPECT_EQ(ba.measures.difference.mean, -ab.measures.difference.mean);
    EXPECT_EQ(ba.measures.difference.rms, ab.measures.difference.rms);
    // Quantiles come from sums of areas, which are as good as the areas: slivers of one ulp have none worth the name.
    for (std::size_t i = 0; i < 4 && GetParam().name != "nearly_diagonal"; ++i)
      EXPECT_NEAR(ba.measures.difference.abs_percentiles[i], ab.measures.difference.abs_percentiles[i], 1e-9);
    EXPECT_EQ(ba.domain_area, ab.domain_area);
    EXPECT_EQ(ba.area_union, ab.area_union);
    EXPECT_EQ(ba.coverage, ab.coverage);
    EXPECT_EQ(ba.interface, ab.interface);
    EXPECT_EQ(ba.visited_1_in_2, ab.visited_2_in_1);
    EXPECT_EQ(ba.fields_a.dz_signed.size(), ab.fields_b.dz_signed.size());
    for (std::size_t i = 0; i < ba.fields_a.dz_signed.size(); ++i) {
      const double there = ab.fields_b.dz_signed[i], back = ba.fields_a.dz_signed[i];
      EXPECT_TRUE(back == -there || (std::isnan(back) && std::isnan(there))) << i;
    }
  }
}

TEST_P(CompareFamilies, ShufflingAndThreadsChangeNoBit) {
  if (GetParam().collinear) return;
  const Cloud a = rough_cloud(make(15000, 146), 147), b = rough_cloud(make(12000, 148), 149);
  const Comparison expected = compare_over(DomainKind::overlap, a, b);
  expect_same_bits(compare_over(DomainKind::overlap, shuffled(a, 150), shuffled(b, 151)), expected);
  for (const int threads : {1, 2, 7}) {
    Context context;
    context.threads = threads;
    const Comparison c = compare_over(DomainKind::overlap, a, b, context);
    expect_same_bits(c, expected);
    for (const auto& [found, other] : {std::pair{&c.fields_a, &expected.fields_a}, {&c.fields_b, &expected.fields_b}})
      for (std::size_t i = 0; i < found->dz_signed.size(); ++i) {
        const double x = found->dz_signed[i], y = other->dz_signed[i];
        ASSERT_TRUE(x == y || (std::isnan(x) && std::isnan(y)));
      }
  }
}

TEST_P(CompareFamilies, ALiftedSurfaceGivesLiftTimesArea) {
  if (GetParam().collinear) return;
  const Cloud a = rough(3000, 152);
  const Comparison c = compare_over(DomainKind::overlap, a, shifted(a, {0, 0, 0.5}));
  EXPECT_NEAR(c.measures.volume.above, 0.5 * c.domain_area, 1e-13 * c.domain_area);
  EXPECT_EQ(c.measures.volume.below, 0);
  EXPECT_NEAR(c.measures.difference.std, 0, 1e-7);
  for (const double percentile : c.measures.difference.abs_percentiles) EXPECT_NEAR(percentile, 0.5, 1e-15);
}

TEST_P(CompareFamilies, APlaneLiftedBetweenDifferentNodesGivesLiftTimesArea) {
  if (GetParam().collinear || GetParam().name == "nearly_diagonal") return;
  const Points nodes_a = make(3000, 153), nodes_b = make(2500, 154);
  Box2 box;
  for (const Point2& p : nodes_a) box.add(p);
  const auto plane = [&](const Point2& p) {
    return 3 * (p.x - box.min.x) / (box.max.x - box.min.x) - 2 * (p.y - box.min.y) / (box.max.y - box.min.y);
  };
  const Comparison c = compare_over(DomainKind::overlap, cloud_over(nodes_a, plane),
                                    cloud_over(nodes_b, [&](const Point2& p) { return plane(p) + 0.25; }));
  EXPECT_NEAR(c.measures.volume.above, 0.25 * c.domain_area, 1e-10 * c.domain_area);
  EXPECT_EQ(c.measures.volume.below, 0);
}

TEST_P(CompareFamilies, TheMeasureObeysTheTriangleInequalityOnOneNodeSet) {
  if (GetParam().collinear) return;
  const Points nodes = distinct(make(1000, 155));
  const Cloud a = rough_cloud(nodes, 156), b = rough_cloud(nodes, 157), c = rough_cloud(nodes, 158);
  const auto volume = [](const Cloud& p, const Cloud& q) {
    return compare_over(DomainKind::hull, p, q).measures.volume.absolute;
  };
  EXPECT_LE(volume(a, c), volume(a, b) + volume(b, c));
  EXPECT_LE(volume(a, b), volume(a, c) + volume(c, b));
  EXPECT_GT(volume(a, b), 0);
}

// Without duplicates: a mean of heights is rounded, and a shift changes how.
TEST_P(CompareFamilies, LargeOffsetsChangeNothing) {
  if (GetParam().collinear) return;
  Points nodes_a, nodes_b;
  Box2 box;
  for (const Point2& p : make(2000, 159)) box.add(p);
  // Coordinates on a grid that the offset still resolves.
  const double unit = std::exp2(std::ceil(std::log2(std::max(box.max.x - box.min.x, box.max.y - box.min.y))) - 20);
  const auto snapped = [&](Points points) {
    for (Point2& p : points) p = {std::round(p.x / unit) * unit, std::round(p.y / unit) * unit};
    return distinct(points);
  };
  const Cloud a = rough_cloud(snapped(make(2000, 159)), 160), b = rough_cloud(snapped(make(2200, 161)), 162);
  const Comparison here = compare_over(DomainKind::overlap, a, b);
  const Point3 offset{unit * 0x1p40 * 5, -unit * 0x1p40 * 3, 1000};
  const Comparison there = compare_over(DomainKind::overlap, shifted(a, offset), shifted(b, offset));
  EXPECT_EQ(there.common, here.common);
  EXPECT_EQ(there.interface, here.interface);
  EXPECT_NEAR(there.domain_area, here.domain_area, 1e-12 * here.domain_area);
  EXPECT_NEAR(there.measures.rho, here.measures.rho, 1e-9);
  EXPECT_NEAR(there.measures.volume.net, here.measures.volume.net, 1e-9 * here.domain_area);
}

TEST_P(CompareFamilies, PointFieldsAgreeWithTheCells) {
  if (GetParam().collinear) return;
  const Cloud a = rough(800, 163), b = rough(900, 164);
  const Comparison c = compare_over(DomainKind::hull, a, b);
  for (const auto& [cloud, fields] : {std::pair{&a, &c.fields_a}, std::pair{&b, &c.fields_b}}) {
    ASSERT_EQ(fields->dz_signed.size(), cloud->points.size());
    std::size_t known = 0;
    for (std::size_t i = 0; i < cloud->points.size(); ++i) {
      const Point3 q = c.frame.to_field(cloud->points[i]);
      const auto node = static_cast<std::size_t>(std::find(c.cells.xy.begin(), c.cells.xy.end(), Point2{q.x, q.y}) -
                                                 c.cells.xy.begin());
      ASSERT_LT(node, c.cells.xy.size());
      if (std::isnan(fields->dz_signed[i])) continue;
      ++known;
      EXPECT_EQ(fields->dz_signed[i], c.cells.d(static_cast<Index>(node)));
    }
    EXPECT_GT(known, 0u);
  }
}

TEST(CompareLaws, ATiltedPlaneHasItsClosedForm) {
  // d = x − 1/4 over the unit square: below 1/32, above 9/32.
  const Cloud a = cloud_over(framed_square(4000, 165), [](const Point2& p) { return 2 - p.y; });
  const Cloud b = cloud_over(framed_square(3000, 166), [](const Point2& p) { return 1.75 - p.y + p.x; });
  const Comparison c = compare_over(DomainKind::overlap, a, b);
  EXPECT_NEAR(c.domain_area, 1, 1e-12);
  EXPECT_NEAR(c.measures.volume.above, 9.0 / 32, 1e-10);
  EXPECT_NEAR(c.measures.volume.below, 1.0 / 32, 1e-10);
  EXPECT_NEAR(c.measures.rho, 10.0 / 32, 1e-10);
  EXPECT_NEAR(c.measures.difference.mean, 0.25, 1e-10);
  EXPECT_NEAR(c.measures.difference.median, 0.25, 1e-9);
  EXPECT_NEAR(c.measures.difference.max_above, 0.75, 1e-12);
}

double paraboloid_error(std::size_t n) {
  const Comparison c =
      compare_over(DomainKind::overlap, cloud_over(framed_square(n, 167), [](const Point2&) { return 0.0; }),
                   cloud_over(framed_square(n, 168), [](const Point2& p) { return p.x * p.x + p.y * p.y; }));
  EXPECT_GT(c.measures.volume.net, 2.0 / 3) << "chords of a convex function lie above it";
  return c.measures.volume.net - 2.0 / 3;
}

TEST(CompareLaws, AParaboloidConvergesWithOneOverN) {
  const double coarse = paraboloid_error(1000), fine = paraboloid_error(16000);
  EXPECT_LT(coarse, 2e-3);
  EXPECT_LT(fine, coarse / 10);
  EXPECT_GT(fine, coarse / 25);
}

double cone_error(std::size_t n) {
  // On [−1, 1]², d = 1 − 2r: above π/12, net 4 − 8/3 (√2 + ln(1 + √2)).
  const auto centred = [&](std::uint64_t seed) {
    Points points = framed_square(n, seed);
    for (Point2& p : points) p = {2 * p.x - 1, 2 * p.y - 1};
    return points;
  };
  const Comparison c =
      compare_over(DomainKind::overlap, cloud_over(centred(169), [](const Point2&) { return 5.0; }),
                   cloud_over(centred(170), [](const Point2& p) { return 6 - 2 * std::sqrt(p.x * p.x + p.y * p.y); }));
  const double above = 3.14159265358979324 / 12;
  const double net = 4 - 8.0 / 3 * (std::sqrt(2.0) + std::log(1 + std::sqrt(2.0)));
  return std::fabs(c.measures.volume.above - above) + std::fabs(c.measures.volume.below - (above - net));
}

TEST(CompareLaws, AConeConvergesWithOneOverN) {
  const double coarse = cone_error(1000), fine = cone_error(16000);
  EXPECT_LT(coarse, 2e-2);
  EXPECT_LT(fine, coarse / 8);
}

TEST(CompareLaws, DisjointFeaturesAddUp) {
  const auto bump = [](const Point2& p, double x, double y) {
    const double r2 = ((p.x - x) * (p.x - x) + (p.y - y) * (p.y - y)) / 0.01;
    return r2 < 1 ? (1 - r2) * (1 - r2) : 0.0;
  };
  const Points nodes_a = framed_square(4000, 171), nodes_b = framed_square(4000, 172);
  const Cloud flat = cloud_over(nodes_a, [](const Point2&) { return 0.0; });
  const auto above = [&](const Height& z) {
    return compare_over(DomainKind::overlap, flat, cloud_over(nodes_b, z)).measures.volume;
  };
  const Volume first = above([&](const Point2& p) { return bump(p, 0.3, 0.3); });
  const Volume second = above([&](const Point2& p) { return -bump(p, 0.7, 0.6); });
  const Volume together = above([&](const Point2& p) { return bump(p, 0.3, 0.3) - bump(p, 0.7, 0.6); });
  EXPECT_NEAR(together.above, first.above, 1e-14);
  EXPECT_NEAR(together.below, second.below, 1e-14);
  EXPECT_NEAR(first.above, 3.14159265358979324 * 0.01 / 3, 0.03 * first.above);
}

TEST(CompareLaws, CoverageIsSharedOverUnion) {
  const Cloud a = rough_cloud(framed_square(2000, 173), 174);
  const Cloud b = shifted(rough_cloud(framed_square(2000, 175), 176), {0.5, 0, 0});
  const Comparison c = compare_over(DomainKind::overlap, a, b);
  EXPECT_NEAR(c.area_union, 1.5, 1e-9);
  EXPECT_LE(c.domain_area, 0.5 + 1e-12);
  EXPECT_GT(c.domain_area, 0.48) << "cells along the border of the other hull are left out";
  EXPECT_EQ(c.coverage, c.domain_area / c.area_union);
  const Comparison hull = compare_over(DomainKind::hull, a, b);
  EXPECT_NEAR(hull.domain_area, 1.5, 1e-9);
}

}  // namespace
}  // namespace isopach::test
