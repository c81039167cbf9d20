#include "isopach/geom/trapezoids.hpp"

#include <gtest/gtest.h>

#include "tests/support/polygons.hpp"

namespace isopach {
namespace {

using test::edges_of;
using test::Ring;
using test::Rings;

double total_area(const std::vector<Trapezoid>& parts) {
  double area = 0;
  for (const Trapezoid& t : parts) area += area_of(t);
  return area;
}

int parts_holding(const std::vector<Trapezoid>& parts, const Point2& p) {
  int count = 0;
  for (const Trapezoid& t : parts)
    count += t.x0 < p.x && p.x <= t.x1 && height_at(t.lower, p.x) < p.y && p.y < height_at(t.upper, p.x) ? 1 : 0;
  return count;
}

Ring square(double x, double y, double side) { return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}}; }

TEST(Trapezoids, SquareIsOne) {
  const auto parts = trapezoids(edges_of({square(1, 2, 3)}));
  ASSERT_TRUE(parts);
  ASSERT_EQ(parts->size(), 1u);
  EXPECT_EQ(area_of(parts->front()), 9);
}

TEST(Trapezoids, HolesPartsAndTouchingRingsCountEvenOdd) {
  // A hole that touches the shell in a corner, an island in the hole, a second part that meets the first in a point, a
  // third that shares a part of a side with it.
  const Rings rings{{{0, 0}, {10, 0}, {10, 10}, {0, 10}},
                    {{0, 0}, {6, 2}, {6, 6}, {2, 6}},
                    square(4, 4, 1),
                    square(10, 10, 5),
                    {{10, 0}, {14, 0}, {14, 9}, {10, 9}}};
  const auto parts = trapezoids(edges_of(rings));
  ASSERT_TRUE(parts);
  const double hole = 0.5 * (0 * 2 - 6 * 0 + 6 * 6 - 6 * 2 + 6 * 6 - 2 * 6 + 2 * 0 - 0 * 6);
  EXPECT_DOUBLE_EQ(total_area(*parts), 100 - hole + 1 + 25 + 36);
}

TEST(Trapezoids, PointsLieInOneTrapezoidOrNone) {
  const RandomStream random(7, 1);
  for (std::uint64_t round = 0; round < 300; ++round) {
    const std::uint64_t at = round * 10000;
    const double step = round % 3 == 1 ? 1.0 / 16 : round % 3 == 2 ? 1.0 / 4 : 0;
    const double far = round % 5 == 4 ? 1048576 : 0;
    Rings rings{test::star(random, at, {far, far}, 1 + static_cast<double>(round % 7), 5 + round % 60, step)};
    if (round % 2 == 1) rings.push_back(test::star(random, at + 500, {far, far}, 0.3, 3 + round % 9, step / 8));
    if (!test::is_valid(rings)) continue;
    const auto parts = trapezoids(edges_of(rings));
    ASSERT_TRUE(parts) << round;
    EXPECT_NEAR(total_area(*parts), test::area_of(std::make_unique<OGRPolygon>(test::to_ogr(rings)).get()),
                far > 0 ? 1e-8 : 1e-12);
    for (std::uint64_t k = 0; k < 200; ++k) {
      const Point2 p{far + 8 * (random.uniform(at + 1000 + 2 * k) - 0.5),
                     far + 8 * (random.uniform(at + 1001 + 2 * k) - 0.5)};
      ASSERT_EQ(parts_holding(*parts, p), test::inside(rings, p) ? 1 : 0) << round << " " << k;
    }
  }
}

TEST(Trapezoids, OrderAndSenseOfEdgesDoNotMatter) {
  const RandomStream random(3, 2);
  std::vector<Edge> edges = edges_of({test::star(random, 0, {0, 0}, 3, 40)});
  const auto expected = trapezoids(edges);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    std::swap(edges[i], edges[static_cast<std::size_t>(random.uniform(500 + i) * static_cast<double>(edges.size()))]);
    if (random.uniform(900 + i) < 0.5) std::swap(edges[i].a, edges[i].b);
  }
  const auto found = trapezoids(edges);
  ASSERT_TRUE(expected && found);
  ASSERT_EQ(found->size(), expected->size());
  for (std::size_t i = 0; i < found->size(); ++i) EXPECT_EQ((*found)[i].lower.a, (*expected)[i].lower.a);
}

TEST(Trapezoids, WhatBoundsNothingIsRefused) {
  Point2 at{};
  EXPECT_FALSE(trapezoids(edges_of({{{0, 0}, {2, 2}, {2, 0}, {0, 2}}}), &at));  // a bow tie
  EXPECT_FALSE(trapezoids(edges_of({square(0, 0, 2), square(1, 1, 2)})));       // rings that cross
  EXPECT_FALSE(trapezoids(edges_of({square(0, 0, 2), square(1, 2, 2)})));       // a side partly on another
  EXPECT_FALSE(trapezoids({{{0, 0}, {1, 0}}, {{1, 0}, {2, 1}}}));               // not closed
  EXPECT_FALSE(trapezoids(edges_of({{{0, 0}, {4, 0}, {4, 4}, {2, -1}, {0, 4}}})));
  const auto nothing = trapezoids({});
  ASSERT_TRUE(nothing);
  EXPECT_TRUE(nothing->empty());
}

TEST(Trapezoids, CrossingRingsAreFoundWheneverThereAreAny) {
  const RandomStream random(11, 4);
  int valid = 0, crossing = 0;
  for (std::uint64_t round = 0; round < 400; ++round) {
    Ring ring;  // any closed chain of points on a coarse grid: degenerate in every way
    for (std::uint64_t k = 0; k < 4 + round % 5; ++k)
      ring.push_back({std::floor(6 * random.uniform(round * 100 + 2 * k)),
                      std::floor(6 * random.uniform(round * 100 + 2 * k + 1))});
    const bool good = test::is_valid({ring});
    (good ? valid : crossing) += 1;
    const auto parts = trapezoids(edges_of({ring}));
    if (good) {
      EXPECT_TRUE(parts) << round;
    }
    if (!parts) continue;  // what is accepted beside (rings that touch themselves, doubled edges) must count even-odd
    for (std::uint64_t k = 0; k < 100; ++k) {
      const Point2 p{6 * random.uniform(90000 + round * 300 + 2 * k), 6 * random.uniform(90001 + round * 300 + 2 * k)};
      ASSERT_EQ(parts_holding(*parts, p), test::inside({ring}, p) ? 1 : 0) << round << " " << k;
    }
  }
  EXPECT_GT(valid, 40);
  EXPECT_GT(crossing, 40);
}

}  // namespace
}  // namespace isopach
