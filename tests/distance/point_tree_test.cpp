// The k-d tree against every point.
#include "isopach/distance/point_tree.hpp"

#include <gtest/gtest.h>

#include "tests/support/random.hpp"

namespace isopach {
namespace {

std::vector<Point3> lattice(std::size_t n, std::uint64_t seed) {  // many equal points and equal distances
  test::Random random(seed);
  std::vector<Point3> points;
  for (std::size_t i = 0; i < n; ++i)
    points.push_back({static_cast<double>(random.below(9)), static_cast<double>(random.below(9)),
                      static_cast<double>(random.below(9))});
  return points;
}

double distance2(const Point3& p, const Point3& q) {
  return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y) + (p.z - q.z) * (p.z - q.z);
}

TEST(PointTree, NearestAndWithinAreThoseOfEveryPoint) {
  for (const std::size_t n : {1u, 2u, 13u, 700u}) {
    const std::vector<Point3> points = lattice(n, n);
    const PointTree tree(points);
    test::Random random(4);
    for (int i = 0; i < 200; ++i) {
      const Point3 p{random.uniform(-3, 12), random.uniform(-3, 12), static_cast<double>(random.below(9))};
      const Point3 q = i % 2 == 0 ? p : points[random.below(n)];
      double best = std::numeric_limits<double>::infinity();
      std::vector<Index> expected, found;
      const double radius = i % 4 < 2 ? 2 : random.uniform(0, 5);
      for (std::size_t k = 0; k < n; ++k) {
        best = std::min(best, distance2(q, points[k]));
        if (distance2(q, points[k]) <= radius * radius) expected.push_back(static_cast<Index>(k));
      }
      EXPECT_DOUBLE_EQ(tree.nearest_distance2(q), best);
      tree.within(q, radius, found);
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, expected);
    }
  }
}

TEST(PointTree, NearestTwoAndMoreAreThoseOfEveryPoint) {
  for (const std::size_t n : {1u, 2u, 13u, 700u}) {
    const std::vector<Point3> points = lattice(n, n);
    const PointTree tree(points);
    test::Random random(4);
    for (int i = 0; i < 100; ++i) {
      const Point3 p{random.uniform(-3, 12), random.uniform(-3, 12), static_cast<double>(random.below(9))};
      std::vector<double> all;
      for (const Point3& q : points) all.push_back(distance2(p, q));
      std::sort(all.begin(), all.end());
      const PointTree::Two two = tree.nearest_two(p);
      EXPECT_DOUBLE_EQ(two.first2, all[0]);
      EXPECT_DOUBLE_EQ(distance2(p, points[two.first]), all[0]);
      EXPECT_EQ(two.second == no_index, n == 1);
      if (n > 1) {
        EXPECT_DOUBLE_EQ(distance2(p, points[two.second]), all[1]);
        EXPECT_NE(two.first, two.second);
      }
      for (const std::size_t k : {3u, 16u, 100u}) {
        std::vector<Index> found{7};
        tree.nearest(p, k, found);
        ASSERT_EQ(found.size(), std::min(k, n));
        for (std::size_t j = 0; j < found.size(); ++j) EXPECT_DOUBLE_EQ(distance2(p, points[found[j]]), all[j]);
      }
    }
  }
}

TEST(PointTree, WithoutPoints) {
  const PointTree tree({});
  std::vector<Index> found;
  tree.within({0, 0, 0}, 1, found);
  EXPECT_TRUE(found.empty());
  EXPECT_EQ(tree.nearest_distance2({0, 0, 0}), std::numeric_limits<double>::infinity());
  EXPECT_EQ(tree.nearest_two({0, 0, 0}).first, no_index);
  tree.nearest({0, 0, 0}, 3, found);
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace isopach
