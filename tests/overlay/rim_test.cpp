// Borders through cells of T: which cells a side runs through, against all sides times all cells in integers; the
// borders of footprints, against their definition; pieces, that they are the cell.
#include "isopach/overlay/rim.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "isopach/delaunay/triangulate.hpp"
#include "isopach/overlay/common.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

// Coordinates are small integers here, so that every product below is exact.
Points integers(std::size_t n, std::uint64_t seed, int range) {
  Random random(seed);
  Points points;
  for (std::size_t i = 0; i < n; ++i)
    points.push_back({std::floor(random.uniform(0, range)), std::floor(random.uniform(0, range))});
  return distinct(points);
}

__extension__ typedef __int128 Wide;  // a product of two areas

double twice_area(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Whether p→q runs through the inside of a, b, c: what of it lies left of all sides has a length, and not all of it
/// lies on one side. Shares are fractions of integers, compared by their products.
bool runs_through(const Point2& p, const Point2& q, const std::array<Point2, 3>& cell) {
  Wide begin_up = 0, begin_down = 1, end_up = 1, end_down = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    const Point2 &a = cell[k], &b = cell[(k + 1) % 3];
    const auto hp = static_cast<long long>(twice_area(a, b, p)), hq = static_cast<long long>(twice_area(a, b, q));
    if (hp <= 0 && hq <= 0) return false;
    if (hp >= 0 && hq >= 0) continue;
    const Wide up = hp < 0 ? -hp : hp, down = hp < 0 ? Wide{hq} - hp : Wide{hp} - hq;
    if (hp < 0 && up * begin_down > begin_up * down) begin_up = up, begin_down = down;
    if (hp > 0 && up * end_down < end_up * down) end_up = up, end_down = down;
  }
  return begin_up * end_down < end_up * begin_down;
}

std::set<std::pair<Index, Index>> twin_crossings(const Triangulation& t, const Points& xy,
                                                 const std::vector<BorderSide>& sides) {
  std::set<std::pair<Index, Index>> found;
  for (Index s = 0; s < sides.size(); ++s)
    for (Index i = 0; i < t.real; ++i) {
      const auto& v = t.triangles[i].v;
      if (runs_through(xy[sides[s].from], xy[sides[s].to], {xy[v[0]], xy[v[1]], xy[v[2]]})) found.insert({i, s});
    }
  return found;
}

TEST(Rim, SidesRunThroughTheCellsThatTheTwinFinds) {
  for (const auto& [n, range] : {std::pair{300, 1 << 20}, {300, 40}, {400, 20}, {60, 9}}) {
    const SortedTriangulation s = triangulate_unsorted(integers(static_cast<std::size_t>(n), 3, range), {});
    const Points xy(s.xy.begin(), s.xy.end());
    Random random(7);
    std::vector<BorderSide> sides;
    for (int k = 0; k < 200; ++k) {
      const auto from = static_cast<Index>(random.below(xy.size())), to = static_cast<Index>(random.below(xy.size()));
      if (from != to) sides.push_back({from, to, in_footprint});
    }
    for (const Triangle& triangle : s.triangulation.triangles)  // sides of T cross nothing
      if (triangle.v[2] != no_index && sides.size() < 260) sides.push_back({triangle.v[0], triangle.v[1], in_hull});
    std::set<std::pair<Index, Index>> found;
    const std::vector<RimCrossing> all = crossings(s.triangulation, s.xy, sides, {});
    for (const RimCrossing& c : all) found.insert({c.cell, c.side});
    EXPECT_EQ(found.size(), all.size());
    EXPECT_EQ(found, twin_crossings(s.triangulation, xy, sides)) << n << " " << range;
    EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), [](auto& a, auto& b) { return a.cell < b.cell; }));
  }
}

TEST(Rim, BordersAreTheSidesWithAnExtentOnTheLeftAlone) {
  const SortedTriangulation s = triangulate_unsorted(uniform(400, 5), {});
  const Triangulation& t = s.triangulation;
  Random random(9);
  Footprint f, single;
  for (Index i = 0; i < t.real; ++i) {
    f.removed.push_back(random.below(4) == 0 ? 1 : 0);
    single.removed.push_back(f.removed[i] != 0 || random.below(5) == 0 ? 1 : 0);
  }
  std::size_t count = 0;
  const std::vector<BorderSide> sides = border_sides(t, f, &single);
  for (Index i = 0; i < t.real; ++i)
    for (Index k = 0; k < 3; ++k) {
      const Index other = triangle_of(t.triangles[i].n[k]);
      const auto bits = [&](Index j) {
        if (t.is_ghost(j)) return 0;
        return in_hull + (f.removed[j] == 0 ? in_footprint : 0) + (single.removed[j] == 0 ? in_single : 0);
      };
      const int ends = bits(i) & ~bits(other);
      if (ends == 0) continue;
      const BorderSide& side = sides.at(count++);
      EXPECT_EQ(side.from, t.triangles[i].v[k]);
      EXPECT_EQ(side.to, t.triangles[i].v[next_side(k)]);
      EXPECT_EQ(side.of, ends);
    }
  EXPECT_EQ(count, sides.size());
  double hull = 0;  // of a whole footprint: the hull, by the shoelace formula against the sum of the triangles
  for (const BorderSide& side : border_sides(t, Footprint{}, nullptr)) {
    EXPECT_EQ(side.of, in_hull + in_footprint + in_single);
    hull += (s.xy[side.from].x * s.xy[side.to].y - s.xy[side.to].x * s.xy[side.from].y) / 2;
  }
  double sum = 0;
  for (Index i = 0; i < t.real; ++i) {
    const auto& v = t.triangles[i].v;
    sum += twice_area(s.xy[v[0]], s.xy[v[1]], s.xy[v[2]]) / 2;
  }
  EXPECT_NEAR(hull, sum, 1e-12 * sum);
}

/// T of the nodes of both, and the borders of both in it.
struct Borders {
  SortedTriangulation a, b, t;
  UnitedNodes nodes;
  std::vector<BorderSide> sides;
  Array<double> z1, z2;

  Borders(const Points& first, const Points& second)
      : a(triangulate_unsorted(first, {})), b(triangulate_unsorted(second, {})) {
    Points all = first;
    all.insert(all.end(), second.begin(), second.end());
    t = triangulate_unsorted(distinct(all), {});
    const auto add = [&](const SortedTriangulation& scan, unsigned shift) {
      for (const BorderSide& s : border_sides(scan.triangulation, Footprint{}, nullptr))
        sides.push_back({in_t(scan.xy[s.from]), in_t(scan.xy[s.to]), static_cast<unsigned char>(s.of << shift)});
    };
    add(a, 0), add(b, extents);
    for (const Point2& p : t.xy) z1.push_back(1 + 2 * p.x - p.y), z2.push_back(3 - p.x + 4 * p.y);
  }
  [[nodiscard]] Index in_t(const Point2& p) const {
    return static_cast<Index>(std::find(t.xy.begin(), t.xy.end(), p) - t.xy.begin());
  }
};

TEST(Rim, PiecesOfACellAreTheCell) {
  const Borders x(uniform(60, 1), [] {
    Points shifted = uniform(50, 2);
    for (Point2& p : shifted) p.x += 0.37, p.y += 0.21;
    return shifted;
  }());
  const std::vector<RimCrossing> all = crossings(x.t.triangulation, x.t.xy, x.sides, {});
  ASSERT_GT(all.size(), 20u);
  RimCutter cutter(x.t.xy, x.z1, x.z2, x.sides);
  for (auto first = all.begin(); first != all.end();) {
    const auto last = std::find_if(first, all.end(), [&](const RimCrossing& c) { return c.cell != first->cell; });
    const auto& v = x.t.triangulation.triangles[first->cell].v;
    double area = 0;
    const auto& pieces = cutter({v, {first, last}});
    EXPECT_GE(pieces.size(), 2u);
    for (const RimPiece& piece : pieces)
      for (std::size_t k = 0; k < piece.corners.size(); ++k) {
        const Corner &p = piece.corners[0], &q = piece.corners[k], &r = piece.corners[(k + 1) % piece.corners.size()];
        const double part = twice_area({p.x, p.y}, {q.x, q.y}, {r.x, r.y});
        EXPECT_GE(part, -1e-15);
        area += part;
        EXPECT_NEAR(q.z1, 1 + 2 * q.x - q.y, 1e-12);  // planes stay planes
        EXPECT_NEAR(q.z2, 3 - q.x + 4 * q.y, 1e-12);
        EXPECT_FALSE(q.x < p.x || (q.x == p.x && q.y < p.y));
      }
    EXPECT_NEAR(area, twice_area(x.t.xy[v[0]], x.t.xy[v[1]], x.t.xy[v[2]]), 1e-14);
    first = last;
  }
}

}  // namespace
}  // namespace isopach::test
