// Changes as objects: against union-find over all pairs of parts of a fine subdivision, integrated by clipping; sums
// against detect(); outlines against GEOS.
#include "isopach/measure/changes/changes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "tests/overlay/couple.hpp"
#include "tests/support/polygons.hpp"

namespace isopach::test {
namespace {

/// T of one point set with two heights at each node, some cells of it measured.
struct Field {
  Surface s;
  std::vector<double> z1, z2, lod;
  std::vector<unsigned char> in_domain;
  std::vector<CellPiece> pieces;

  /// Heights and levels are multiples of `step`, so that many lie on the level; 0: any.
  Field(const Points& points, std::uint64_t seed, double step, std::uint64_t holes = 9) : s(rough(points, seed)) {
    Random random(seed + 7);
    const auto value = [&](double low, double high) {
      const double v = random.uniform(low, high);
      return step > 0 ? std::round(v / step) * step : v;
    };
    for (std::size_t i = 0; i < s.mesh.xy.size(); ++i) {
      z1.push_back(value(-1, 1)), z2.push_back(value(-2, 2)), lod.push_back(value(0.25, 1));
    }
    for (Index t = 0; t < s.mesh.triangulation.real; ++t) in_domain.push_back(random.below(holes) != 0 ? 1 : 0);
  }
  [[nodiscard]] CellView view() const { return {s.mesh.triangulation, s.mesh.xy, z1, z2, in_domain, pieces}; }
  [[nodiscard]] FoundChanges found(double min_area = 0) const {
    return find_changes(view(), ChangeLevel(lod), {}, min_area, {});
  }
};

/// A triangle with d and how far it exceeds the level, at its corners.
struct Small {
  std::array<Point2, 3> at;
  std::array<double, 3> d, s;
};

/// Every measured triangle in n² alike.
std::vector<Small> subdivided(const Field& f, int sign, int n) {
  std::vector<Small> all;
  const auto& t = f.s.mesh.triangulation;
  for (Index i = 0; i < t.real; ++i) {
    if (f.in_domain[i] == 0) continue;
    const auto& v = t.triangles[i].v;
    const auto corner = [&](Small& to, std::size_t k, int a, int b) {
      const auto mix = [&](auto&& of) {
        return (of(v[0]) * (n - a - b) + of(v[1]) * a + of(v[2]) * b) / static_cast<double>(n);
      };
      to.at[k] = {mix([&](Index p) { return f.s.mesh.xy[p].x; }), mix([&](Index p) { return f.s.mesh.xy[p].y; })};
      to.d[k] = mix([&](Index p) { return sign * (f.z2[p] - f.z1[p]); });
      to.s[k] = mix([&](Index p) { return sign * (f.z2[p] - f.z1[p]) - f.lod[p]; });
    };
    for (int a = 0; a < n; ++a)
      for (int b = 0; a + b < n; ++b) {
        Small small;
        corner(small, 0, a, b), corner(small, 1, a + 1, b), corner(small, 2, a, b + 1);
        all.push_back(small);
        if (a + b + 1 >= n) continue;
        corner(small, 0, a + 1, b), corner(small, 1, a + 1, b + 1), corner(small, 2, a, b + 1);
        all.push_back(small);
      }
  }
  return all;
}

struct Totals3 {
  double volume = 0, area = 0;
};

/// What of a triangle lies beyond the level, by clipping.
Totals3 beyond(const Small& t) {
  std::vector<std::array<double, 3>> p;  // x, y, d
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t j = (k + 1) % 3;
    if (t.s[k] > 0) p.push_back({t.at[k].x, t.at[k].y, t.d[k]});
    if ((t.s[k] > 0) == (t.s[j] > 0)) continue;
    const double u = t.s[k] / (t.s[k] - t.s[j]);
    p.push_back({t.at[k].x + u * (t.at[j].x - t.at[k].x), t.at[k].y + u * (t.at[j].y - t.at[k].y),
                 t.d[k] + u * (t.d[j] - t.d[k])});
  }
  Totals3 sum;
  for (std::size_t k = 2; k < p.size(); ++k) {
    const double area =
        0.5 * ((p[k - 1][0] - p[0][0]) * (p[k][1] - p[0][1]) - (p[k - 1][1] - p[0][1]) * (p[k][0] - p[0][0]));
    sum.area += area, sum.volume += area * (p[0][2] + p[k - 1][2] + p[k][2]) / 3;
  }
  return sum;
}

/// Volumes and areas of the connected parts: small triangles that share a side beyond the level in part, all pairs.
std::vector<Totals3> parts_by_pairs(const Field& f, int sign, int n) {
  const std::vector<Small> all = subdivided(f, sign, n);
  std::vector<std::size_t> parent(all.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto find = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i];
    return i;
  };
  const auto same = [](const Point2& p, const Point2& q) { return std::hypot(p.x - q.x, p.y - q.y) < 1e-9; };
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t m = 0; m < 3; ++m) {
          const std::size_t k2 = (k + 1) % 3, m2 = (m + 1) % 3;
          if (!same(all[i].at[k], all[j].at[m2]) || !same(all[i].at[k2], all[j].at[m])) continue;
          if (all[i].s[k] > 0 || all[i].s[k2] > 0) parent[find(i)] = find(j);
        }
  std::map<std::size_t, Totals3> sums;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!(std::max({all[i].s[0], all[i].s[1], all[i].s[2]}) > 0)) continue;
    const Totals3 t = beyond(all[i]);
    sums[find(i)].volume += t.volume, sums[find(i)].area += t.area;
  }
  std::vector<Totals3> parts;
  for (const auto& [id, t] : sums) parts.push_back(t);
  std::sort(parts.begin(), parts.end(), [](const Totals3& a, const Totals3& b) { return a.volume > b.volume; });
  return parts;
}

std::vector<Change> of_sign(const Changes& changes, bool gained) {
  std::vector<Change> list;
  for (const Change& c : changes.list)
    if (c.gained == gained) list.push_back(c);
  return list;
}

Points grid_points(int n, double step) {
  Points points;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) points.push_back({i * step, j * step});
  return points;
}

void expect_as_by_pairs(const Field& f, int n) {
  const FoundChanges found = f.found();
  for (const bool gained : {true, false}) {
    const auto expected = parts_by_pairs(f, gained ? 1 : -1, n);
    const auto list = of_sign(found.changes, gained);
    ASSERT_EQ(list.size(), expected.size()) << "gained " << gained;
    for (std::size_t i = 0; i < list.size(); ++i) {
      EXPECT_NEAR(list[i].volume, expected[i].volume, 1e-12 * (1 + expected[i].volume));
      EXPECT_NEAR(list[i].area, expected[i].area, 1e-12);
    }
  }
}

double outlined(const Change& c) {
  double area = 0;
  for (const PolygonWithHoles& p : c.outline)
    for (const auto& ring : p.rings) area += ring_area(ring);
  return area;
}

Rings rings_of(const PolygonWithHoles& p) { return {p.rings.begin(), p.rings.end()}; }

void expect_outlines(const FoundChanges& found, double tolerance) {
  for (const Change& c : found.changes.list) {
    EXPECT_NEAR(outlined(c), c.area, tolerance);
    for (const PolygonWithHoles& p : c.outline) {
      EXPECT_GT(ring_area(p.rings[0]), 0);
      for (std::size_t k = 1; k < p.rings.size(); ++k) EXPECT_LT(ring_area(p.rings[k]), 0);
    }
  }
}

TEST(Changes, AreThoseOfAllPairsOfAFineSubdivision) {
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    SCOPED_TRACE(seed);
    expect_as_by_pairs(Field(uniform(30, seed), seed, 0), 2);
    expect_as_by_pairs(Field(uniform(30, seed), seed, 0.5), 2);        // many nodes on the level
    expect_as_by_pairs(Field(grid_points(5, 0.25), seed, 0.5, 3), 2);  // … on a grid, with many holes
    expect_as_by_pairs(Field(grid_points(5, 0.25), seed, 1), 2);
  }
}

TEST(Changes, AddUpToWhatIsDetected) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Field f(uniform(300, seed), seed, seed % 2 == 0 ? 0 : 0.5);
    const Detected whole = detect(f.view(), f.lod, {});
    for (const double min_area : {0.0, 0.01}) {
      const Changes changes = f.found(min_area).changes;
      EXPECT_EQ(changes.all.above, whole.above);  // the same exact sums, in other order
      EXPECT_EQ(changes.all.below, whole.below);
      EXPECT_NEAR(changes.all.area, whole.area, 1e-15);
      double above = changes.small.sum.above, below = changes.small.sum.below;
      for (const Change& c : changes.list) (c.gained ? above : below) += c.volume;
      EXPECT_NEAR(above, whole.above, 1e-13);
      EXPECT_NEAR(below, whole.below, 1e-13);
      for (const Change& c : changes.list) EXPECT_GE(c.area, min_area);
    }
  }
}

TEST(Changes, SwapWithTheScansToTheLastBit) {
  Field f(uniform(400, 5), 5, 0);
  const Changes one = f.found().changes;
  std::swap(f.z1, f.z2);
  const Changes other = f.found().changes;
  ASSERT_EQ(one.list.size(), other.list.size());
  for (std::size_t i = 0; i < one.list.size(); ++i) {
    EXPECT_EQ(one.list[i].volume, other.list[i].volume);
    EXPECT_EQ(one.list[i].gained, !other.list[i].gained);
    EXPECT_EQ(one.list[i].area, other.list[i].area);
    EXPECT_EQ(one.list[i].largest_at, other.list[i].largest_at);
    EXPECT_EQ(one.list[i].centroid, other.list[i].centroid);
  }
}

TEST(Changes, HaveOutlinesOfTheirArea) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    expect_outlines(Field(uniform(200, seed), seed, 0).found(), 1e-13);
    expect_outlines(Field(grid_points(9, 0.125), seed, 0.5, 3).found(), 1e-13);
  }
}

TEST(Changes, HaveOutlinesThatGeosCallsValid) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(seed);
    for (const Field& f : {Field(uniform(200, seed), seed, 0), Field(grid_points(9, 0.125), seed, 0.5, 3)})
      for (const Change& c : f.found().changes.list)
        for (const PolygonWithHoles& p : c.outline) EXPECT_TRUE(is_valid(rings_of(p)));
  }
}

TEST(Changes, ThatTouchInACornerAreApart) {
  // Two squares of four triangles each, with one common corner; in each a peak.
  const Field all(grid_points(3, 1), 1, 0);
  Field f = all;
  const auto at = [&](double x, double y) {
    return std::find(f.s.mesh.xy.begin(), f.s.mesh.xy.end(), Point2{x, y}) - f.s.mesh.xy.begin();
  };
  std::fill(f.z1.begin(), f.z1.end(), 0), std::fill(f.z2.begin(), f.z2.end(), 2),
      std::fill(f.lod.begin(), f.lod.end(), 1);
  for (Index t = 0; t < f.s.mesh.triangulation.real; ++t) {
    double x = 0, y = 0;
    for (const Index v : f.s.mesh.triangulation.triangles[t].v) x += f.s.mesh.xy[v].x, y += f.s.mesh.xy[v].y;
    f.in_domain[t] = (x < 3) == (y < 3) ? 1 : 0;
  }
  ASSERT_LT(at(1, 1), 9);
  const Changes changes = f.found().changes;
  ASSERT_EQ(changes.list.size(), 2U);
  for (const Change& c : changes.list) {
    EXPECT_EQ(c.volume, 2);
    EXPECT_EQ(c.area, 1);
    ASSERT_EQ(c.outline.size(), 1U);
    EXPECT_EQ(c.outline[0].rings.size(), 1U);
    EXPECT_EQ(c.outline[0].rings[0].size(), 4U);
  }
  std::fill(f.in_domain.begin(), f.in_domain.end(), 1);
  EXPECT_EQ(f.found().changes.list.size(), 1U);
}

TEST(Changes, OfAConeAreThoseOfItsClosedForm) {
  // d falls by 1 a unit from 3 at a node in the middle of a square of side 8; level 1: a square on its corner or not.
  Field f(Points{{-4, -4}, {4, -4}, {4, 4}, {-4, 4}, {0, 0}}, 3, 0, 1 << 20);
  for (std::size_t i = 0; i < 5; ++i) {
    const Point2& p = f.s.mesh.xy[i];
    f.z1[i] = 0, f.z2[i] = 3 - std::max(std::fabs(p.x), std::fabs(p.y)), f.lod[i] = 1;
  }
  const Changes changes = f.found().changes;
  ASSERT_EQ(changes.list.size(), 1U);
  const Change& c = changes.list[0];
  EXPECT_NEAR(c.area, 16, 1e-13);                  // |x|, |y| ≤ 2
  EXPECT_NEAR(c.volume, 16 + 16. * 2 / 3, 1e-13);  // a slab of height 1 and a pyramid of height 2
  EXPECT_EQ(c.largest, 3);
  EXPECT_EQ(c.largest_at, (Point2{0, 0}));
  EXPECT_NEAR(c.centroid.x, 0, 1e-15);
  EXPECT_EQ(c.outline.at(0).rings.at(0).size(), 4U);
}

TEST(Changes, ThatARegionCutsKeepTheirSumsAndAreas) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    Field f(uniform(150, seed), seed, 0);
    const RandomStream random(seed, 3);
    const Rings polygon{star(random, 10, {0.5, 0.5}, 0.45, 9)};
    auto parts = trapezoids(edges_of(polygon));
    ASSERT_TRUE(parts);
    std::vector<Region> regions;
    regions.push_back({edges_of(polygon), *parts});
    Domain domain;
    domain.keep(Regions(std::move(regions), 100));
    f.pieces = cut_cells(f.view(), f.in_domain, domain, {});
    const FoundChanges found = f.found();
    const Detected whole = detect(f.view(), f.lod, {});
    EXPECT_EQ(found.changes.all.above, whole.above);
    EXPECT_EQ(found.changes.all.below, whole.below);
    expect_outlines(found, 1e-9);
    for (const Change& c : found.changes.list)
      for (const PolygonWithHoles& p : c.outline) EXPECT_TRUE(is_valid(rings_of(p)));
  }
}

}  // namespace
}  // namespace isopach::test
