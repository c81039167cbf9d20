// The overlay as one mesh: the same area and volumes as its cells, every corner once, no gaps between the cells.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "isopach/base/parallel.hpp"
#include "isopach/measure/source.hpp"
#include "tests/overlay/couple.hpp"

namespace isopach::test {
namespace {

Couple couple_of(const Points& a, const Points& b) { return {rough(a, 3), rough(b, 4)}; }

Points shifted(Points points, double by) {
  for (Point2& p : points) p = {p.x + by, p.y + by};
  return points;
}

struct Totals {
  double area = 0, above = 0, below = 0;
};
Totals totals(const OverlaySurface& s) {
  Totals sum;
  for (const auto& v : s.triangles) {
    const Cell cell{triangle_area(s.xy[v[0]], s.xy[v[1]], s.xy[v[2]]),
                    {s.z2[v[0]] - s.z1[v[0]], s.z2[v[1]] - s.z1[v[1]], s.z2[v[2]] - s.z1[v[2]]}};
    const isopach::Parts parts = split_volume(cell);
    sum.area += cell.area, sum.above += parts.above, sum.below += parts.below;
  }
  return sum;
}

/// A hub and nodes round it.
Points wheel(std::size_t n, double from) {
  Points points{{0, 0}};
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = from + 6.283 * static_cast<double>(i) / static_cast<double>(n);
    points.push_back({std::cos(angle), std::sin(angle)});
  }
  return points;
}

struct Case {
  const char* name;
  Points a, b;
};
const std::vector<Case>& cases() {
  static const std::vector<Case> all{{"Uniform", uniform(300, 1), uniform(200, 2)},
                                     {"CrossingHulls", uniform(300, 1), shifted(uniform(200, 2), 0.4)},
                                     {"OneInside", uniform(30, 1), shifted(grid(9, 0), 0.01)},
                                     {"Grids", grid(100, 0), grid(225, 0)},
                                     {"SharedNodes", uniform(200, 1), uniform(100, 1)},
                                     {"OneHub", wheel(70, 0), wheel(90, 0.3)},
                                     {"EqualWheels", wheel(80, 0), wheel(80, 0)},
                                     {"LargeTriangles", uniform(4, 5), uniform(500, 2)}};
  return all;
}

class OverlaySurfaces : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Pairs, OverlaySurfaces, testing::ValuesIn(cases()),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(OverlaySurfaces, HasTheAreaAndVolumesOfTheCells) {
  const Couple couple = couple_of(GetParam().a, GetParam().b);
  const Overlay overlay = couple.overlay();
  const Measures m = sum_up(overlay, {});
  const Totals found = totals(overlay.surface({}));
  ASSERT_GT(m.area, 0);
  EXPECT_NEAR(found.area, m.area, 1e-12 * m.area);
  EXPECT_NEAR(found.above, m.volume.above, 1e-11 * m.volume.absolute);
  EXPECT_NEAR(found.below, m.volume.below, 1e-11 * m.volume.absolute);
}

TEST(OverlaySurface, OfNodesInGeneralPositionHasNoGapsAndEachCornerOnce) {
  const Couple couple = couple_of(uniform(400, 1), uniform(300, 2));
  const OverlaySurface s = couple.overlay().surface({});
  std::map<std::pair<Index, Index>, int> sides;
  for (const auto& v : s.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index from = v[k], to = v[(k + 1) % 3];
      EXPECT_EQ(++sides[(std::pair{from, to})], 1) << "two triangles on one side of an edge";
    }
  std::size_t rim = 0;
  for (const auto& [side, count] : sides) rim += sides.count({side.second, side.first}) == 0 ? 1 : 0;
  // Euler: V − E + F = 1 for a disc, E = (3 F + rim) / 2.
  const std::size_t faces = s.triangles.size(), edges = (3 * faces + rim) / 2;
  EXPECT_EQ(s.xy.size() + faces, edges + 1);
  std::set<std::pair<double, double>> places;
  for (const Point2& p : s.xy) EXPECT_TRUE(places.emplace(p.x, p.y).second) << "a corner stands there twice";
}

TEST(OverlaySurface, LeavesOutWhatIsNotKept) {
  Couple couple = couple_of(uniform(200, 1), uniform(300, 2));
  Random random(7);
  for (Index t = 0; t < couple.a.mesh.triangulation.real; ++t) couple.kept_a.push_back(random.below(4) != 0);
  for (Index t = 0; t < couple.b.mesh.triangulation.real; ++t) couple.kept_b.push_back(random.below(4) != 0);
  const Overlay overlay = couple.overlay();
  const Measures m = sum_up(overlay, {});
  EXPECT_NEAR(totals(overlay.surface({})).area, m.area, 1e-12 * m.area);
}

TEST(OverlaySurface, HasTheSameBitsForAnyNumberOfThreads) {
  const Couple couple = couple_of(uniform(3000, 1), uniform(2000, 2));
  OverlaySurface first;
  for (const int threads : {1, 2, 7}) {
    OverlaySurface s;
    run_with_threads(threads, [&] { s = couple.overlay().surface({}); });
    if (threads == 1) first = s;
    EXPECT_EQ(s.xy, first.xy);
    EXPECT_EQ(s.z1, first.z1);
    EXPECT_EQ(s.z2, first.z2);
    EXPECT_EQ(s.triangles, first.triangles);
  }
}

TEST(OverlaySurface, OfDisjointHullsIsEmpty) {
  const Couple couple = couple_of(uniform(30, 1), shifted(uniform(30, 2), 5));
  EXPECT_TRUE(couple.overlay().surface({}).triangles.empty());
}

}  // namespace
}  // namespace isopach::test
