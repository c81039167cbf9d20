#include "isopach/overlay/regions.hpp"

#include <gtest/gtest.h>

#include "tests/support/polygons.hpp"

namespace isopach {
namespace {

using test::edges_of;
using test::Ring;
using test::Rings;

Region region_of(const Rings& rings) {
  auto parts = trapezoids(edges_of(rings));
  EXPECT_TRUE(parts);
  return {edges_of(rings), *parts};
}

ConvexCell cell_of(const Point2& a, const Point2& b, const Point2& c) {
  ConvexCell cell;
  for (const Point2& p : {a, b, c}) cell.add({p.x, p.y, p.x - 2 * p.y, 3 * p.x + p.y + 1});  // two planes
  return cell;
}

double area_of(const std::vector<ConvexCell>& cells) {
  double area = 0;
  for (const ConvexCell& c : cells) area += c.area();
  return area;
}

// Both surfaces stay on their planes.
void expect_on_planes(const std::vector<ConvexCell>& cells, double size) {
  for (const ConvexCell& cell : cells)
    for (unsigned k = 0; k < cell.corners; ++k) {
      const Corner& c = cell.at[k];
      EXPECT_NEAR(c.z1, c.x - 2 * c.y, 1e-14 * size);
      EXPECT_NEAR(c.z2, 3 * c.x + c.y + 1, 1e-14 * size);
    }
}

// Random polygons with holes against random triangles: every pair by GEOS, and the union.
void compare_with_geos(std::uint64_t seed, double step, double far, std::size_t expected_cells) {
  const RandomStream random(seed, 1);
  std::vector<Region> regions;
  std::vector<OGRPolygon> polygons;
  test::Geometry all = std::make_unique<OGRPolygon>();
  for (std::uint64_t i = 0; regions.size() < 12; ++i) {
    const std::uint64_t at = i * 1000;
    const Point2 centre{far + std::round(16 * random.uniform(at)) / 4,
                        far + std::round(16 * random.uniform(at + 1)) / 4};
    Rings rings{test::star(random, at + 10, centre, 0.3 + 1.5 * random.uniform(at + 2), 4 + i % 20, step)};
    if (i % 3 == 0) rings.push_back(test::star(random, at + 300, centre, 0.1, 5, step / 8));
    if (!test::is_valid(rings)) continue;
    regions.push_back(region_of(rings));
    polygons.push_back(test::to_ogr(rings));
    all.reset(all->Union(&polygons.back()));
  }
  const std::size_t count = regions.size();
  const Regions found(std::move(regions), expected_cells);
  Regions::Scratch scratch;
  for (std::uint64_t k = 0; k < 150; ++k) {
    const std::uint64_t at = 100000 + 10 * k;
    const double size = k % 3 == 0 ? 4 : k % 3 == 1 ? 0.5 : 0.05;
    std::array<Point2, 3> p{};
    for (std::size_t j = 0; j < 3; ++j) {
      p[j] = {far + 4 * random.uniform(at) + size * (random.uniform(at + 2 + 2 * j) - 0.5),
              far + 4 * random.uniform(at + 1) + size * (random.uniform(at + 3 + 2 * j) - 0.5)};
      if (step > 0) p[j] = {std::round(p[j].x / step) * step, std::round(p[j].y / step) * step};
    }
    if ((p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (p[1].y - p[0].y) < 0) std::swap(p[1], p[2]);
    const ConvexCell cell = cell_of(p[0], p[1], p[2]);
    if (!(cell.area() > 0)) continue;
    const test::Geometry triangle = test::triangle(p[0], p[1], p[2]);
    const double exact_to = 1e-12 * std::max(1.0, far);

    std::vector<double> shared(count, 0);
    found.for_pieces(cell, scratch, [&](Index region, const ConvexCell& piece) { shared[region] += piece.area(); });
    for (std::size_t r = 0; r < count; ++r)
      ASSERT_NEAR(shared[r], test::shared_area(*triangle, polygons[r]), exact_to) << seed << " " << k << " " << r;

    std::vector<ConvexCell> inside, outside;
    const Regions::Answer answer = found.split(cell, scratch, inside, outside);
    const double expected = test::shared_area(*triangle, *all);
    if (answer == Regions::Answer::all) {
      ASSERT_NEAR(expected, cell.area(), exact_to);
    }
    if (answer == Regions::Answer::none) {
      ASSERT_NEAR(expected, 0, exact_to);
    }
    if (answer != Regions::Answer::some) continue;
    ASSERT_NEAR(area_of(inside), expected, exact_to) << seed << " " << k;
    ASSERT_NEAR(area_of(inside) + area_of(outside), cell.area(), exact_to);
    expect_on_planes(inside, 10 + 4 * far);
    expect_on_planes(outside, 10 + 4 * far);
  }
}

TEST(Regions, AsByGeosOnRandomPolygons) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) compare_with_geos(seed, 0, 0, seed % 2 == 0 ? 10 : 2000000);
}
TEST(Regions, AsByGeosWhereCornersAndSidesMeet) {
  for (std::uint64_t seed = 21; seed <= 26; ++seed) compare_with_geos(seed, 1.0 / 8, 0, seed % 2 == 0 ? 10 : 100000);
}
TEST(Regions, AsByGeosFarFromTheOrigin) {
  for (std::uint64_t seed = 31; seed <= 33; ++seed) compare_with_geos(seed, 0, 1 << 20, 10000);
}

// A cell over thousands of parts: halved until few are left.
TEST(Regions, OneCellOverManyRegions) {
  std::vector<Region> regions;
  double expected = 0;
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 40; ++j) {
      if ((i + j) % 3 == 0) continue;
      const double x = i, y = j, side = (i * j) % 2 == 0 ? 1 : 0.5;
      regions.push_back(region_of({{{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}}}));
      expected += side * side;
    }
  const Regions found(std::move(regions), 2);
  Regions::Scratch scratch;
  std::vector<ConvexCell> inside, outside;
  const ConvexCell cell = cell_of({-10, -10}, {100, -10}, {-10, 100});
  ASSERT_EQ(found.split(cell, scratch, inside, outside), Regions::Answer::some);
  EXPECT_NEAR(area_of(inside), expected, 1e-9);
  EXPECT_NEAR(area_of(inside) + area_of(outside), cell.area(), 1e-9);
}

TEST(Regions, WithoutRegionsNothingIsMet) {
  const Regions none({}, 10);
  Regions::Scratch scratch;
  std::vector<ConvexCell> inside, outside;
  EXPECT_EQ(none.split(cell_of({0, 0}, {1, 0}, {0, 1}), scratch, inside, outside), Regions::Answer::none);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace isopach
