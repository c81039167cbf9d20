// The border rule against its definition; shapes of surveys; thinning; density; units; threads; gaps at nodes.
#include "isopach/overlay/border.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/geom/predicates.hpp"
#include "isopach/overlay/localise.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

constexpr double pi = 3.14159265358979324;

using Inside = std::function<bool(const Point2&)>;
bool everywhere(const Point2&) { return true; }
bool in_corner_shape(const Point2& p) { return p.x < 0.5 || p.y < 0.5; }
bool in_ring(const Point2& p) {
  const double r = std::hypot(p.x - 0.5, p.y - 0.5);
  return r < 0.5 && r > 0.25;
}
bool in_strips(const Point2& p) { return std::fmod(p.x, 0.25) < 0.2; }

// Uniform points where `inside` holds in the unit square.
Points sample(std::size_t n, std::uint64_t seed, const Inside& inside) {
  Points points;
  Random random(seed);
  while (points.size() < n) {
    const double x = random.uniform(), y = random.uniform();
    if (inside({x, y})) points.push_back({x, y});
  }
  return points;
}

Points half_of(const Points& points, std::uint64_t seed) {
  Points half;
  Random random(seed);
  for (const Point2& p : points)
    if (random.uniform() < 0.5) half.push_back(p);
  return half;
}

SortedTriangulation triangulate_once(const Points& points) { return triangulate_unsorted(points, {}); }

Footprint trimmed(const SortedTriangulation& s, double max_edge = 0) {
  return footprint(s.triangulation, s.xy, true, {max_edge, 0}, {});
}
double trimmed_area(const Points& points) { return trimmed(triangulate_once(points)).area; }

double squared(const Point2& p, const Point2& q) { return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y); }

double longest2(const Triangle& t, std::span<const Point2> xy) {
  return std::max({squared(xy[t.v[0]], xy[t.v[1]]), squared(xy[t.v[1]], xy[t.v[2]]), squared(xy[t.v[2]], xy[t.v[0]])});
}

// The rule as it is written down: sets of neighbours, sorted lists, and passes over all triangles until nothing
// changes.
std::vector<unsigned char> by_definition(const Triangulation& t, std::span<const Point2> xy) {
  if (t.real == 0) return {};
  std::vector<std::set<Index>> neighbours(t.nodes);
  for (Index i = 0; i < t.real; ++i)
    for (const Index v : t.triangles[i].v)
      for (const Index w : t.triangles[i].v)
        if (v != w) neighbours[v].insert(w);
  std::vector<double> third(t.nodes), spacing2(t.nodes);
  for (Index v = 0; v < t.nodes; ++v) {
    std::vector<double> lengths;
    for (const Index w : neighbours[v]) lengths.push_back(squared(xy[v], xy[w]));
    std::sort(lengths.begin(), lengths.end());
    third[v] = lengths[std::min<std::size_t>(3, lengths.size()) - 1];
  }
  for (Index v = 0; v < t.nodes; ++v) {
    std::vector<double> of_neighbours;
    for (const Index w : neighbours[v]) of_neighbours.push_back(third[w]);
    std::sort(of_neighbours.rbegin(), of_neighbours.rend());
    spacing2[v] = std::min(third[v], of_neighbours[1]);
  }
  const auto stretched = [&](Index i, double limit) {
    const auto& v = t.triangles[i].v;
    return longest2(t.triangles[i], xy) > limit * limit * std::max({spacing2[v[0]], spacing2[v[1]], spacing2[v[2]]});
  };
  std::vector<unsigned char> removed(t.real, 0);
  for (bool again = true; again;) {
    again = false;
    for (Index i = 0; i < t.real; ++i) {
      bool reached = stretched(i, gap_stretch);
      for (const HalfEdge h : t.triangles[i].n) reached |= t.is_ghost(triangle_of(h)) || removed[triangle_of(h)] != 0;
      if (removed[i] != 0 || !reached || !stretched(i, rim_stretch)) continue;
      removed[i] = 1;
      again = true;
    }
  }
  return removed;
}

class BorderFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, BorderFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(BorderFamilies, IsWhatTheDefinitionSays) {
  for (const std::size_t n : {3, 4, 7, 30, 400})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const SortedTriangulation s = triangulate_once(distinct(GetParam().make(n, seed)));
      const Footprint f = trimmed(s);
      const std::vector<unsigned char> expected = by_definition(s.triangulation, s.xy);
      for (Index i = 0; i < s.triangulation.real; ++i) ASSERT_EQ(f.keeps(i), expected[i] == 0) << n << " " << i;
      EXPECT_EQ(f.is_whole(), std::count(expected.begin(), expected.end(), 1) == 0);
    }
}

TEST_P(BorderFamilies, IsTheSameForAnyNumberOfThreads) {
  const SortedTriangulation s = triangulate_once(distinct(GetParam().make(20000, 4)));
  const Locations where = localise_in_order(s.xy, s.triangulation, s.xy, {});
  const auto run = [&](int threads) {
    std::pair<Footprint, Margins> result;
    run_with_threads(threads, [&] {
      result.first = trimmed(s);
      result.second = margins(result.first, s.triangulation, s.xy, where, {});
    });
    return result;
  };
  const auto one = run(1);
  for (const int threads : {2, 7}) {
    const auto [f, m] = run(threads);
    EXPECT_EQ(f.removed, one.first.removed);
    EXPECT_EQ(f.area, one.first.area);
    EXPECT_EQ(f.removed_area, one.first.removed_area);
    EXPECT_EQ(m.own.side, one.second.own.side);
    EXPECT_EQ(m.other.side, one.second.other.side);
    EXPECT_EQ(m.own.gaps.size(), one.second.own.gaps.size());
  }
}

TEST(Border, KeepsTheShapeOfASurvey) {
  struct Shape {
    const char* name;
    Inside inside;
    double area;
    std::size_t n;
  };
  for (const Shape& shape : {Shape{"square", everywhere, 1, 20000},
                             {"L", in_corner_shape, 0.75, 50000},
                             {"ring", in_ring, pi * (0.25 - 0.0625), 50000},
                             {"strips", in_strips, 0.8, 200000}})
    for (const std::uint64_t seed : {1, 2})
      EXPECT_NEAR(trimmed_area(sample(shape.n, seed, shape.inside)), shape.area, 0.01 * shape.area) << shape.name;
}

TEST(Border, KeepsStripsOfScanLinesWhateverTheSpacingAlongThem) {
  for (const double along : {0.1, 0.5, 1.0, 3.0}) {  // lines 1 apart, four strips of 41 lines, gaps of 20
    Points points;
    Random random(8);
    for (int strip = 0; strip < 4; ++strip)
      for (int line = 0; line <= 40; ++line)
        for (double x = 0; x <= 200; x += along)
          points.push_back({x + random.uniform(-0.3, 0.3) * along, strip * 60 + line + random.uniform(-0.1, 0.1)});
    EXPECT_NEAR(trimmed_area(points), 4 * 40 * 200, 0.01 * 4 * 40 * 200) << along;
  }
}

TEST(Border, LeavesRegularSamplesWhole) {
  Points lattice;
  for (int i = 0; i < 50; ++i)
    for (int k = 0; k < 50; ++k) lattice.push_back({1.0 * i, 20.0 * k});
  EXPECT_TRUE(trimmed(triangulate_once(grid(2500, 1))).is_whole());
  EXPECT_TRUE(trimmed(triangulate_once(lattice)).is_whole());
  EXPECT_TRUE(trimmed(triangulate_once({{0, 0}, {1, 0}, {0, 1}})).is_whole());
  EXPECT_TRUE(trimmed(triangulate_once({{0, 0}, {9, 0}, {0, 1}})).is_whole());
}

TEST(Border, CutsHolesOutOfAGridToTheCell) {
  Points points;
  for (int i = 0; i < 100; ++i)
    for (int k = 0; k < 100; ++k)
      if (!(i > 40 && i < 60 && k > 40 && k < 60)) points.push_back({1.0 * i, 1.0 * k});
  EXPECT_NEAR(trimmed_area(points), 99 * 99 - 400, 10) << "chords over the corners of the hole stay";
}

TEST(Border, MovesLittleWhenAScanIsThinnedToAHalf) {
  Points holed;
  for (int i = 0; i < 200; ++i)
    for (int k = 0; k < 200; ++k)
      if (!(i > 80 && i < 120 && k > 80 && k < 120)) holed.push_back({1.0 * i, 1.0 * k});
  for (const Points& points : {sample(20000, 11, everywhere), sample(50000, 12, in_corner_shape),
                               sample(50000, 13, in_ring), sample(200000, 14, in_strips), holed})
    for (const std::uint64_t seed : {15, 16}) {
      const double area = trimmed_area(points);
      EXPECT_NEAR(trimmed_area(half_of(points, seed)), area, 0.02 * area) << points.size();
    }
}

TEST(Border, LeavesTheInsideOfRandomAndSparseSamplesAlone) {
  Points stepped = sample(100000, 21, [](const Point2& p) { return p.x < 0.5; });
  const Points sparse = sample(1000, 22, [](const Point2& p) { return p.x >= 0.5; });  // ten times the spacing
  stepped.insert(stepped.end(), sparse.begin(), sparse.end());
  Points disc = sample(50000, 23, [](const Point2& p) { return std::hypot(p.x - 0.5, p.y - 0.5) < 0.2; });
  const Points round = sample(3000, 24, everywhere);
  disc.insert(disc.end(), round.begin(), round.end());
  for (const Points& points : {sample(300000, 25, everywhere), stepped, disc}) {
    const SortedTriangulation s = triangulate_once(points);
    const Footprint f = trimmed(s);
    ASSERT_FALSE(f.is_whole());
    for (Index i = 0; i < s.triangulation.real; ++i) {
      if (f.keeps(i)) continue;
      double depth = 1;  // of its deepest corner
      for (const Index v : s.triangulation.triangles[i].v) {
        const Point2& p = s.xy[v];
        depth = std::min({depth, std::max({0.0, std::min({p.x, p.y, 1 - p.x, 1 - p.y})})});
      }
      EXPECT_LT(depth, 0.05) << "a triangle away from the rim was removed";
    }
  }
}

TEST(Border, DropsOutliers) {
  Points points = sample(10000, 31, everywhere);
  const double area = trimmed_area(points);
  points.push_back({100, 100});
  EXPECT_NEAR(trimmed_area(points), area, 0.005 * area);
  points.push_back({101, 100});
  EXPECT_NEAR(trimmed_area(points), area, 0.005 * area);
}

TEST(Border, KnowsNoUnit) {
  const Points points = sample(5000, 32, in_ring);
  const SortedTriangulation s = triangulate_once(points);
  for (const double scale : {0x1p-40, 0x1p40}) {
    Array<Point2> scaled = s.xy;
    for (Point2& p : scaled) p = {p.x * scale, p.y * scale};
    const Footprint f = footprint(s.triangulation, scaled, true, {}, {});
    EXPECT_EQ(f.removed, trimmed(s).removed);
    EXPECT_EQ(f.area, trimmed(s).area * scale * scale);
  }
}

// The circle through three points by its centre: where the bisectors of two sides meet, in long doubles.
long double radius_of(const Point2& a, const Point2& b, const Point2& c) {
  const long double bx = static_cast<long double>(b.x) - a.x, by = static_cast<long double>(b.y) - a.y,
                    cx = static_cast<long double>(c.x) - a.x, cy = static_cast<long double>(c.y) - a.y;
  const long double d = 2 * (bx * cy - by * cx), b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
  return std::hypot((cy * b2 - by * c2) / d, (bx * c2 - cx * b2) / d);
}

TEST(Border, AlphaRemovesTrianglesWithALargerCircumradius) {
  for (const Points& points : {uniform(2000, 3), near_degenerate(400, 1), scan_lines(900, 2)}) {
    const SortedTriangulation s = triangulate_unsorted(points, {});
    std::vector<long double> radii;
    for (Index i = 0; i < s.triangulation.real; ++i) {
      const auto& v = s.triangulation.triangles[i].v;
      radii.push_back(radius_of(s.xy[v[0]], s.xy[v[1]], s.xy[v[2]]));
    }
    std::vector<long double> sorted_radii = radii;
    std::sort(sorted_radii.begin(), sorted_radii.end());
    const double limit = static_cast<double>(sorted_radii[sorted_radii.size() * 9 / 10]) * 1.000001;
    const Footprint f = footprint(s.triangulation, s.xy, false, {0, limit}, {});
    int kept = 0;
    for (Index i = 0; i < s.triangulation.real; ++i) {
      ASSERT_EQ(f.keeps(i), radii[i] <= static_cast<long double>(limit)) << i;
      kept += f.keeps(i) ? 1 : 0;
    }
    EXPECT_GE(kept, static_cast<int>(radii.size() * 9 / 10));
    EXPECT_TRUE(footprint(s.triangulation, s.xy, false, {0, 1e30}, {}).is_whole());
  }
}

TEST(Border, RemovesTrianglesWithAnEdgeLongerThanAllowed) {
  const SortedTriangulation s = triangulate_once(sample(3000, 33, everywhere));
  const double limit = 0.03;
  const Footprint hull = footprint(s.triangulation, s.xy, false, {limit, 0}, {}), both = trimmed(s, limit),
                  trim = trimmed(s);
  ASSERT_FALSE(hull.is_whole());
  for (Index i = 0; i < s.triangulation.real; ++i) {
    const bool too_long = longest2(s.triangulation.triangles[i], s.xy) > limit * limit;
    EXPECT_EQ(hull.keeps(i), !too_long);
    EXPECT_EQ(both.keeps(i), !too_long && trim.keeps(i));
  }
  EXPECT_TRUE(footprint(s.triangulation, s.xy, false, {2, 0}, {}).is_whole());
  EXPECT_TRUE(footprint(s.triangulation, s.xy, false, {}, {}).is_whole());
}

// Margins against every triangle: a point is outside, on the rim or inside as the triangles that it touches are
// removed.
TEST(Border, MarginsAreWhatTheTrianglesRoundAPointSay) {
  for (const std::uint64_t seed : {41, 42}) {
    Points points = sample(800, seed, in_ring);
    for (Point2& p : points) p = {std::floor(p.x * 0x1p20) / 0x1p20, std::floor(p.y * 0x1p20) / 0x1p20};
    const SortedTriangulation s = triangulate_once(points);
    const Triangulation& t = s.triangulation;
    Points other = sample(300, seed + 10, everywhere);
    other.insert(other.end(), s.xy.begin(), s.xy.end());  // on nodes
    for (Index i = 0; i < t.real; ++i) {                  // and on edges
      const Point2 &p = s.xy[t.triangles[i].v[0]], &q = s.xy[t.triangles[i].v[1]];
      other.push_back({(p.x + q.x) / 2, (p.y + q.y) / 2});
    }
    const SortedTriangulation o = triangulate_once(distinct(other));
    const Footprint f = trimmed(s);
    const Margins m = margins(f, t, s.xy, localise_in_order(o.xy, t, s.xy, {}), {});
    const auto side_of = [&](const Point2& p) {
      bool kept = false, removed = false;
      for (Index i = 0; i < t.real; ++i) {
        const auto& v = t.triangles[i].v;
        bool touches = true;
        for (std::size_t k = 0; k < 3; ++k) touches &= orientation(s.xy[v[k]], s.xy[v[(k + 1) % 3]], p) >= 0;
        if (touches) (f.keeps(i) ? kept : removed) = true;
      }
      return !kept ? Side::outside : removed ? Side::rim : Side::inside;
    };
    std::array<int, 3> seen{};
    for (Index i = 0; i < o.xy.size(); ++i) {
      EXPECT_EQ(m.other.side[i], side_of(o.xy[i])) << i;
      ++seen[static_cast<std::size_t>(m.other.side[i])];
    }
    for (Index i = 0; i < s.xy.size(); ++i) EXPECT_EQ(m.own.side[i], side_of(s.xy[i])) << i;
    for (const int count : seen) EXPECT_GT(count, 20);
  }
}

// Of the same nodes twice, the cells of T are the triangles, and each must be judged as itself.
TEST(Border, CellsThatAreTrianglesOfTheScanFollowTheirOwnFlag) {
  for (const Family& family : families()) {
    if (family.collinear) continue;
    const SortedTriangulation s = triangulate_once(distinct(family.make(2000, 51)));
    const Triangulation& t = s.triangulation;
    const Footprint f = trimmed(s);
    const Margins m = margins(f, t, s.xy, localise_in_order(s.xy, t, s.xy, {}), {});
    Array<Index> same(s.xy.size());
    for (Index i = 0; i < same.size(); ++i) same[i] = i;
    const FootprintOfNodes nodes(m, same, same);
    for (Index i = 0; i < t.real; ++i)
      ASSERT_EQ(nodes.holds(t.triangles[i].v, s.xy), f.keeps(i)) << family.name << " " << i;
  }
}

}  // namespace
}  // namespace isopach::test
