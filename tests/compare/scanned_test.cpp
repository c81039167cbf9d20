// Where the map is hatched: what one scan alone has points for, not what the hulls bridge.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "isopach/compare/compare.hpp"
#include "isopach/overlay/border.hpp"
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

/// Points of the square 0…100 but in a lagoon, whose shore differs a little from scan to scan; up to x = `end`.
Points dry(std::size_t n, std::uint64_t seed, double turn, double end) {
  Points points;
  for (const Point2& p : uniform(n, seed)) {
    const Point2 at{100 * p.x, 100 * p.y};
    const double angle = std::atan2(at.y - 50, at.x - 40);
    if (std::hypot(at.x - 40, at.y - 50) > 25 + 2 * std::sin(7 * angle + turn) && at.x < end) points.push_back(at);
  }
  return points;
}

/// Whether a scan by itself has a place within its border.
class Within {
 public:
  explicit Within(const Points& points)
      : s_(triangulate_unsorted(points, {})), f_(footprint(s_.triangulation, s_.xy, true, {}, {})) {}
  [[nodiscard]] bool operator()(const Point2& p) const {
    for (Index t = 0; t < s_.triangulation.real; ++t) {
      const auto& v = s_.triangulation.triangles[t].v;
      bool in = f_.keeps(t);
      for (std::size_t k = 0; k < 3 && in; ++k) {
        const Point2 &a = s_.xy[v[k]], &b = s_.xy[v[(k + 1) % 3]];
        in = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0;
      }
      if (in) return true;
    }
    return false;
  }

 private:
  SortedTriangulation s_;
  Footprint f_;
};

TEST(Scanned, EveryPixelIsWhatTheBordersOfBothScansSay) {
  // Of a lagoon that both lack; the coarse scan's border runs through cells between the shores.
  struct Case {
    std::size_t a, b;
    std::uint64_t seed;
  };
  for (const Case& x : {Case{150, 3000, 1}, Case{3000, 200, 2}, Case{400, 400, 3}, Case{80, 1500, 4}}) {
    const Points a = dry(x.a, x.seed, 0, 101), b = dry(x.b, x.seed + 100, 2, 85);
    const auto flat = [](const Point2&) { return 1; };
    CompareOptions o;
    o.check_layers = false;
    const Comparison c = compare(cloud_over(a, flat), cloud_over(b, flat), o, {});
    const Point3 corner = c.frame.to_field({0.013, 100.017, 0});
    const CellRaster raster = rasterise(c.cells, {corner.x, corner.y, 1, 100, 100});
    const Within in_a(a), in_b(b);
    std::size_t hatched = 0, wrong = 0;
    for (std::size_t i = 0; i < raster.cover.size(); ++i) {
      const Point2 p{0.513 + static_cast<double>(i % 100), 99.517 - static_cast<double>(i / 100)};
      const int scans = (in_a(p) ? 1 : 0) + (in_b(p) ? 1 : 0);
      const Cover expected = scans == 2 ? Cover::domain : scans == 1 ? Cover::footprint : Cover::none;
      hatched += expected == Cover::footprint ? 1 : 0;
      wrong += raster.cover[i] != expected ? 1 : 0;
    }
    EXPECT_GT(hatched, 1000u);
    EXPECT_EQ(wrong, 0u) << x.a << " and " << x.b << " points";
  }
}

TEST(Scanned, UnderTheHullRuleTheHullCounts) {
  const Seen s = seen(BorderRule::hull);
  EXPECT_EQ(s.bay, Cover::domain);
  EXPECT_EQ(s.of_a, Cover::footprint);
}

}  // namespace
}  // namespace isopach::test
