// Laws of the Hilbert order: a curve (neighbours on it are neighbours in the plane), a quadtree (prefixes are squares),
// and a sort (equal to std::sort by the same relation).
#include "isopach/geom/curve.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>

#include "isopach/base/parallel.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

CurveBox box_of(const Points& points) {
  Box2 box;
  for (const Point2& p : points) box.add(p);
  return curve_box(box);
}

std::vector<Index> sorted_ids(const Points& points, const CurveBox& box) {
  std::vector<Index> ids(points.size());
  std::iota(ids.begin(), ids.end(), Index{0});
  std::sort(ids.begin(), ids.end(), [&](Index i, Index j) {
    const std::uint64_t k = curve_key(box, points[i]), l = curve_key(box, points[j]);
    if (k != l) return k < l;
    if (points[i] == points[j]) return i < j;
    return lexicographic_less(points[i], points[j]);
  });
  return ids;
}

class CurveFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, CurveFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(CurveFamilies, OrderEqualsStdSort) {
  for (const std::size_t n : {0, 1, 2, 3, 17, 1000, 30000}) {
    const Points points = GetParam().make(n, 31);
    const CurveBox box = box_of(points);
    Array<std::uint64_t> keys;
    const Array<Index> order = curve_order(points, box, &keys);
    const std::vector<Index> expected = sorted_ids(points, box);
    ASSERT_TRUE(std::equal(order.begin(), order.end(), expected.begin(), expected.end())) << n;
    ASSERT_EQ(keys.size(), points.size());
    for (std::size_t i = 0; i < keys.size(); ++i) ASSERT_EQ(keys[i], curve_key(box, points[order[i]]));
  }
}

TEST_P(CurveFamilies, OrderIsTheSameForAnyNumberOfThreads) {
  const Points points = GetParam().make(20000, 32);
  const CurveBox box = box_of(points);
  const Array<Index> expected = curve_order(points, box);
  for (const int threads : {1, 2, 7})
    run_with_threads(threads, [&] { EXPECT_EQ(curve_order(points, box), expected) << threads; });
}

TEST_P(CurveFamilies, OrderIsAFunctionOfThePointSet) {
  Points points = GetParam().make(3000, 33);
  const CurveBox box = box_of(points);
  const auto in_order = [&] {
    Points sorted;
    for (const Index i : curve_order(points, box)) sorted.push_back(points[i]);
    return sorted;
  };
  const Points expected = in_order();
  Random(34).shuffle(points);
  EXPECT_EQ(in_order(), expected);
}

TEST_P(CurveFamilies, BoxHoldsThePointsAndIsNotTooLarge) {
  const Points points = GetParam().make(1000, 35);
  Box2 extent;
  for (const Point2& p : points) extent.add(p);
  const CurveBox box = curve_box(extent);
  const double side = 4294967296.0 / box.scale;
  EXPECT_EQ(std::exp2(std::round(std::log2(box.scale))), box.scale) << "a power of two scales exactly";
  EXPECT_LE(box.min.x, extent.min.x);
  EXPECT_LE(box.min.y, extent.min.y);
  EXPECT_GE(box.min.x + side, extent.max.x);
  EXPECT_GE(box.min.y + side, extent.max.y);
  EXPECT_LE(side, 4 * std::max(extent.max.x - extent.min.x, extent.max.y - extent.min.y));
}

TEST(CurveKey, IsACurveEveryStepGoesToANeighbour) {
  constexpr int side = 64;
  const CurveBox box = curve_box([] {
    Box2 b;
    b.add(Point2{0, 0});
    b.add(Point2{side - 0.5, side - 0.5});
    return b;
  }());
  ASSERT_EQ(box.scale, 4294967296.0 / side);
  std::map<std::uint64_t, Point2> along;
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y) {
      const Point2 p{x + 0.5, y + 0.5};
      along[curve_key(box, p) >> (64 - 12)] = p;
    }
  ASSERT_EQ(along.size(), static_cast<std::size_t>(side * side));
  EXPECT_EQ(along.rbegin()->first, static_cast<std::uint64_t>(side * side - 1));
  const Point2* before = nullptr;
  for (const auto& [key, p] : along) {
    if (before != nullptr) {
      EXPECT_EQ(std::abs(p.x - before->x) + std::abs(p.y - before->y), 1) << key;
    }
    before = &p;
  }
}

TEST(CurveKey, PrefixesAreSquaresOfAQuadtree) {
  const Points points = uniform(2000, 36);
  const CurveBox box = box_of(points);
  const double side = 4294967296.0 / box.scale;
  for (const int levels : {1, 2, 5, 16, 31, 32}) {
    std::map<std::uint64_t, std::pair<double, double>> square_of_prefix;
    std::map<std::pair<double, double>, std::uint64_t> prefix_of_square;
    for (const Point2& p : points) {
      const double cells = std::ldexp(1.0, levels) / side;
      const std::pair square{std::floor((p.x - box.min.x) * cells), std::floor((p.y - box.min.y) * cells)};
      const std::uint64_t prefix = curve_key(box, p) >> (64 - 2 * levels);
      EXPECT_EQ(square_of_prefix.emplace(prefix, square).first->second, square);
      EXPECT_EQ(prefix_of_square.emplace(square, prefix).first->second, prefix);
    }
  }
}

TEST(CurveKey, ClampsPointsOutsideTheSquare) {
  const CurveBox box{{0, 0}, 4294967296.0};
  EXPECT_EQ(curve_key(box, {-5, -5}), curve_key(box, {0, 0}));
  EXPECT_EQ(curve_key(box, {7, 7}), curve_key(box, {1 - 0x1p-33, 1 - 0x1p-33}));
}

TEST(CurveOrder, SortsMoreThanOneBlockOfEqualKeysLexicographically) {
  // A box far larger than the points: one key for all of them.
  Points points = uniform(200000, 37);
  const CurveBox box{{-1, -1}, 1e-9};
  const Array<Index> order = curve_order(points, box);
  for (std::size_t i = 1; i < order.size(); ++i)
    ASSERT_TRUE(lexicographic_less(points[order[i - 1]], points[order[i]])) << i;
}

}  // namespace
}  // namespace isopach::test
