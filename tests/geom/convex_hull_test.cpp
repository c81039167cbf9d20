#include "isopach/geom/convex_hull.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "isopach/base/random.hpp"
#include "isopach/geom/predicates.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

bool is_corner(const Points& all, const Point2& p) {
  // A corner is no convex combination of two other points and lies on a side with all points on its left.
  return std::any_of(all.begin(), all.end(), [&](const Point2& q) {
    if (q == p) return false;
    bool is_side = true, is_last = true;
    for (const Point2& r : all) {
      const int turn = orientation(p, q, r);
      is_side = is_side && turn >= 0;
      // On the line of the side nothing lies behind p.
      const bool behind = turn == 0 && r != p && (r.x - p.x) * (q.x - p.x) + (r.y - p.y) * (q.y - p.y) < 0;
      is_last = is_last && !behind;
    }
    return is_side && is_last;
  });
}

Points corners_by_definition(const Points& all) {
  Points corners;
  for (const Point2& p : all)
    if (is_corner(all, p) && std::find(corners.begin(), corners.end(), p) == corners.end()) corners.push_back(p);
  std::sort(corners.begin(), corners.end(), lexicographic_less);
  return corners;
}

bool holds_by_definition(const std::vector<Point2>& corners, const Point2& p) {
  if (corners.size() == 1) return corners[0] == p;
  if (corners.size() == 2)
    return orientation(corners[0], corners[1], p) == 0 && !lexicographic_less(p, corners[0]) &&
           !lexicographic_less(corners[1], p);
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (orientation(corners[i], corners[(i + 1) % corners.size()], p) < 0) return false;
  return !corners.empty();
}

void expect_hull(const Points& all, std::size_t part) {
  ConvexHull hull;
  for (std::size_t i = 0; i < all.size(); i += part)
    hull.add(std::span<const Point2>(all).subspan(i, std::min(part, all.size() - i)));
  std::vector<Point2> found = hull.corners();
  if (found.size() > 2)
    for (std::size_t i = 0; i < found.size(); ++i)
      EXPECT_GT(orientation(found[i], found[(i + 1) % found.size()], found[(i + 2) % found.size()]), 0);
  EXPECT_EQ(found.front(), *std::min_element(found.begin(), found.end(), lexicographic_less));
  std::sort(found.begin(), found.end(), lexicographic_less);
  if (found.size() > 1) {
    EXPECT_EQ(found, corners_by_definition(all));
  }
  Points asked = all;
  for (const Point2& p : all) asked.push_back({p.x + 0.01, p.y}), asked.push_back({p.x, p.y - 0.25});
  for (const Point2& p : asked) EXPECT_EQ(hull.holds(p), holds_by_definition(hull.corners(), p)) << p.x << ' ' << p.y;
}

TEST(ConvexHull, OfFamiliesInParts) {
  for (const Family& family : families())
    for (const std::size_t part : {1, 7, 1000}) {
      SCOPED_TRACE(family.name + ", parts of " + std::to_string(part));
      const Points all = family.make(90, 5);
      if (!all.empty()) expect_hull(all, part);
      if (HasFailure()) return;
    }
}

TEST(ConvexHull, OfSmallSetsOnALattice) {
  Random random(3);
  for (int trial = 0; trial < 3000 && !HasFailure(); ++trial) {
    SCOPED_TRACE(trial);
    Points all;
    const auto n = static_cast<std::size_t>(random.uniform(1, 14));
    for (std::size_t i = 0; i < n; ++i)
      all.push_back({std::floor(random.uniform(0, 5)) / 4, std::floor(random.uniform(0, 5)) / 4});
    expect_hull(all, 1 + static_cast<std::size_t>(trial) % 5);
  }
}

TEST(ConvexHull, OfNothing) {
  ConvexHull hull;
  hull.add({});
  EXPECT_TRUE(hull.corners().empty());
  EXPECT_FALSE(hull.holds({0, 0}));
}

}  // namespace
}  // namespace isopach::test
