#include "isopach/report/view/space.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <tuple>
#include <vector>

namespace isopach {
namespace {

std::vector<Point3> bump(std::size_t n) {
  std::mt19937 random(7);
  std::vector<Point3> points;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = 100.0 * static_cast<double>(random()) / 4294967296.0;
    const double y = 100.0 * static_cast<double>(random()) / 4294967296.0;
    points.push_back({x, y, 0.1 * x});
  }
  return points;
}

std::set<std::tuple<double, double, double>> places(const SpaceScene& s, const SpaceSample& sample) {
  std::set<std::tuple<double, double, double>> out;
  for (const Index i : sample.chosen) out.emplace(s.points[i].x, s.points[i].y, s.points[i].z);
  return out;
}

TEST(Space, TheSameForAnyOrderOfThePoints) {
  std::vector<Point3> points = bump(20000), turned(points.rbegin(), points.rend());
  SpaceScene a, b;
  a.points = points, b.points = turned;
  const SpaceSample sample = sample_space(a, 2000, {}), other = sample_space(b, 2000, {});
  EXPECT_LE(sample.chosen.size(), 2000U);
  EXPECT_GE(sample.chosen.size(), 1000U);
  EXPECT_FALSE(sample.is_whole);
  EXPECT_EQ(places(a, sample), places(b, other));
  a.parts = b.parts = {{"all", "#808080"}};
  a.title = b.title = "<script>";
  EXPECT_EQ(space_view(a, sample), space_view(b, other));
  EXPECT_EQ(space_view(a, sample).find("<script>\""), std::string::npos);
}

TEST(Space, PeaksAreKeptAndMissingValuesAndPlacesAreNone) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Point3> points = bump(20000);
  std::vector<double> values(points.size(), 0.01);
  values[1234] = -9, values[77] = nan, points[5].y = nan;
  SpaceScene s;
  s.points = points, s.values = values;
  const SpaceSample sample = sample_space(s, 500, {});
  EXPECT_EQ(std::count(sample.chosen.begin(), sample.chosen.end(), 1234U), 1);
  EXPECT_EQ(std::count(sample.chosen.begin(), sample.chosen.end(), 5U), 0);
  EXPECT_DOUBLE_EQ(space_limit(values), 0.01);
  EXPECT_EQ(space_limit({}), 0);
}

TEST(Space, NormalsAreThoseOfThePlaneOnTheSideOfTheViewer) {
  const std::vector<Point3> points = bump(1000);
  SpaceScene s;
  s.points = points;
  const SpaceSample sample = sample_space(s, 1000, {});
  EXPECT_TRUE(sample.is_whole);
  ASSERT_EQ(sample.normals.size(), points.size());
  for (const Point3& n : sample.normals) {
    EXPECT_NEAR(n.x, -0.1 / std::sqrt(1.01), 1e-9);
    EXPECT_NEAR(n.z, 1 / std::sqrt(1.01), 1e-9);
  }
}

TEST(Space, WithoutPointsThereIsNoView) {
  SpaceScene s;
  s.parts = {{"all", "#808080"}};
  EXPECT_EQ(space_view(s, sample_space(s, 100, {})), "");
}

}  // namespace
}  // namespace isopach
