// Grooves whose depth and length are known, and the definition of a valley by another way.
#include "isopach/measure/texture/wrinkles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "isopach/base/error.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/simulate/bump.hpp"
#include "isopach/simulate/sampling.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

struct Skin {
  SortedTriangulation t;
  Array<double> z, relief, area;

  [[nodiscard]] Wrinkles find(const WrinkleOptions& options) const {
    return find_wrinkles(t.triangulation, t.xy, z, relief, {}, area, options, {});
  }
};

/// 20 by 10, `n` points, relief as given, the surface itself tilted by `slope` along x.
template <class Relief>
Skin skin(std::size_t n, std::uint64_t seed, double slope, Relief&& relief) {
  Skin s{triangulate_unsorted(bordered_nodes(rectangle({0, 0}, {20, 10}), n, {seed, 1}), {}), {}, {}, {}};
  s.area.resize(s.t.xy.size());
  std::fill(s.area.begin(), s.area.end(), 0.0);
  for (Index i = 0; i < s.t.triangulation.real; ++i) {
    const auto& v = s.t.triangulation.triangles[i].v;
    const Point2 &a = s.t.xy[v[0]], &b = s.t.xy[v[1]], &c = s.t.xy[v[2]];
    for (const Index k : v) s.area[k] += ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 6;
  }
  for (const Point2& p : s.t.xy) {
    s.relief.push_back(relief(p));
    s.z.push_back(slope * p.x + s.relief.back());
  }
  return s;
}

/// Where h (1 − (u/a)²)³ is deeper than `limit`, from end to end.
double length_below(const Bump& groove, double limit) {
  return 2 * groove.a * std::sqrt(1 - std::cbrt(limit / -groove.h));
}

TEST(Wrinkles, DepthAndLengthOfGrooves) {
  const Bump deep{{8, 3}, -0.4, 6, 0.7, {1, 0}, 0, 0}, shallow{{12, 7}, -0.2, 5, 0.6, {0.6, 0.8}, 0, 0};
  const Skin s = skin(40000, 1, 0, [&](const Point2& p) { return deep.at(p.x, p.y) + shallow.at(p.x, p.y); });
  const Wrinkles w = s.find({0.05, 2});
  ASSERT_EQ(w.all.size(), 2u);
  EXPECT_EQ(w.pits, 0u);
  const Bump* truth[] = {&deep, &shallow};
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(w.all[k].depth, -truth[k]->h, 0.01 * -truth[k]->h);
    EXPECT_NEAR(w.all[k].length, length_below(*truth[k], 0.05), 0.03 * length_below(*truth[k], 0.05));
    EXPECT_LT(w.all[k].mean_depth, w.all[k].depth);
    EXPECT_GT(w.all[k].mean_depth, 0.6 * w.all[k].depth);
    EXPECT_NEAR(w.all[k].width * w.all[k].length, w.all[k].area, 1e-12);
    const Point2 at = s.t.xy[w.all[k].deepest];
    EXPECT_NEAR(std::hypot(at.x - truth[k]->centre.x, at.y - truth[k]->centre.y), 0, 0.5);
  }
}

TEST(Wrinkles, LengthIsAlongBendsAndSlopes) {
  const Bump bent{{10, 4}, -0.4, 7, 0.6, {1, 0}, 0.06, 0};
  double length = 0;
  const double half = length_below(bent, 0.05) / 2;
  const double slope = 0.75;
  for (double u = -half; u < half; u += half / 1000)
    length += half / 1000 * std::sqrt(1 + slope * slope + 0.12 * 0.12 * u * u);
  const Skin s = skin(40000, 2, slope, [&](const Point2& p) { return bent.at(p.x, p.y); });
  const Wrinkles w = s.find({0.05, 2});
  ASSERT_EQ(w.all.size(), 1u);
  EXPECT_NEAR(w.all[0].length, length, 0.03 * length);
}

TEST(Wrinkles, VolumeConvergesToThatOfTheGroove) {
  const Bump groove{{10, 5}, -0.4, 6, 0.7, {0.8, 0.6}, 0, 0};
  const Skin s = skin(40000, 3, 0, [&](const Point2& p) { return groove.at(p.x, p.y); });
  const Wrinkles w = s.find({1e-4, 2});
  ASSERT_EQ(w.all.size(), 1u);
  EXPECT_NEAR(w.all[0].volume, -groove.volume(), 0.02 * -groove.volume());
}

TEST(Wrinkles, PitsAndShortOrShallowValleysAreNone) {
  const Bump pit{{5, 5}, -0.4, 1.5, 1.5, {1, 0}, 0, 0}, line{{13, 5}, -0.4, 4, 0.4, {1, 0}, 0, 0};
  const Skin s = skin(30000, 4, 0, [&](const Point2& p) { return pit.at(p.x, p.y) + line.at(p.x, p.y); });
  EXPECT_EQ(s.find({0.05, 1}).all.size(), 1u);
  EXPECT_EQ(s.find({0.05, 1}).pits, 1u);
  EXPECT_EQ(s.find({0.05, 9}).all.size(), 0u);
  EXPECT_EQ(s.find({0.5, 1}).all.size(), 0u);
  EXPECT_EQ(s.find({0.5, 1}).pits, 0u);
}

TEST(Wrinkles, ASpikeOfNoDataTakesNoMemoryForItsLength) {
  const Bump groove{{10, 5}, -0.5, 8, 0.6, {1, 0}, 0, 0};
  for (const double depth : {1e12, 3.4028234663852886e38}) {  // of a raster that was written as points
    Skin s = skin(2000, 5, 0, [&](const Point2& p) { return groove.at(p.x, p.y); });
    const auto deepest =
        static_cast<std::size_t>(std::min_element(s.relief.begin(), s.relief.end()) - s.relief.begin());
    s.z[deepest] = s.relief[deepest] = -depth;
    const Wrinkles w = s.find({0.05, 1});
    EXPECT_EQ(w.all.size() + w.pits + w.at_rim + w.steep, 1u);
    for (const Wrinkle& one : w.all) EXPECT_LE(one.part.size(), 64 * one.nodes.size());
  }
}

TEST(Wrinkles, DefaultLimitsComeFromTheNoiseAndTheSpacing) {
  test::Random random(7);
  const Bump groove{{10, 5}, -0.5, 8, 0.6, {1, 0}, 0, 0};
  const Skin s = skin(20000, 5, 0, [&](const Point2& p) { return groove.at(p.x, p.y) + random.uniform(-0.05, 0.05); });
  const Wrinkles w = s.find({});
  EXPECT_NEAR(w.depth, 3 * 1.4826 * 0.025, 0.01);  // the median of |uniform| is a quarter of the range
  EXPECT_NEAR(w.length, 10 * w.spacing, 1e-12);
  EXPECT_NEAR(w.spacing, std::sqrt(200.0 / static_cast<double>(s.t.xy.size())), 1e-9);
  ASSERT_EQ(w.all.size(), 1u);
  EXPECT_EQ(skin(500, 5, 0, [](const Point2&) { return 0.0; }).find({}).all.size(), 0u);
}

/// Connected sets by merging labels over the sides of all triangles until none changes.
TEST(Wrinkles, ValleysAreConnectedSetsOfDeepNodes) {
  test::Random random(9);
  const Skin s = skin(
      3000, 6, 0, [&](const Point2& p) { return std::sin(3 * p.x) * std::cos(2 * p.y) + random.uniform(-1, 1) / 4; });
  constexpr double depth = 0.3;
  std::vector<Index> label(s.relief.size());
  std::iota(label.begin(), label.end(), Index{0});
  for (bool changed = true; changed;) {
    changed = false;
    for (Index i = 0; i < s.t.triangulation.real; ++i)
      for (Index k = 0; k < 3; ++k) {
        const Index a = s.t.triangulation.triangles[i].v[k], b = s.t.triangulation.triangles[i].v[next_side(k)];
        if (s.relief[a] > -depth || s.relief[b] > -depth || label[a] == label[b]) continue;
        label[a] = label[b] = std::min(label[a], label[b]);
        changed = true;
      }
  }
  std::vector<std::size_t> size(s.relief.size(), 0);
  for (std::size_t i = 0; i < label.size(); ++i)
    if (s.relief[i] <= -depth) ++size[label[i]];
  const auto large =
      static_cast<std::size_t>(std::count_if(size.begin(), size.end(), [](std::size_t n) { return n >= 3; }));
  const Wrinkles w = s.find({depth, 0.5});
  EXPECT_EQ(w.all.size() + w.pits + w.at_rim + w.steep, large);
  ASSERT_FALSE(w.all.empty());
  for (const Wrinkle& one : w.all) {
    EXPECT_EQ(one.nodes.size(), size[label[one.nodes.front()]]);
    double deepest = 0;
    for (const Index i : one.nodes) {
      EXPECT_EQ(label[i], label[one.nodes.front()]);
      deepest = std::max(deepest, -s.relief[i]);
    }
    EXPECT_EQ(one.depth, deepest);
  }
}

TEST(Wrinkles, DepthAlongTheLineInAnotherRelief) {
  const Bump groove{{10, 5}, -0.4, 6, 0.7, {1, 0}, 0, 0};
  const Skin s = skin(20000, 8, 0, [&](const Point2& p) { return groove.at(p.x, p.y); });
  const Wrinkles found = s.find({0.05, 2});
  ASSERT_EQ(found.all.size(), 1u);
  const Wrinkle& w = found.all[0];
  std::vector<double> half, gone, unknown(w.nodes.size(), std::nan(""));
  for (const Index i : w.nodes) half.push_back(s.relief[i] / 2), gone.push_back(0.1);
  EXPECT_DOUBLE_EQ(depth_along(w, half).depth, w.depth / 2);
  EXPECT_NEAR(depth_along(w, half).mean_depth, w.mean_depth / 2, 1e-12);
  EXPECT_EQ(depth_along(w, gone).depth, 0);
  EXPECT_TRUE(std::isnan(depth_along(w, unknown).depth) && std::isnan(depth_along(w, unknown).mean_depth));
}

TEST(Wrinkles, RefusesLimitsThatAreNone) {
  const Skin s = skin(100, 8, 0, [](const Point2&) { return 0.0; });
  EXPECT_THROW((void)s.find({-1, 0}), UsageError);
  EXPECT_THROW((void)s.find({0, std::nan("")}), UsageError);
}

TEST(Wrinkles, AlongTheRimAndDeeperThanWideAreLeftOutAndCounted) {
  const Bump wrinkle{{8, 5}, -0.4, 6, 0.7, {1, 0}, 0, 0};
  const Skin with_step = skin(20000, 6, 0, [&](const Point2& p) {
    const bool slit = std::fabs(p.y - 8) < 0.12 && p.x > 4 && p.x < 16, rim = p.y < 0.05;
    return wrinkle.at(p.x, p.y) - (slit ? 30 : 0) - (rim ? 3 : 0);
  });
  const Wrinkles w = with_step.find({0.05, 2});
  ASSERT_EQ(w.all.size(), 1u);
  EXPECT_LT(w.all[0].depth, 0.5);
  EXPECT_EQ(w.at_rim, 1u);
  EXPECT_EQ(w.steep, 1u);
}

}  // namespace
}  // namespace isopach
