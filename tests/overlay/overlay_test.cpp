// The exact overlay against clipping all pairs of triangles; sums of areas; equal meshes; closed forms; threads;
// exchange; parts left out.
#include "isopach/overlay/overlay.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/overlay/hulls.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"
#include "tests/overlay/couple.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

// The oracle: every triangle of one mesh clipped by every triangle of the other, in long double.
struct Corner {
  long double x, y, d;
};
using Polygon = std::vector<Corner>;

long double turn(const Point2& a, const Point2& b, long double x, long double y) {
  return (static_cast<long double>(b.x) - a.x) * (y - a.y) - (static_cast<long double>(b.y) - a.y) * (x - a.x);
}

template <class F>
Polygon keep(const Polygon& polygon, const F& side) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const long double s = side(p), t = side(q);
    if (s >= 0) kept.push_back(p);
    if ((s > 0 && t < 0) || (s < 0 && t > 0)) {
      const long double u = s / (s - t);
      kept.push_back({p.x + u * (q.x - p.x), p.y + u * (q.y - p.y), p.d + u * (q.d - p.d)});
    }
  }
  return kept;
}

using Triangle3 = std::array<Point2, 3>;

long double plane(const Triangle3& t, const std::array<double, 3>& z, long double x, long double y) {
  const long double w0 = turn(t[1], t[2], x, y), w1 = turn(t[2], t[0], x, y), w2 = turn(t[0], t[1], x, y);
  return (w0 * z[0] + w1 * z[1] + w2 * z[2]) / (w0 + w1 + w2);
}

void add_integrals(const Polygon& polygon, Parts& total) {
  const auto integral = [](const Polygon& p) {
    long double sum = 0;
    for (std::size_t i = 1; i + 1 < p.size(); ++i) {
      const long double area =
          ((p[i].x - p[0].x) * (p[i + 1].y - p[0].y) - (p[i].y - p[0].y) * (p[i + 1].x - p[0].x)) / 2;
      sum += area * (p[0].d + p[i].d + p[i + 1].d) / 3;
    }
    return sum;
  };
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    total.area += ((polygon[i].x - polygon[0].x) * (polygon[i + 1].y - polygon[0].y) -
                   (polygon[i].y - polygon[0].y) * (polygon[i + 1].x - polygon[0].x)) /
                  2;
  total.above += integral(keep(polygon, [](const Corner& c) { return c.d; }));
  total.below -= integral(keep(polygon, [](const Corner& c) { return -c.d; }));
}

struct Piece {
  Triangle3 p;
  std::array<double, 3> z;
  Box2 box;
};

std::vector<Piece> pieces(const Surface& s, const std::vector<unsigned char>& kept) {
  std::vector<Piece> all;
  for (Index t = 0; t < s.mesh.triangulation.real; ++t) {
    if (!kept.empty() && kept[t] == 0) continue;
    Piece piece{};
    piece.box = {};
    for (std::size_t k = 0; k < 3; ++k) {
      const Index v = s.mesh.triangulation.triangles[t].v[k];
      piece.p[k] = s.mesh.xy[v];
      piece.z[k] = s.z[v];
      piece.box.add(piece.p[k]);
    }
    all.push_back(piece);
  }
  return all;
}

Parts brute_overlay(const Couple& couple) {
  Parts total;
  const std::vector<Piece> second = pieces(couple.b, couple.kept_b);
  for (const Piece& t : pieces(couple.a, couple.kept_a))
    for (const Piece& s : second) {
      if (t.box.min.x >= s.box.max.x || s.box.min.x >= t.box.max.x || t.box.min.y >= s.box.max.y ||
          s.box.min.y >= t.box.max.y)
        continue;
      Polygon part;
      for (const Point2& p : t.p) part.push_back({p.x, p.y, 0});
      for (std::size_t k = 0; k < 3 && part.size() > 2; ++k)
        part = keep(part, [&](const Corner& c) { return turn(s.p[k], s.p[(k + 1) % 3], c.x, c.y); });
      if (part.size() < 3) continue;
      for (Corner& c : part) c.d = plane(s.p, s.z, c.x, c.y) - plane(t.p, t.z, c.x, c.y);
      add_integrals(part, total);
    }
  return total;
}

void expect_equals_brute(const Couple& couple) {
  const Parts expected = brute_overlay(couple);
  const Measures found = sum_up(couple.overlay(), {});
  const double volume = static_cast<double>(expected.above + expected.below);
  EXPECT_NEAR(found.area, static_cast<double>(expected.area), 1e-12 * static_cast<double>(expected.area));
  EXPECT_NEAR(found.volume.above, static_cast<double>(expected.above), 1e-9 * volume);
  EXPECT_NEAR(found.volume.below, static_cast<double>(expected.below), 1e-9 * volume);
  EXPECT_NEAR(found.volume.net, static_cast<double>(expected.above - expected.below), 1e-9 * volume);
  EXPECT_NEAR(found.rho * found.area, volume, 1e-9 * volume);
}

Points moved(Points points, double scale, double x, double y) {
  for (Point2& p : points) p = {p.x * scale + x, p.y * scale + y};
  return points;
}
Points lattice(std::size_t n, double step, double x, double y) { return moved(grid(n, 0), step, x, y); }
Points joined(Points a, const Points& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
Points some_of(const Points& points, std::uint64_t of_ten, std::uint64_t seed) {
  Random random(seed);
  Points kept;
  for (const Point2& p : points)
    if (random.below(10) < of_ten) kept.push_back(p);
  return kept;
}
/// Two heaps of nodes, far apart along x or along y: two such hulls cross without a node of one in the other.
Points dumbbell(std::size_t n, std::uint64_t seed, bool along_x) {
  Points points = uniform(n, seed);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].x += i % 2 == 0 ? 5 : -5;
    if (!along_x) std::swap(points[i].x, points[i].y);
  }
  return points;
}
/// Nothing nearer to the centre of the unit square than 0.4.
Points ring(std::size_t n, std::uint64_t seed) {
  Points points;
  for (const Point2& p : uniform(n, seed))
    if (std::hypot(p.x - 0.5, p.y - 0.5) > 0.4) points.push_back(p);
  return points;
}

/// A hub and nodes around it, the first of a turn of 1 at `from`; rays of uneven length where rough.
Points wheel(std::size_t n, double from, double turn, std::uint64_t seed, double uneven) {
  Random random(seed);
  Points points{{0, 0}};
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 6.283185307 * (from + turn * static_cast<double>(i) / static_cast<double>(n)),
                 length = 1 + uneven * random.uniform();
    points.push_back({length * std::cos(angle), length * std::sin(angle)});
  }
  return points;
}
/// The origin is a hub of all of them.
Points parabola(std::size_t n, double along_x, double height) {
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(n);
    points.push_back({along_x * x, height * x * x});
  }
  return points;
}
std::size_t few(std::size_t n) { return 40 + n % 60; }  // for meshes that the oracle is slow with

struct PairFamily {
  const char* name;
  std::pair<Points, Points> (*make)(std::size_t n, std::size_t m, std::uint64_t seed);
};
const PairFamily pair_families[] = {
    {"uniform",
     [](auto n, auto m, auto seed) {
       return std::pair{uniform(n, seed), uniform(m, seed + 1)};
     }},
    {"shared_nodes",
     [](auto n, auto m, auto seed) {
       const Points a = uniform(n, seed);
       return std::pair{a, joined(some_of(a, 5, seed), uniform(m / 2, seed + 1))};
     }},
    {"shared_edges",
     [](auto n, auto, auto seed) {
       const Points a = uniform(n, seed);
       return std::pair{some_of(a, 9, seed), some_of(a, 9, seed + 1)};
     }},
    {"grids_on_one_lattice",
     [](auto n, auto m, auto) {
       return std::pair{lattice(n, 1, 0, 0), lattice(m, 1, 3, 2)};
     }},
    {"grid_of_another_step",
     [](auto n, auto m, auto) {
       return std::pair{lattice(n, 1, 0, 0), lattice(m, 2, -4, 1)};
     }},
    {"grid_between_lines",
     [](auto n, auto m, auto) {
       return std::pair{lattice(n, 1, 0, 0), lattice(m, 1, 0.5, 0)};
     }},
    {"grid_and_turned_grid",
     [](auto n, auto m, auto seed) {
       return std::pair{grid(n, seed), rotated_grid(m, seed)};
     }},
    {"nearly_equal_grids",
     [](auto n, auto m, auto seed) {
       return std::pair{near_degenerate(n, seed), near_degenerate(m, seed + 1)};
     }},
    {"inside",
     [](auto n, auto m, auto seed) {
       return std::pair{uniform(n, seed), moved(uniform(m, seed + 1), 0.2, 0.3, 0.4)};
     }},
    {"in_few_triangles",
     [](auto n, auto m, auto seed) {
       return std::pair{ring(n, seed), moved(uniform(m, seed + 1), 0.1, 0.45, 0.45)};
     }},
    {"hulls_that_cross",
     [](auto n, auto m, auto seed) {
       return std::pair{dumbbell(n, seed, true), dumbbell(m, seed + 1, false)};
     }},
    {"touching_edge",
     [](auto n, auto m, auto seed) {
       return std::pair{joined(lattice(n, 1, 0, 0), moved(uniform(m, seed), 5, 0, 0)), lattice(m, 1, 4, 0)};
     }},
    {"few_lines",
     [](auto n, auto m, auto seed) {
       return std::pair{few_lines(n, seed), few_lines(m, seed + 1)};
     }},
    {"coarse_lattice",
     [](auto n, auto m, auto seed) {
       return std::pair{coarse_lattice(n, seed), coarse_lattice(m, seed + 1)};
     }},
    {"circles",
     [](auto n, auto m, auto seed) {
       return std::pair{concentric(n, seed), concentric(m, seed + 1)};
     }},
    {"clusters",
     [](auto n, auto m, auto seed) {
       return std::pair{clustered(n, seed), clustered(m, seed + 1)};
     }},
    {"wheels_on_one_hub",
     [](auto n, auto m, auto seed) {
       return std::pair{wheel(few(n), 0, 1, seed, 0.01), wheel(few(m), 0.3, 1, seed + 1, 0.01)};
     }},
    {"equal_wheels",
     [](auto n, auto, auto seed) {
       return std::pair{wheel(few(n), 0, 1, seed, 0), wheel(few(n), 0, 1, seed, 0)};
     }},
    {"fans_on_one_hub",
     [](auto n, auto m, auto seed) {
       const auto start = 0.1 * static_cast<double>(seed % 1000 / 100);
       return std::pair{wheel(few(n), start, 0.4, seed, 0), wheel(few(m), start + 0.2, 0.4, seed, 0)};
     }},
    {"equal_parabolas",
     [](auto n, auto, auto seed) {
       const double x = seed % 200 == 0 ? 1 : -1, y = seed % 300 == 0 ? 2 : -2;
       return std::pair{parabola(few(n), x, y), parabola(few(n), x, y)};
     }},
    {"parabolas_of_some_common_nodes",
     [](auto n, auto, auto seed) {
       const double x = seed % 200 == 0 ? 1 : -1, y = seed % 300 == 0 ? 2 : -2;
       const Points all = parabola(3 * few(n), x, y);
       return std::pair{joined({{0, 0}}, some_of(all, 6, seed)), joined({{0, 0}}, some_of(all, 6, seed + 1))};
     }},
    {"wheels_with_other_nodes",
     [](auto n, auto m, auto seed) {
       return std::pair{joined(wheel(few(n), 0, 1, seed, 0), moved(uniform(m % 50, seed), 0.4, 0.6, 0.5)),
                        joined(wheel(few(m), 0, 1, seed, 0), moved(uniform(n % 50, seed + 1), 0.5, -1, -1))};
     }},
};

class OverlayFamilies : public testing::TestWithParam<PairFamily> {
 protected:
  static Couple make(std::size_t n, std::size_t m, std::uint64_t seed) {
    const auto [a, b] = GetParam().make(n, m, seed);
    return {rough(a, seed + 7), rough(b, seed + 8)};
  }
};
INSTANTIATE_TEST_SUITE_P(Pairs, OverlayFamilies, testing::ValuesIn(pair_families),
                         [](const auto& family) { return family.param.name; });

TEST_P(OverlayFamilies, EqualsClippingAllPairs) {
  Random random(1);
  for (std::uint64_t seed = 1; seed <= 14; ++seed) {  // 14 · 22 pairs
    const auto size = [&] { return static_cast<std::size_t>(50 * std::pow(40, std::pow(random.uniform(), 2))); };
    const std::size_t n = size(), m = size();
    SCOPED_TRACE(testing::Message() << n << " and " << m << " nodes, seed " << seed);
    expect_equals_brute(make(n, m, 100 * seed));
  }
}

TEST_P(OverlayFamilies, AreasOfCellsAddUpToTheDomain) {
  const Couple couple = make(3000, 2500, 5);
  const double domain = couple.shared_hull();
  EXPECT_NEAR(sum_up(couple.overlay(), {}).area, domain, 1e-12 * domain);
}

TEST_P(OverlayFamilies, ExchangingTheMeshesMirrorsToTheLastBit) {
  for (const std::size_t m : {300, 800}) {
    const Couple couple = make(500, m, 9);
    const Measures forward = measure(couple.overlay(), {});
    const Measures back = measure(Overlay(couple.second(), couple.first(), {}), {});
    EXPECT_EQ(back.area, forward.area);
    EXPECT_EQ(back.volume.above, forward.volume.below);
    EXPECT_EQ(back.volume.below, forward.volume.above);
    EXPECT_EQ(back.difference.mean, -forward.difference.mean);
    EXPECT_EQ(back.difference.rms, forward.difference.rms);
    EXPECT_EQ(back.difference.max_above, forward.difference.max_below);
  }
}

TEST_P(OverlayFamilies, LeavesOutWhatIsNotKept) {
  Couple couple = make(150, 120, 11);
  Random random(12);
  for (Index t = 0; t < couple.a.mesh.triangulation.real; ++t) couple.kept_a.push_back(random.below(4) != 0 ? 1 : 0);
  for (Index t = 0; t < couple.b.mesh.triangulation.real; ++t) couple.kept_b.push_back(random.below(4) != 0 ? 1 : 0);
  expect_equals_brute(couple);
  couple.kept_a.clear();
  expect_equals_brute(couple);
}

TEST_P(OverlayFamilies, CellsAreConvexAndOfTheirTriangles) {
  const Couple couple = make(200, 260, 13);
  const Overlay overlay = couple.overlay();
  Overlay::Scratch scratch;
  std::vector<std::pair<Index, Index>> pairs;
  for (std::size_t i = 0; i < overlay.items(); ++i)
    for (const OverlayCell& c : overlay.cells(i, scratch)) {
      ASSERT_GE(c.corners, 3u);
      ASSERT_LE(c.corners, 6u);
      pairs.emplace_back(c.t1, c.t2);
      const auto turns = [&](const SortedTriangulation& mesh, Index t, unsigned k) {
        const auto& v = mesh.triangulation.triangles[t].v;
        const long double x = static_cast<long double>(c.origin.x) + c.x[k],
                          y = static_cast<long double>(c.origin.y) + c.y[k];
        long double least = 1;
        for (std::size_t s = 0; s < 3; ++s) {
          const Point2 &p = mesh.xy[v[s]], &q = mesh.xy[v[(s + 1) % 3]];
          least = std::min(least, turn(p, q, x, y) / std::hypot(q.x - p.x, q.y - p.y));
        }
        return static_cast<double>(least);
      };
      for (unsigned k = 0; k < c.corners; ++k) {
        EXPECT_GE(turns(couple.a.mesh, c.t1, k), -1e-9);  // distances, in families up to some 1000 wide
        EXPECT_GE(turns(couple.b.mesh, c.t2, k), -1e-9);
      }
    }
  std::sort(pairs.begin(), pairs.end());
  EXPECT_TRUE(std::adjacent_find(pairs.begin(), pairs.end()) == pairs.end()) << "a pair of triangles comes twice";
}

class OverlayPoints : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, OverlayPoints, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(OverlayPoints, EqualsCommonWhereTheMeshesAreEqual) {
  if (GetParam().collinear) return;
  const Points points = distinct(GetParam().make(2000, 21));
  const Couple couple(rough(points, 22), rough(points, 23));
  const std::vector<unsigned char> all(couple.a.mesh.triangulation.real, 1);
  const Measures expected =
      measure(CellView{couple.a.mesh.triangulation, couple.a.mesh.xy, couple.a.z, couple.b.z, all}, {});
  const Measures found = measure(couple.overlay(), {});
  // Areas of cells are rounded: what is lost is small beside the box, not beside a domain of slivers.
  Box2 box;
  for (const Point2& p : points) box.add(p);
  const double lost = 1e-15 * (box.max.x - box.min.x) * (box.max.y - box.min.y);
  EXPECT_NEAR(found.area, expected.area, 1e-12 * expected.area + lost);
  EXPECT_NEAR(found.volume.above, expected.volume.above, 1e-12 * expected.volume.absolute + lost);
  EXPECT_NEAR(found.volume.below, expected.volume.below, 1e-12 * expected.volume.absolute + lost);
  if (lost > 1e-12 * expected.area) return;
  EXPECT_NEAR(found.difference.rms, expected.difference.rms, 1e-12);
  EXPECT_EQ(found.difference.max_above, expected.difference.max_above);
  for (std::size_t i = 0; i < percentile_levels.size(); ++i)
    EXPECT_NEAR(found.difference.abs_percentiles[i], expected.difference.abs_percentiles[i], 1e-9);
}

TEST_P(OverlayPoints, OfCollinearNodesIsEmpty) {
  if (!GetParam().collinear) return;
  const Couple couple(rough(distinct(GetParam().make(100, 31)), 32), rough(uniform(100, 33), 34));
  EXPECT_EQ(sum_up(couple.overlay(), {}).area, 0);
  EXPECT_EQ(sum_up(Overlay(couple.second(), couple.first(), {}), {}).area, 0);
}

TEST(Overlay, HasTheSameBitsForAnyNumberOfThreads) {
  const Couple couple(rough(joined(uniform(20000, 41), moved(uniform(500, 42), 9, -4, -4)), 43),
                      rough(uniform(15000, 44), 45));
  const Measures expected = measure(couple.overlay(), {});
  for (const int threads : {1, 2, 7})
    run_with_threads(threads, [&] {
      const Measures m = measure(couple.overlay(), {});
      EXPECT_EQ(m.area, expected.area);
      EXPECT_EQ(m.volume.above, expected.volume.above);
      EXPECT_EQ(m.volume.below, expected.volume.below);
      EXPECT_EQ(m.difference.rms, expected.difference.rms);
      EXPECT_EQ(m.difference.nmad, expected.difference.nmad);
      EXPECT_EQ(m.difference.abs_percentiles, expected.difference.abs_percentiles);
      EXPECT_EQ(m.difference.histogram.areas, expected.difference.histogram.areas);
    });
}

TEST(Overlay, OfDisjointHullsIsEmpty) {
  const Couple apart(rough(uniform(50, 51), 52), rough(moved(uniform(50, 53), 1, 3, 0), 54));
  EXPECT_EQ(sum_up(apart.overlay(), {}).area, 0);
  const Couple touching(rough(lattice(16, 1, 0, 0), 55), rough(lattice(16, 1, 3, 0), 56));
  EXPECT_EQ(sum_up(touching.overlay(), {}).area, 0);
}

// A pyramid against planes on other triangles: piecewise linear, so the volume is exact. T, which has no edge along the
// edges of the pyramid, moves its faces.
TEST(Overlay, OfAPyramidAndAPlaneIsExact) {
  const double h = 3;
  const Points corners{{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  const Surface pyramid = surface(joined(corners, {{2, 2}}), [&](const Point2& p) { return p.x == 2 ? h : 0.0; });
  const auto plane_at = [&](double z) {
    return surface(joined(corners, {{1, 1.5}, {2.5, 3}, {1.25, 3.5}}), [=](const Point2&) { return z; });
  };
  const Measures ground = measure(Couple(pyramid, plane_at(0)).overlay(), {});
  EXPECT_DOUBLE_EQ(ground.area, 16);
  EXPECT_DOUBLE_EQ(ground.volume.below, 16 * h / 3);
  EXPECT_EQ(ground.volume.above, 0);
  EXPECT_DOUBLE_EQ(ground.difference.max_below, h);
  const Measures half = measure(Couple(pyramid, plane_at(h / 2)).overlay(), {});
  EXPECT_DOUBLE_EQ(half.volume.below, 2 * h / 3);  // the upper half of the pyramid
  EXPECT_DOUBLE_EQ(half.volume.above, 10 * h / 3);
  // Area where |d| ≤ v: between the squares of side 2 ± 2 v / (h/2) round the middle height.
  for (std::size_t i = 0; i < percentile_levels.size(); ++i) {
    const double share = percentile_levels[i] / 100.0;
    EXPECT_NEAR(half.difference.abs_percentiles[i], share * h / 2, 1e-12);
  }
}

std::size_t number_of_cells(const Overlay& overlay) {
  Overlay::Scratch scratch;
  std::size_t cells = 0;
  for (std::size_t i = 0; i < overlay.items(); ++i) cells += overlay.cells(i, scratch).size();
  return cells;
}

TEST(Overlay, OfHubsInOnePlaceHasNoMoreCellsThanOthers) {
  constexpr std::size_t n = 2000;
  const auto cells = [](const Points& points) {
    return number_of_cells(Couple(rough(points, 61), rough(points, 62)).overlay());
  };
  EXPECT_LT(cells(uniform(n, 63)), 30 * n);
  EXPECT_LT(cells(wheel(n, 0, 1, 64, 0)), 30 * n);
  for (const double x : {-1, 1})
    for (const double y : {-2, 2}) EXPECT_LT(cells(parabola(n, x, y)), 30 * n) << x << ' ' << y;
}

/// A hub at (x, 0) and n nodes on a line across, which doubles hold exactly.
Points fan(std::size_t n, double hub, double rim) {
  Points points{{hub, 0.5}};
  for (std::size_t i = 0; i < n; ++i) points.push_back({rim, static_cast<double>(i) / static_cast<double>(n)});
  return points;
}

TEST(Overlay, EstimatesItsCells) {
  const Couple few(rough(uniform(300, 71), 72), rough(uniform(200, 73), 74));
  EXPECT_EQ(few.overlay().estimated_cells({}), static_cast<double>(number_of_cells(few.overlay())));
  const Couple many(rough(uniform(20000, 75), 76), rough(uniform(15000, 77), 78));
  auto cells = static_cast<double>(number_of_cells(many.overlay()));
  EXPECT_NEAR(many.overlay().estimated_cells({}), cells, 0.1 * cells);
  const Couple fans(rough(fan(2500, 0, 8), 79), rough(fan(1500, 8, 0), 80));
  cells = static_cast<double>(number_of_cells(fans.overlay()));
  EXPECT_GT(cells, 1e6);
  EXPECT_NEAR(fans.overlay().estimated_cells({}), cells, 0.1 * cells);
  const Couple apart(rough(uniform(50, 81), 82), rough(moved(uniform(50, 83), 1, 3, 0), 84));
  EXPECT_EQ(apart.overlay().estimated_cells({}), 0);
}

}  // namespace
}  // namespace isopach::test
