// The generators are what their names say: extent, mean, duplicates, ties. A test on the wrong distribution proves
// nothing.
#include "tests/support/points.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/oracle.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

constexpr std::size_t n = 2000;

Box2 extent(const Points& points) {
  Box2 box;
  for (const Point2& p : points) box.add(p);
  return box;
}
Point2 mean(const Points& points) {
  Point2 sum{0, 0};
  for (const Point2& p : points) sum = {sum.x + p.x, sum.y + p.y};
  return {sum.x / static_cast<double>(points.size()), sum.y / static_cast<double>(points.size())};
}
std::size_t duplicates(const Points& points) { return points.size() - distinct(points).size(); }
double width(const Box2& box) { return box.max.x - box.min.x; }
double height(const Box2& box) { return box.max.y - box.min.y; }
bool all_collinear(const Points& points) {
  for (std::size_t i = 2; i < points.size(); ++i)
    if (exact_orientation(points[0], points[1], points[i]) != 0) return false;
  return true;
}

TEST(Random, UniformHasTheMomentsOfUniformAndBellThoseOfABell) {
  Random random(1);
  double sum = 0, squares = 0, bells = 0, bell_squares = 0;
  for (int i = 0; i < 100000; ++i) {
    const double u = random.uniform(), b = random.bell();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    sum += u, squares += u * u, bells += b, bell_squares += b * b;
  }
  EXPECT_NEAR(sum / 1e5, 0.5, 0.005);
  EXPECT_NEAR(squares / 1e5, 1.0 / 3, 0.005);
  EXPECT_NEAR(bells / 1e5, 0, 0.02);
  EXPECT_NEAR(bell_squares / 1e5, 1, 0.03);
}

TEST(Random, SeedsGiveDifferentAndRepeatableNumbers) {
  EXPECT_EQ(Random(7).bits(), Random(7).bits());
  EXPECT_NE(Random(7).bits(), Random(8).bits());
  Random a(7);
  EXPECT_NE(a.bits(), a.bits());
}

class FamilyTest : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, FamilyTest, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(FamilyTest, IsAFunctionOfCountAndSeed) {
  for (const std::size_t count : {0, 1, 2, 3, 10, 500}) {
    const Points points = GetParam().make(count, 3);
    EXPECT_EQ(points, GetParam().make(count, 3));
    EXPECT_LE(points.size(), count);
    EXPECT_GE(points.size(), count * 4 / 5 - (count == 3 ? 1 : 0));
    for (const Point2& p : points) EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y));
  }
}

TEST_P(FamilyTest, CollinearMeansCollinear) { EXPECT_EQ(GetParam().collinear, all_collinear(GetParam().make(500, 3))); }

TEST(Families, UniformFillsTheUnitSquareEvenly) {
  const Points points = uniform(n, 5);
  const Box2 box = extent(points);
  EXPECT_GE(box.min.x, 0);
  EXPECT_LT(box.max.y, 1);
  EXPECT_GT(width(box), 0.99);
  EXPECT_GT(height(box), 0.99);
  EXPECT_NEAR(mean(points).x, 0.5, 0.03);
  EXPECT_NEAR(mean(points).y, 0.5, 0.03);
  EXPECT_EQ(duplicates(points), 0u);
  EXPECT_NE(points, uniform(n, 6));
}

TEST(Families, SortedByXIsSorted) {
  const Points points = sorted_by_x(n, 5);
  EXPECT_TRUE(std::is_sorted(points.begin(), points.end(), lexicographic_less));
  EXPECT_EQ(distinct(points), distinct(uniform(n, 5)));
}

TEST(Families, GridIsTheIntegersInRowOrder) {
  const Points points = grid(n, 0);
  ASSERT_EQ(points.size(), 44u * 44u);
  EXPECT_EQ(points[1], (Point2{1, 0}));
  EXPECT_EQ(points[44], (Point2{0, 1}));
  EXPECT_EQ(points.back(), (Point2{43, 43}));
  EXPECT_EQ(duplicates(points), 0u);
}

TEST(Families, RotatedGridHasUnitCellsMostOfThemNotExactTies) {
  const Points points = rotated_grid(n, 0);
  std::size_t ties = 0, cells = 0;
  for (std::size_t row = 0; row < 43; ++row)
    for (std::size_t column = 0; column < 43; ++column, ++cells) {
      const std::size_t i = 44 * row + column;
      EXPECT_NEAR(std::hypot(points[i + 1].x - points[i].x, points[i + 1].y - points[i].y), 1, 1e-13);
      ties += exact_in_circle(points[i], points[i + 1], points[i + 45], points[i + 44]) == 0;
    }
  EXPECT_LT(ties, cells / 2);  // some are: rounding leaves many cells their symmetry
}

TEST(Families, NearDegenerateIsOneUlpFromTheGrid) {
  const Points points = near_degenerate(n, 5);
  const Points exact = grid(n, 5);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = exact[i].x + 1;
    EXPECT_GE(points[i].x, std::nextafter(x, 0));
    EXPECT_LE(points[i].x, std::nextafter(x, 1e9));
    moved += points[i].x != x;
  }
  EXPECT_NEAR(static_cast<double>(moved), static_cast<double>(points.size()) * 2 / 3, 100);
}

TEST(Families, NearlyDiagonalIsCollinearButForTheLastBit) {
  const Points points = nearly_diagonal(n, 5);
  std::size_t off = 0;
  for (std::size_t i = 2; i < points.size(); ++i) {
    EXPECT_NEAR(points[i].y, points[i].x / 3, 1e-12);
    off += exact_orientation(points[0], points[1], points[i]) != 0;
  }
  EXPECT_GT(off, n / 4);
  EXPECT_EQ(duplicates(points), 0u);
}

TEST(Families, FewLinesLieOnFourLines) {
  for (const Point2& p : few_lines(n, 5)) EXPECT_TRUE(p.x == 0 || p.y == 0 || p.y == 7 || p.y == 14);
}

TEST(Families, CocircularPointsShareOneCircleExactly) {
  for (const std::size_t count : {12, 100, 2000}) {
    const Points points = cocircular(count, 5);
    EXPECT_EQ(points.size(), count);
    EXPECT_EQ(duplicates(points), 0u);
    for (std::size_t i = 3; i < points.size(); ++i)
      EXPECT_EQ(exact_in_circle(points[0], points[1], points[2], points[i]), 0);
  }
  EXPECT_EQ(cocircular(100000, 5).size(), 8748u);
}

TEST(Families, ConcentricPointsLieOnCirclesOfMultipleRadii) {
  const Points points = concentric(120, 5);
  EXPECT_EQ(duplicates(points), 0u);
  for (const Point2& p : points) {
    const double ratio = std::hypot(p.x, p.y) / 5;
    EXPECT_EQ(ratio, std::round(ratio));
  }
}

TEST(Families, ClustersAreMuchDenserThanTheirSurroundings) {
  const Points points = clustered(n, 5);
  EXPECT_EQ(duplicates(points), 0u);
  EXPECT_GT(width(extent(points)), 300);
  const Points ordered = distinct(points);
  std::size_t close = 0;
  for (std::size_t i = 1; i < ordered.size(); ++i) close += ordered[i].x - ordered[i - 1].x < 1e-3;
  EXPECT_GT(close, n / 4);
}

TEST(Families, ScanLinesAreRoundedAndHoldAboutOnePercentDuplicates) {
  const Points points = scan_lines(20000, 5);
  for (const Point2& p : points) EXPECT_EQ(p.x, std::round(p.x * 100) / 100);
  EXPECT_GT(duplicates(points), 120u);
  EXPECT_LT(duplicates(points), 400u);
  EXPECT_NEAR(mean(points).x, 1000 + 35, 1);
}

TEST(Families, FarOutlierHasExactlyOne) {
  std::size_t far = 0;
  for (const Point2& p : far_outlier(n, 5)) far += p.x > 1;
  EXPECT_EQ(far, 1u);
}

TEST(Families, UtmIsInMillimetresAtItsOffset) {
  const Points points = utm(n, 5);
  EXPECT_NEAR(mean(points).x, 600500, 30);
  EXPECT_NEAR(mean(points).y, 5000500, 30);
  for (const Point2& p : points) EXPECT_NEAR(p.y * 1000, std::round(p.y * 1000), 1e-5);
}

TEST(Families, StripHugeAndTinyHaveTheirExtents) {
  const Box2 strip = extent(thin_strip(n, 5)), large = extent(huge(n, 5)), small = extent(tiny(n, 5));
  EXPECT_NEAR(width(strip) / height(strip), 1000, 10);
  EXPECT_NEAR(width(large), 1e6, 1e4);
  EXPECT_NEAR(height(small), 1e-6, 1e-8);
}

TEST(Families, CoarseLatticeHasDuplicates) {
  const Points points = coarse_lattice(n, 5);
  EXPECT_GT(duplicates(points), n / 5);
  for (const Point2& p : points) EXPECT_EQ(p.x, std::floor(p.x));
}

}  // namespace
}  // namespace isopach::test
