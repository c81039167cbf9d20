// Locations by the common triangulation and along the curve against those along the spanning tree, which have an oracle
// of their own; the constructed worst case; nodes of high degree; bundles of thin triangles between all neighbours.
#include "isopach/overlay/localise_by_interface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/overlay/localise.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

using Kind = Location::Kind;

struct Mesh {
  Array<Point2> xy;
  Triangulation t;
};

/// Two meshes in one curve order, and their union.
struct Pair {
  CurveBox box;
  Mesh a, b;
  UnitedNodes g;
  Triangulation t;

  Pair(const Points& of_a, const Points& of_b) {
    Box2 bounds;
    for (const Points* points : {&of_a, &of_b})
      for (const Point2& p : *points) bounds.add(p);
    box = curve_box(bounds);
    a = mesh(of_a), b = mesh(of_b);
    g = unite(a.xy, b.xy, box);
    t = triangulate(g.xy, box, {});
  }
  [[nodiscard]] MutualLocations by_interface() const { return localise_by_interface(g, t, a.t, a.xy, b.t, b.xy, {}); }
  [[nodiscard]] MutualLocations in_order() const {
    return {localise_in_order(a.xy, b.t, b.xy, {}), localise_in_order(b.xy, a.t, a.xy, {})};
  }
  [[nodiscard]] MutualLocations by_tree() const {
    return {localise(a.xy, spanning_tree(a.t, a.xy, {}), b.t, b.xy, {}),
            localise(b.xy, spanning_tree(b.t, b.xy, {}), a.t, a.xy, {})};
  }

 private:
  [[nodiscard]] Mesh mesh(const Points& points) const {
    Mesh made;
    const Points nodes = distinct(points);
    for (const Index i : curve_order(nodes, box)) made.xy.push_back(nodes[i]);
    made.t = triangulate(made.xy, box, {});
    return made;
  }
};

void expect_same(const Locations& found, const Locations& expected, const std::string& what) {
  ASSERT_EQ(found.size(), expected.size()) << what;
  for (std::size_t i = 0; i < found.size(); ++i) ASSERT_EQ(found[i], expected[i]) << what << ", node " << i;
}

void expect_same(const Points& a, const Points& b, const std::string& what) {
  const Pair pair(a, b);
  const MutualLocations expected = pair.by_tree();
  for (const auto& [found, how] : {std::pair{pair.by_interface(), "interface"}, std::pair{pair.in_order(), "order"}}) {
    expect_same(found.of_1_in_2, expected.of_1_in_2, what + ", 1 in 2, " + how);
    expect_same(found.of_2_in_1, expected.of_2_in_1, what + ", 2 in 1, " + how);
  }
}

Points moved(Points points, double dx, double dy) {
  for (Point2& p : points) p = {p.x + dx, p.y + dy};
  return points;
}

Points joined(Points points, const Points& more) {
  points.insert(points.end(), more.begin(), more.end());
  return points;
}

class ByInterfaceFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, ByInterfaceFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(ByInterfaceFamilies, EqualsTheTreeOnTwoOfTheFamily) {
  for (const std::size_t n : {0, 1, 2, 3, 4, 5, 9, 40, 1000})
    for (const std::size_t m : {0, 1, 2, 3, 4, 7, 40, 3000})
      for (std::uint64_t seed = 1; seed <= (n + m < 20 ? 5 : 1); ++seed)
        expect_same(GetParam().make(n, seed), GetParam().make(m, 50 + seed),
                    std::to_string(n) + " and " + std::to_string(m) + ", seed " + std::to_string(seed));
}

TEST_P(ByInterfaceFamilies, EqualsTheTreeWithEveryOtherFamily) {
  for (const Family& other : families()) expect_same(GetParam().make(80, 3), other.make(60, 4), other.name);
}

TEST_P(ByInterfaceFamilies, EqualsTheTreeOnSharedNodes) {
  const Points common = GetParam().make(150, 5), mine = GetParam().make(100, 6), yours = GetParam().make(100, 7);
  expect_same(common, common, "the same nodes");
  expect_same(joined(common, mine), joined(common, yours), "some shared");
  expect_same(joined(common, mine), common, "subset");
  expect_same(common, joined(common, yours), "superset");
}

TEST_P(ByInterfaceFamilies, EqualsTheTreeOnHullsThatCrossTouchAndMiss) {
  const Points a = GetParam().make(400, 8), b = GetParam().make(300, 9);
  Box2 box;
  for (const Point2& p : a) box.add(p);
  const double w = box.max.x - box.min.x, h = box.max.y - box.min.y;
  for (const double shift : {0.25, 0.5, 1.0, 3.0})
    for (const double turn : {-1.0, 0.0, 1.0})
      expect_same(a, moved(b, shift * w, turn * shift * h), std::to_string(shift) + " " + std::to_string(turn));
}

TEST_P(ByInterfaceFamilies, IsTheSameForAnyNumberOfThreads) {
  for (const std::size_t n : {200, 30000}) {
    const Pair pair(GetParam().make(n, 10), GetParam().make(30000, 11));
    const MutualLocations expected = pair.by_interface(), in_order = pair.in_order();
    for (const int threads : {1, 2, 7})
      run_with_threads(threads, [&] {
        const MutualLocations found = pair.by_interface(), again = pair.in_order();
        for (const auto& [one, other] :
             {std::pair{&found.of_1_in_2, &expected.of_1_in_2}, std::pair{&found.of_2_in_1, &expected.of_2_in_1},
              std::pair{&again.of_1_in_2, &in_order.of_1_in_2}}) {
          EXPECT_EQ(one->kind, other->kind) << threads;
          EXPECT_EQ(one->id, other->id) << threads;
          EXPECT_EQ(one->visited, other->visited) << threads;
        }
      });
  }
}

double visited_per_node(const MutualLocations& found) {
  return static_cast<double>(found.of_1_in_2.visited + found.of_2_in_1.visited) /
         static_cast<double>(found.of_1_in_2.size() + found.of_2_in_1.size());
}

TEST(ByInterface, VisitsAConstantNumberOfTrianglesPerUniformNode) {
  const double few = visited_per_node(Pair(uniform(5000, 1), uniform(5000, 2)).by_interface());
  const double many = visited_per_node(Pair(uniform(80000, 1), uniform(80000, 2)).by_interface());
  EXPECT_LT(many, 1.1 * few);
  EXPECT_GT(many, 1);
  EXPECT_LT(many, 4);
}

Pair worst_case(std::size_t n) {
  SceneOptions options;
  options.points_a = options.points_b = n;
  const Scene scene = make_scene("worst-case", options, {});
  Points a, b;
  for (const Point3& p : scene.a.points) a.push_back({p.x, p.y});
  for (const Point3& p : scene.b.points) b.push_back({p.x, p.y});
  return {a, b};
}

// The tree crosses every long edge of the other mesh with every edge; the common triangulation leads along them.
TEST(ByInterface, IsLinearWhereTheTreeIsQuadratic) {
  const Pair small = worst_case(1000), large = worst_case(4000);
  EXPECT_GT(visited_per_node(small.by_tree()), 300);
  EXPECT_GT(visited_per_node(large.by_tree()), 3.5 * visited_per_node(small.by_tree()));
  expect_same(small.by_interface().of_1_in_2, small.by_tree().of_1_in_2, "1 in 2");
  expect_same(small.by_interface().of_2_in_1, small.by_tree().of_2_in_1, "2 in 1");
  EXPECT_LE(visited_per_node(small.by_interface()), 20);
  EXPECT_LE(visited_per_node(worst_case(100000).by_interface()), 20);
}

// All nodes of the wheel's inner rim have their interface edge to the hub: turned around once, not once for each.
TEST(ByInterface, TurnsAroundAHubOnce) {
  const auto wheel = [](std::size_t n, double radius, double phase) {
    Points points;
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = 2 * std::acos(-1.0) * (static_cast<double>(i) + phase) / static_cast<double>(n);
      points.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    return points;
  };
  double per_node[2];
  for (int i = 0; i < 2; ++i) {
    const std::size_t n = i == 0 ? 500 : 8000;
    Points hub = wheel(n, 2, 0);
    hub.push_back({0, 0});
    const Points rim = wheel(n / 2, 1, 0.3);
    expect_same(rim, hub, "wheel");
    per_node[i] = visited_per_node(Pair(rim, hub).by_interface());
  }
  EXPECT_LT(per_node[1], 1.5 * per_node[0]);
  EXPECT_LT(per_node[1], 20);
}

// docs/method/localisation.md: nodes at random heights in the worst case's bundle of thin triangles. Every walk is
// long, so that many rounds of the budget are needed.
TEST(ByInterface, EqualsTheTreeWhereEveryNeighbourIsBehindABundle) {
  Random random(12);
  for (const std::size_t n : {10, 100, 500}) {
    Points between, columns{{-1e4, -1e4}, {1e4, -1e4}, {-1e4, 1e4}, {1e4, 1e4}};
    for (std::size_t i = 0; i < n; ++i) {
      between.push_back({0.8 * static_cast<double>(i), random.uniform(-0.1, 0.1)});
      columns.push_back({i % 2 == 0 ? -1e3 : 1e3 + 0.8 * static_cast<double>(n),
                         -0.1 + 0.2 * static_cast<double>(i) / static_cast<double>(n)});
    }
    expect_same(between, columns, std::to_string(n));
  }
}

TEST(ByInterface, StopsWhenCancelled) {
  const Pair pair(uniform(100, 1), uniform(100, 2));
  const std::atomic<bool> cancelled{true};
  Context context;
  context.cancelled = &cancelled;
  EXPECT_THROW((void)localise_by_interface(pair.g, pair.t, pair.a.t, pair.a.xy, pair.b.t, pair.b.xy, context),
               Interrupted);
  EXPECT_THROW((void)localise_in_order(pair.a.xy, pair.b.t, pair.b.xy, context), Interrupted);
}

}  // namespace
}  // namespace isopach::test
