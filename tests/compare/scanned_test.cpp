// Where the map is hatched: what one scan alone has points for, not what the hulls bridge.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "isopach/compare/compare.hpp"
#include "isopach/report/draw/raster.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

/// Points of the square 0…100 that are inside.
Cloud sampled(std::uint64_t seed, const std::function<bool(double, double)>& inside) {
  Points points;
  for (const Point2& p : uniform(6000, seed))
    if (inside(100 * p.x, 100 * p.y)) points.push_back({100 * p.x, 100 * p.y});
  return cloud_over(points, [](const Point2&) { return 1; });
}

CellRaster::Cover cover_at(const CellRaster& raster, const Frame& frame, double x, double y) {
  const Point3 p = frame.to_field({x, y, 0});
  const auto column = static_cast<std::size_t>((p.x - raster.view.left) * raster.view.scale),
             row = static_cast<std::size_t>((raster.view.top - p.y) * raster.view.scale);
  return raster.cover[row * static_cast<std::size_t>(raster.view.columns) + column];
}

using Cover = CellRaster::Cover;

struct Seen {
  Cover domain, of_a, of_b, bay, hole;
};
Seen seen(BorderRule border) {
  // Both are an L whose inner corner is at (40, 40), with a hole at (20, 70) that both have; A ends at x = 70, B at
  // y = 85.
  const auto shared = [](double x, double y) { return (x < 40 || y < 40) && std::hypot(x - 20, y - 70) > 8; };
  CompareOptions o;
  o.check_layers = false;
  o.border = border;
  const Comparison c = compare(sampled(1, [&](double x, double y) { return shared(x, y) && x < 70; }),
                               sampled(2, [&](double x, double y) { return shared(x, y) && y < 85; }), o, {});
  const Point3 corner = c.frame.to_field({0, 100, 0});
  const CellRaster raster = rasterise(c.cells, {corner.x, corner.y, 2, 200, 200});
  const auto at = [&](double x, double y) { return cover_at(raster, c.frame, x, y); };
  return {at(20, 20), at(20, 93), at(85, 20), at(55, 50), at(20, 70)};
}

TEST(Scanned, HatchedIsWhatOneScanHasPointsFor) {
  const Seen s = seen(BorderRule::trim);
  EXPECT_EQ(s.domain, Cover::domain);
  EXPECT_EQ(s.of_a, Cover::footprint);
  EXPECT_EQ(s.of_b, Cover::footprint);
  EXPECT_EQ(s.bay, Cover::none) << "in both hulls, sampled by neither";
  EXPECT_EQ(s.hole, Cover::none) << "a hole in both";
}

/// The largest distance from a hatched place to the nearest point of either scan: of a lagoon of radius 25 that neither
/// scan has points in, and whose shores differ a little between them; A alone goes on to x = 100.
double farthest_hatched(std::uint64_t seed) {
  const auto dry = [](double x, double y, double turn) {
    const double angle = std::atan2(y - 50, x - 40);
    return std::hypot(x - 40, y - 50) > 25 + 2 * std::sin(7 * angle + turn);
  };
  const Cloud a = sampled(seed, [&](double x, double y) { return dry(x, y, 0); });
  const Cloud b = sampled(seed + 100, [&](double x, double y) { return dry(x, y, 2) && x < 85; });
  CompareOptions o;
  o.check_layers = false;
  const Comparison c = compare(a, b, o, {});
  const Point3 corner = c.frame.to_field({0, 100, 0});
  const CellRaster raster = rasterise(c.cells, {corner.x, corner.y, 1, 100, 100});
  double farthest = 0;
  for (std::size_t i = 0; i < raster.cover.size(); ++i) {
    if (raster.cover[i] != Cover::footprint) continue;
    const double x = static_cast<double>(i % 100) + 0.5, y = 99.5 - static_cast<double>(i / 100);
    double nearest = 1e9;
    for (const Cloud* cloud : {&a, &b})
      for (const Point3& p : cloud->points) nearest = std::min(nearest, std::hypot(p.x - x, p.y - y));
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

TEST(Scanned, NoPlaceOfALagoonIsHatched) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const double farthest = farthest_hatched(seed);
    EXPECT_GT(farthest, 0) << "what A alone has points for is hatched";
    EXPECT_LT(farthest, 4) << "points lie 1.3 apart; seed " << seed;
  }
}

TEST(Scanned, UnderTheHullRuleTheHullCounts) {
  const Seen s = seen(BorderRule::hull);
  EXPECT_EQ(s.bay, Cover::domain);
  EXPECT_EQ(s.of_a, Cover::footprint);
}

}  // namespace
}  // namespace isopach::test
