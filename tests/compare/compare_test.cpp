// Degenerate inputs and what compare says of them; duplicates; points that are no numbers; poses; options.
#include "isopach/compare/compare.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();

Comparison compare_plain(const Cloud& a, const Cloud& b, const CompareOptions& options = {}) {
  return compare(a, b, options, {});
}
Cloud cloud_of(std::initializer_list<Point3> points) {
  Cloud cloud;
  cloud.points.assign(points);
  return cloud;
}
Cloud square(double x, double y, double z) {
  return cloud_of({{x, y, z}, {x + 1, y, z}, {x + 1, y + 1, z}, {x, y + 1, z}});
}

template <class E>
std::string message_of(const Cloud& a, const Cloud& b, const CompareOptions& options = {}) {
  try {
    (void)compare_plain(a, b, options);
  } catch (const E& e) {
    const std::string message = e.what();
    EXPECT_FALSE(message.empty());
    EXPECT_EQ(message.find('\n'), std::string::npos) << "one line: " << message;
    return message;
  }
  ADD_FAILURE() << "no such error";
  return {};
}

TEST(Compare, OfScansWithoutPointsIsAnInputError) {
  message_of<InputError>(Cloud{}, square(0, 0, 0));
  message_of<InputError>(square(0, 0, 0), Cloud{});
  message_of<InputError>(Cloud{}, Cloud{});
  message_of<InputError>(cloud_of({{nan, 0, 0}, {0, nan, 1}}), square(0, 0, 0));
}

TEST(Compare, NamesTheFileInItsErrors) {
  Cloud empty;
  empty.path = "before.xyz";
  EXPECT_NE(message_of<InputError>(empty, square(0, 0, 0)).find("before.xyz"), std::string::npos);
}

TEST(Compare, OfScansThatSpanNoAreaIsAnOverlapError) {
  const Cloud whole = square(0, 0, 0);
  for (const Cloud& thin :
       {cloud_of({{0.5, 0.5, 1}}), cloud_of({{0.2, 0.2, 1}, {0.7, 0.6, 2}}),
        cloud_of({{0, 0, 1}, {0.5, 0.5, 2}, {1, 1, 3}}), cloud_of({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}})})
    for (const DomainKind domain : {DomainKind::overlap}) {
      CompareOptions options;
      options.domain = domain;
      message_of<OverlapError>(thin, whole, options);
      message_of<OverlapError>(whole, thin, options);
      message_of<OverlapError>(thin, thin, options);
    }
}

TEST(Compare, OfDisjointOrTouchingScansIsAnOverlapError) {
  const Cloud a = square(0, 0, 0);
  message_of<OverlapError>(a, square(5, 0, 0));
  message_of<OverlapError>(a, square(1, 0, 0));
  message_of<OverlapError>(a, square(1, 1, 0));
  message_of<OverlapError>(a, square(1e9, -1e9, 0));
}

TEST(Compare, OfTooLittleCoverageIsAnOverlapErrorThatSaysHowMuch) {
  CompareOptions options;
  options.min_coverage = 0.9;
  const Cloud a = rough_cloud(framed_square(500, 181), 182);
  const Cloud b = shifted(a, {0.5, 0, 0});
  EXPECT_NE(message_of<OverlapError>(a, b, options).find("0.9"), std::string::npos);
  options.min_coverage = 0.2;
  EXPECT_GT(compare_plain(a, b, options).coverage, 0.2);
}

TEST(Compare, OfTwoSquaresIsTheirDistance) {
  const Comparison c = compare_plain(square(0, 0, 1), square(0, 0, 3));
  EXPECT_EQ(c.domain_area, 1);
  EXPECT_EQ(c.measures.volume.above, 2);
  EXPECT_EQ(c.measures.volume.below, 0);
  EXPECT_EQ(c.measures.rho, 2);
  EXPECT_EQ(c.coverage, 1);
  EXPECT_EQ(c.t1, 2u);
  EXPECT_EQ(c.t2, 2u);
  EXPECT_EQ(c.common, 2u);
  EXPECT_EQ(c.interface, 0u);
}

TEST(Compare, OfTwoTrianglesThatCrossInAStarMeasuresTheHexagonTheyShare) {
  // Neither triangle holds a node of the other: every cell of T is cut. Of each triangle the three tips are a ninth.
  const Cloud up = cloud_of({{0, 0, 0}, {6, 0, 0}, {3, 6, 0}}), down = cloud_of({{0, 4, 1}, {6, 4, 1}, {3, -2, 1}});
  const Comparison c = compare_plain(up, down);
  EXPECT_NEAR(c.domain_area, 12, 1e-12);
  EXPECT_NEAR(c.measures.volume.above, 12, 1e-12);
  EXPECT_NEAR(c.coverage, 0.5, 1e-12);
  CompareOptions hull;
  hull.domain = DomainKind::hull;
  hull.border = BorderRule::hull;  // trimmed, even the hull holds only cells that one of the scans supports
  EXPECT_NEAR(compare_plain(up, down, hull).measures.volume.above, compare_plain(up, down, hull).domain_area, 1e-12);
}

TEST(Compare, OfAGridAndItselfLifted) {
  // Ridges one spacing wide and up to 45 spacings high: of points alone nobody can tell that they are no second layer.
  const Cloud a = cloud_over(grid(10000, 0), [](const Point2& p) { return std::sin(p.x) * p.y; });
  CompareOptions keep;
  keep.folds = FoldRule::keep;
  const Comparison c = compare_plain(a, shifted(a, {0, 0, 2}), keep);
  EXPECT_EQ(c.domain_area, 99 * 99);
  EXPECT_NEAR(c.measures.volume.net, 2 * 99 * 99, 1e-9);
}

TEST(Compare, MergesDuplicatesByTheirMeanAndSaysHowMany) {
  Cloud a = square(0, 0, 0), b = square(0, 0, 0);
  for (int k = 0; k < 4; ++k) {
    const Point3 p = b.points[static_cast<std::size_t>(k)];
    b.points.push_back({p.x, p.y, 2});
  }
  const Comparison c = compare_plain(a, b);
  EXPECT_EQ(c.measures.volume.above, 1);
  EXPECT_EQ(c.b.points, 8u);
  EXPECT_EQ(c.b.nodes, 4u);
  EXPECT_EQ(c.b.cleaning.duplicates, 4u);
  EXPECT_EQ(c.b.cleaning.duplicate_max_spread, 2);
  EXPECT_EQ(c.fields_b.dz_signed.size(), 8u);
  EXPECT_EQ(c.fields_b.dz_signed[0], 0) << "a point's own height, not its node's";
  EXPECT_EQ(c.fields_b.dz_signed[7], 2);
  CompareOptions highest;
  highest.project.duplicates = DuplicatePolicy::max;
  EXPECT_EQ(compare_plain(a, b, highest).measures.volume.above, 2);
}

TEST(Compare, DropsPointsThatAreNoNumbersAndMarksTheirFields) {
  Cloud a = square(0, 0, 0);
  a.points.insert(a.points.begin() + 1, {nan, 0.5, 0.5});
  a.points.push_back({0.5, 0.5, std::numeric_limits<double>::infinity()});
  const Comparison c = compare_plain(a, square(0, 0, 1));
  EXPECT_EQ(c.measures.volume.above, 1);
  EXPECT_EQ(c.a.cleaning.dropped_nonfinite, 2u);
  ASSERT_EQ(c.fields_a.dz_signed.size(), 6u);
  EXPECT_TRUE(std::isnan(c.fields_a.dz_signed[1]));
  EXPECT_TRUE(std::isnan(c.fields_a.dz_signed[5]));
  EXPECT_EQ(c.fields_a.dz_signed[0], 1);
}

TEST(Compare, CountsThePointsThatAreComparedWhetherTheirFieldsAreKeptOrNot) {
  const Cloud a = rough_cloud(framed_square(300, 183), 184), b = shifted(a, {0.5, 0, 0});
  CompareOptions options;
  const Comparison kept = compare_plain(a, b, options);
  options.keep_points = false;
  const Comparison c = compare_plain(a, b, options);
  EXPECT_TRUE(c.fields_a.dz_signed.empty() && c.fields_b.dz_signed.empty());
  EXPECT_EQ(c.compared_points, kept.compared_points);
  for (const auto& [fields, count] :
       {std::pair{&kept.fields_a, c.compared_points[0]}, std::pair{&kept.fields_b, c.compared_points[1]}})
    EXPECT_EQ(std::count_if(fields->dz_signed.begin(), fields->dz_signed.end(), [](double d) { return d == d; }),
              static_cast<std::ptrdiff_t>(count));
  EXPECT_EQ(c.measures.rho, kept.measures.rho);
}

TEST(Compare, FieldsAreNotANumberOutsideTheOtherScan) {
  const Cloud a = rough_cloud(framed_square(300, 183), 184);
  const Comparison c = compare_plain(a, shifted(a, {0.5, 0, 0}));
  for (std::size_t i = 0; i < a.points.size(); ++i)
    EXPECT_EQ(std::isnan(c.fields_a.dz_signed[i]), a.points[i].x < 0.5) << a.points[i].x;
}

TEST(Compare, AppliesThePoseToB) {
  const Cloud a = rough_cloud(framed_square(1000, 185), 186);
  CompareOptions options;
  options.pose.m = {1, 0, 0, -2, 0, 1, 0, 0.5, 0, 0, 1, 0.25, 0, 0, 0, 1};
  const Cloud b = shifted(a, {2, -0.5, 0});
  const Comparison c = compare_plain(a, b, options);
  EXPECT_NEAR(c.measures.rho, 0.25, 1e-4) << "up to the rounding of x + 2 − 2, which moves nodes by an ulp";
  EXPECT_GT(c.coverage, 0.99);
}

TEST(Compare, SeesTheSameVolumeAlongEveryAxis) {
  const Cloud a = rough_cloud(framed_square(1000, 187), 188), b = rough_cloud(framed_square(900, 189), 190);
  const double along_z = compare_plain(a, b).measures.volume.above;
  const auto turned = [](Cloud cloud, int times) {  // x → y → z → x
    for (Point3& p : cloud.points)
      for (int k = 0; k < times; ++k) p = {p.z, p.x, p.y};
    return cloud;
  };
  CompareOptions options;
  options.check_layers = false;
  options.project.direction.kind = Direction::Kind::axis_x;
  EXPECT_EQ(compare_plain(turned(a, 1), turned(b, 1), options).measures.volume.above, along_z);
  options.project.direction.kind = Direction::Kind::axis_y;
  EXPECT_EQ(compare_plain(turned(a, 2), turned(b, 2), options).measures.volume.above, along_z);
}

TEST(Compare, RefusesUnitsThatDiffer) {
  Cloud a = square(0, 0, 0), b = square(0, 0, 1);
  a.unit = "m";
  b.unit = "ft";
  message_of<InputError>(a, b);
  CompareOptions options;
  options.unit = "m";
  EXPECT_EQ(compare_plain(a, b, options).unit, "m");
  b.unit = "unknown";
  EXPECT_EQ(compare_plain(a, b).unit, "m");
  a.unit = "unknown";
  EXPECT_EQ(compare_plain(a, b).unit, "unknown");
}

TEST(Compare, StopsWhenCancelled) {
  const std::atomic<bool> cancelled{true};
  Context context;
  context.cancelled = &cancelled;
  EXPECT_THROW((void)compare(square(0, 0, 0), square(0, 0, 1), {}, context), Interrupted);
}

TEST(Compare, ReportsProgressFromStartToEnd) {
  Context context;
  std::vector<std::string> stages;
  context.progress = [&](std::string_view stage, double fraction) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
  };
  const Comparison c = compare(square(0, 0, 0), square(0, 0, 1), {}, context);
  std::vector<std::string> timed;
  for (const auto& [stage, seconds] : c.timing.stages) timed.push_back(stage);
  EXPECT_EQ(stages, timed);
}

bool was_timed(const Comparison& c, const std::string& stage) {
  return std::any_of(c.timing.stages.begin(), c.timing.stages.end(), [&](const auto& s) { return s.first == stage; });
}

TEST(Compare, LocatesInThreeWaysWithOneResult) {
  const Cloud a = rough_cloud(framed_square(3000, 183), 184), b = rough_cloud(framed_square(2000, 185), 186);
  CompareOptions options;
  EXPECT_EQ(options.locate, LocateMethod::order);
  options.locate = LocateMethod::tree;
  const Comparison by_tree = compare_plain(a, b, options);
  EXPECT_TRUE(was_timed(by_tree, "spanning_tree"));
  for (const LocateMethod method : {LocateMethod::interface, LocateMethod::order}) {
    options.locate = method;
    const Comparison c = compare_plain(a, b, options);
    EXPECT_FALSE(was_timed(c, "spanning_tree"));
    EXPECT_TRUE(was_timed(c, "localise") && was_timed(c, "merge"));
    EXPECT_NE(c.visited_1_in_2, by_tree.visited_1_in_2);
    EXPECT_NE(c.visited_2_in_1, by_tree.visited_2_in_1);
    // The same triangles in another order: sums and the bisection of percentiles differ by rounding at most.
    EXPECT_NEAR(c.measures.volume.above, by_tree.measures.volume.above, 1e-14 * by_tree.measures.volume.above);
    EXPECT_NEAR(c.measures.volume.below, by_tree.measures.volume.below, 1e-14 * by_tree.measures.volume.below);
    EXPECT_NEAR(c.measures.area, by_tree.measures.area, 1e-14 * by_tree.measures.area);
    for (std::size_t i = 0; i < c.measures.difference.abs_percentiles.size(); ++i)
      EXPECT_NEAR(c.measures.difference.abs_percentiles[i], by_tree.measures.difference.abs_percentiles[i], 1e-12);
    EXPECT_EQ(c.common, by_tree.common);
    EXPECT_EQ(c.interface, by_tree.interface);
    EXPECT_EQ(c.cells.z1, by_tree.cells.z1);
    EXPECT_EQ(c.cells.z2, by_tree.cells.z2);
  }
}

}  // namespace
}  // namespace isopach::test
