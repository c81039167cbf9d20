// The border rule in whole comparisons: slivers, rings, both domains, what is reported as trimmed, real survey.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "isopach/compare/compare.hpp"
#include "isopach/io/read.hpp"
#include "isopach/measure/source.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach::test {
namespace {

constexpr double pi = 3.14159265358979324;

Comparison compare_with(BorderRule border, const Cloud& a, const Cloud& b, DomainKind domain = DomainKind::overlap,
                        double max_edge = 0) {
  CompareOptions options;
  options.border = border;
  options.domain = domain;
  options.max_edge = max_edge;
  options.check_layers = false;
  return compare(a, b, options, {});
}

// Uniform in a square of side 1000, and its corners: no other point on its border.
Points square_with_corners(std::size_t n, std::uint64_t seed) {
  Points points = uniform(n, seed);
  points.insert(points.end(), {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  for (Point2& p : points) p = {1000 * p.x, 1000 * p.y};
  return points;
}

Points ring(std::size_t n, std::uint64_t seed) {
  Points points;
  for (const Point2& p : uniform(4 * n, seed)) {
    const double r = std::hypot(p.x - 0.5, p.y - 0.5);
    if (r < 0.5 && r > 0.25 && points.size() < n) points.push_back(p);
  }
  return points;
}

struct FalseCut {
  double of_domain;  // measured cut beyond the true one over the same cells, as a share of it
  double area;
};
FalseCut false_cut(const Comparison& c, const Height& true_d) {
  double cut = 0;
  for_common(c.cells.view(), [&](const CommonCell& common) {
    Cell cell = common.cell();
    for (std::size_t k = 0; k < 3; ++k) cell.d[k] = true_d({common.corner(k).x, common.corner(k).y});
    cut += split_volume(cell).below;
  });
  return {c.measures.volume.below / cut - 1, c.domain_area};
}

TEST(CompareBorder, TrimTakesTheFalseCutAwayThatSliversAlongTheHullMake) {
  const Height relief = [](const Point2& p) { return 20 * std::sin(p.x / 60) * std::cos(p.y / 80); };
  const Height change = [](const Point2& p) { return 0.002 * (p.x - 250); };
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Cloud a = cloud_over(square_with_corners(100000, seed), relief);
    const Cloud b =
        cloud_over(square_with_corners(100000, seed + 10), [&](const Point2& p) { return relief(p) + change(p); });
    const Comparison hull = compare_with(BorderRule::hull, a, b), trim = compare_with(BorderRule::trim, a, b);
    const Height in_frame = [&](const Point2& p) { return change({p.x + hull.frame.origin.x, 0}); };
    const FalseCut over_hull = false_cut(hull, in_frame), over_trim = false_cut(trim, in_frame);
    EXPECT_GT(over_hull.of_domain, 0.02) << "the slivers are there";
    EXPECT_LT(std::fabs(over_trim.of_domain), 0.003);
    EXPECT_GT(over_trim.area, 0.99 * 1e6);
  }
}

TEST(CompareBorder, RingsAreComparedAsRings) {
  const Cloud a = rough_cloud(ring(30000, 1), 2), b = rough_cloud(ring(20000, 3), 4);
  const Comparison c = compare_with(BorderRule::trim, a, b);
  const double truth = pi * (0.25 - 0.0625);
  EXPECT_NEAR(c.domain_area, truth, 0.03 * truth) << "three rims: of A, of B, of cells";
  EXPECT_GT(c.coverage, 0.96);
  const CellView cells = c.cells.view();
  double in_hole = 0;
  for (Index i = 0; i < cells.t.real; ++i) {
    if (cells.in_domain[i] == 0) continue;
    const auto& v = cells.t.triangles[i].v;
    const double x = (cells.xy[v[0]].x + cells.xy[v[1]].x + cells.xy[v[2]].x) / 3 + c.frame.origin.x - 0.5;
    const double y = (cells.xy[v[0]].y + cells.xy[v[1]].y + cells.xy[v[2]].y) / 3 + c.frame.origin.y - 0.5;
    if (std::hypot(x, y) < 0.24) in_hole += cell_at(cells, i).area;
  }
  EXPECT_LT(in_hole, 1e-4 * truth);
  for (std::size_t i = 0; i < a.points.size(); ++i) {  // a field is known nearly everywhere, both are rings
    const double r = std::hypot(a.points[i].x - 0.5, a.points[i].y - 0.5);
    EXPECT_FALSE(r > 0.27 && r < 0.48 && std::isnan(c.fields_a.dz_signed[i])) << r;
  }
}

TEST(CompareBorder, PointsOverAGapOfTheOtherScanHaveNoDifference) {
  const Cloud full = rough_cloud(framed_square(5000, 5), 6), holed = rough_cloud(ring(5000, 7), 8);
  const Comparison c = compare_with(BorderRule::trim, full, holed);
  for (std::size_t i = 0; i < full.points.size(); ++i) {
    const double r = std::hypot(full.points[i].x - 0.5, full.points[i].y - 0.5);
    EXPECT_TRUE(r >= 0.2 || std::isnan(c.fields_a.dz_signed[i])) << r;
  }
}

TEST(CompareBorder, ASelfComparisonCoversItsFootprint) {
  const Cloud a = rough_cloud(ring(5000, 9), 10);
  const Comparison c = compare_with(BorderRule::trim, a, a);
  EXPECT_NEAR(c.coverage, 1, 1e-9);
  EXPECT_LT(c.domain_area, 0.7);
  EXPECT_GT(c.trimmed_area, 0.2);
}

TEST(CompareBorder, WhatIsKeptAndWhatIsTrimmedAddUp) {
  const Cloud a = rough_cloud(ring(3000, 11), 12), b = rough_cloud(uniform(3000, 13), 14);
  for (const DomainKind domain : {DomainKind::overlap, DomainKind::hull})
    for (const double max_edge : {0.0, 0.03}) {
      const Comparison hull = compare_with(BorderRule::hull, a, b, domain);
      const Comparison trim = compare_with(BorderRule::trim, a, b, domain, max_edge);
      EXPECT_GT(trim.trimmed_area, 0);
      EXPECT_GT(trim.trimmed_volume, 0);
      EXPECT_NEAR(trim.trimmed_area, 1 - trim.domain_area / hull.domain_area, 1e-12);
      // Over the overlap a cell that the footprint's border cuts has the border's heights there, where over the hulls
      // it is one plane.
      EXPECT_NEAR(trim.trimmed_volume, 1 - trim.measures.volume.absolute / hull.measures.volume.absolute,
                  domain == DomainKind::hull ? 1e-12 : 0.01);
      EXPECT_EQ(hull.trimmed_area, 0);
      EXPECT_EQ(hull.trimmed_volume, 0);
      for (std::size_t i = 0; i < hull.cells.in_domain.size(); ++i)
        ASSERT_LE(trim.cells.in_domain[i], hull.cells.in_domain[i]);
    }
}

TEST(CompareBorder, OverTheHullIsTheUnionOfBothFootprints) {
  const Cloud a = rough_cloud(framed_square(4000, 15), 16);
  const Cloud b = shifted(rough_cloud(framed_square(4000, 17), 18), {0.5, 0, 0}), apart = shifted(a, {3, 0, 0});
  const Comparison side_by_side = compare_with(BorderRule::trim, a, b, DomainKind::hull);
  EXPECT_NEAR(side_by_side.domain_area, 1.5, 0.01);
  EXPECT_EQ(side_by_side.coverage, 1);
  EXPECT_NEAR(compare_with(BorderRule::trim, a, apart, DomainKind::hull).domain_area, 2, 0.01);
  EXPECT_NEAR(compare_with(BorderRule::hull, a, apart, DomainKind::hull).domain_area, 4, 1e-9)
      << "Conv(g), the paper's";
}

TEST(CompareBorder, ThinningBothScansMovesTheDomainLittle) {
  const Cloud a = rough_cloud(ring(40000, 19), 20), b = rough_cloud(ring(40000, 21), 22);
  const auto half = [](const Cloud& cloud) {
    Cloud thin;
    for (std::size_t i = 0; i < cloud.points.size(); i += 2) thin.points.push_back(cloud.points[i]);
    return thin;
  };
  const double area = compare_with(BorderRule::trim, a, b).domain_area;
  EXPECT_NEAR(compare_with(BorderRule::trim, half(a), half(b)).domain_area, area, 0.02 * area);
}

TEST(CompareBorder, RefusesALongestEdgeThatIsNoLength) {
  const Cloud a = rough_cloud(framed_square(100, 23), 24);
  for (const double wrong : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) try {
      (void)compare_with(BorderRule::trim, a, a, DomainKind::overlap, wrong);
      ADD_FAILURE() << wrong;
    } catch (const UsageError& e) {
      EXPECT_NE(std::string(e.what()).find("@max-edge"), std::string::npos);
    }
  try {
    (void)compare_with(BorderRule::trim, a, a, DomainKind::overlap, 1e-6);
    ADD_FAILURE() << "nothing is left";
  } catch (const OverlapError& e) {
    EXPECT_NE(std::string(e.what()).find("@max-edge"), std::string::npos);
  }
}

// 191 092 m² and +3.997·10⁶ m³: over the grid squares whose four corners both surveys hold.
TEST(CompareBorder, SaintHelensDomeIsMeasuredWhereBothSurveysAre) {
  ISOPACH_SHARED_OR_SKIP(folder, "msh-dome");
  const Comparison c = compare(read_cloud((folder / "msh_2004-10-04.xyz").string(), {}, {}),
                               read_cloud((folder / "msh_2004-10-11.xyz").string(), {}, {}), {}, {});
  EXPECT_NEAR(c.domain_area, 191092, 0.01 * 191092);
  EXPECT_NEAR(c.measures.volume.net, 3.997e6, 0.01 * 3.997e6);
  EXPECT_NEAR(c.trimmed_area, 1 - 191092.0 / 207936, 0.01);
}

}  // namespace
}  // namespace isopach::test
