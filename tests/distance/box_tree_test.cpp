// The tree of boxes against every point.
#include "isopach/distance/box_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "tests/support/random.hpp"

namespace isopach {
namespace {

using Near = std::vector<std::pair<double, Index>>;

Near all_by_distance(const std::vector<Point3>& points, const Point3& p) {
  Near all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = p.x - points[i].x, y = p.y - points[i].y, z = p.z - points[i].z;
    all.emplace_back(x * x + y * y + z * z, static_cast<Index>(i));
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// In no order; of lattices many are equal, and most distances.
std::vector<Point3> some_points(std::size_t n, bool lattice, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Point3> points;
  const auto coordinate = [&] { return lattice ? static_cast<double>(random.below(6)) : random.uniform(0, 6); };
  for (std::size_t i = 0; i < n; ++i) {
    const double x = coordinate(), y = coordinate();
    points.push_back({x, y, coordinate()});
  }
  return points;
}

void expect_as_of_all(const std::vector<Point3>& points, const Point3& p, Index begin) {
  const BoxTree tree(points);
  const Near all = all_by_distance(points, p);
  const BoxTree::Two two = tree.nearest_two(p, begin);
  EXPECT_EQ(two.first, all.empty() ? no_index : all[0].second);
  EXPECT_EQ(two.second, all.size() < 2 ? no_index : all[1].second);
}

// Wherever the search begins, and of equally near ones those of the smaller index.
TEST(BoxTree, NearestAreThoseOfEveryPoint) {
  for (const bool lattice : {false, true})
    for (const std::size_t n : {1u, 2u, 8u, 9u, 65u, 700u}) {
      const std::vector<Point3> points = some_points(n, lattice, n);
      test::Random random(4);
      for (int i = 0; i < 30; ++i) {
        const Point3 anywhere{random.uniform(-3, 9), random.uniform(-3, 9), static_cast<double>(random.below(9))};
        const Point3 p = i % 2 == 0 ? anywhere : points[random.below(n)];
        expect_as_of_all(points, p, i % 3 == 0 ? no_index : static_cast<Index>(random.below(n)));
      }
    }
}

TEST(BoxTree, OfNoPoints) {
  const BoxTree tree({});
  EXPECT_EQ(tree.nearest_two({1, 2, 3}).first, no_index);
}

TEST(BoxTree, OfOnePlaceManyTimes) { expect_as_of_all(std::vector<Point3>(300, {1, 2, 3}), {1, 2, 3}, 250); }

// Squares beyond 1e308, and poses that have left the numbers: a partner is a point all the same.
TEST(BoxTree, ThereIsANearestWhateverTheNumbers) {
  std::vector<Point3> points;
  for (int i = 0; i < 100; ++i) points.push_back({i * 1e200, -i * 1e200, 0});
  const BoxTree tree(points);
  for (const double x :
       {0.5e200, 1e308, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_LT(tree.nearest_two({x, x, x}).first, points.size()) << x;
    EXPECT_LT(tree.nearest_two({x, x, x}, 50).first, points.size()) << x;
  }
}

}  // namespace
}  // namespace isopach
