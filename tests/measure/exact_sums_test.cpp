// Sums over cells: to the last bit those of whole numbers, and the same however triangles are numbered and surfaces are
// named.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "isopach/base/error.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/delaunay/validate.hpp"
#include "isopach/measure/uncertainty/detection.hpp"
#include "isopach/measure/uncertainty/uncertainty.hpp"
#include "isopach/measure/volume/budget.hpp"
#include "isopach/measure/volume/distribution.hpp"
#include "isopach/measure/volume/weight.hpp"
#include "tests/support/exact.hpp"
#include "tests/support/points.hpp"
#include "tests/support/polygons.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

struct Scene {
  Triangulation t;
  Array<Point2> xy;
  std::vector<double> z1, z2, lod;
  std::vector<unsigned char> in_domain;
  std::vector<CellPiece> pieces;

  [[nodiscard]] CellView view() const { return {t, xy, z1, z2, in_domain, pieces}; }
};

struct Heights {
  const char* name;
  double (*d)(Random&, std::size_t);
};
double rough(Random& random, std::size_t) { return random.uniform(-1, 1.2); }
double nearly_balanced(Random& random, std::size_t i) { return (i % 2 == 0 ? 1 : -1) + 1e-9 * random.uniform(-1, 1); }
double far_outlier(Random& random, std::size_t i) { return i == 7 ? 1e9 : 1e-6 * random.bell(); }
double far_apart(Random& random, std::size_t i) {
  return std::ldexp(random.uniform(-1, 1), -static_cast<int>(20 * (i % 6)));
}
constexpr Heights heights[] = {
    {"rough", rough}, {"nearly balanced", nearly_balanced}, {"far outlier", far_outlier}, {"far apart", far_apart}};

Rings star_over(const Array<Point2>& xy, std::uint64_t seed) {
  Box2 box;
  for (const Point2& p : xy) box.add(p);
  Ring ring = star(RandomStream(seed, 0), 0, {0, 0}, 0.45, 9);
  for (Point2& p : ring)
    p = {box.min.x + (0.5 + p.x) * (box.max.x - box.min.x), box.min.y + (0.5 + p.y) * (box.max.y - box.min.y)};
  return {ring};
}
Regions regions_of(const std::vector<Rings>& polygons) {
  std::vector<Region> regions;
  for (const Rings& rings : polygons) regions.push_back({edges_of(rings), trapezoids(edges_of(rings)).value()});
  return {std::move(regions), 1000};
}

Scene scene(const Points& points, const Heights& of, std::uint64_t seed, bool with_pieces = false) {
  Random random(seed);
  SortedTriangulation mesh = triangulate_unsorted(distinct(points), {});
  Scene s{std::move(mesh.triangulation), std::move(mesh.xy), {}, {}, {}, {}, {}};
  for (std::size_t i = 0; i < s.xy.size(); ++i) {
    s.z1.push_back(100 + random.uniform(-1, 1));
    s.z2.push_back(s.z1.back() + of.d(random, i));
    s.lod.push_back(random.uniform(0, 0.5));
  }
  for (Index i = 0; i < s.t.real; ++i) s.in_domain.push_back(random.below(9) != 0 ? 1 : 0);
  if (!with_pieces || s.t.real == 0) return s;
  Domain domain;
  domain.keep(regions_of({star_over(s.xy, seed)}));
  s.pieces = cut_cells(s.view(), s.in_domain, domain, {});
  return s;
}

/// The same triangles in other slots, beginning with other corners; pieces in another order.
Scene renumbered(const Scene& s, std::uint64_t seed) {
  Random random(seed);
  std::vector<Index> slot(s.t.triangles.size()), turn(s.t.triangles.size(), 0);
  std::iota(slot.begin(), slot.end(), Index{0});
  std::vector<Index> real(slot.begin(), slot.begin() + s.t.real);
  random.shuffle(real);
  std::copy(real.begin(), real.end(), slot.begin());
  for (Index i = 0; i < s.t.real; ++i) turn[i] = static_cast<Index>(random.below(3));
  Scene r = s;
  for (Index i = 0; i < s.t.triangles.size(); ++i) {
    const Triangle& from = s.t.triangles[i];
    Triangle& to = r.t.triangles[slot[i]];
    for (Index k = 0; k < 3; ++k) {
      const Index side = (k + turn[i]) % 3, other = triangle_of(from.n[side]);
      to.v[k] = from.v[side];
      to.n[k] = half_edge(slot[other], (side_of(from.n[side]) + 3 - turn[other]) % 3);
    }
    if (i < s.t.real) r.in_domain[slot[i]] = s.in_domain[i];
  }
  // Pieces of one cell stay in their order: it is that in which the cell was cut.
  for (CellPiece& piece : r.pieces) piece.cell = slot[piece.cell];
  std::stable_sort(r.pieces.begin(), r.pieces.end(),
                   [](const CellPiece& p, const CellPiece& q) { return p.cell < q.cell; });
  return r;
}

void expect_equal(const Measures& m, const Measures& expected, const std::string& name) {
  EXPECT_EQ(m.area, expected.area) << name;
  EXPECT_EQ(m.rho, expected.rho) << name;
  EXPECT_EQ(m.volume.above, expected.volume.above) << name;
  EXPECT_EQ(m.volume.below, expected.volume.below) << name;
  EXPECT_EQ(m.volume.net, expected.volume.net) << name;
  EXPECT_EQ(m.volume.absolute, expected.volume.absolute) << name;
  const DifferenceStatistics &d = m.difference, &e = expected.difference;
  EXPECT_EQ(d.mean, e.mean) << name;
  EXPECT_EQ(d.rms, e.rms) << name;
  EXPECT_EQ(d.std, e.std) << name;
  EXPECT_EQ(d.median, e.median) << name;
  EXPECT_EQ(d.nmad, e.nmad) << name;
  EXPECT_EQ(d.max_above, e.max_above) << name;
  EXPECT_EQ(d.max_below, e.max_below) << name;
  EXPECT_EQ(d.abs_percentiles, e.abs_percentiles) << name;
  EXPECT_EQ(d.histogram.edges, e.histogram.edges) << name;
  EXPECT_EQ(d.histogram.areas, e.histogram.areas) << name;
}

class ExactSums : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, ExactSums, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(ExactSums, AreTheDoublesNearestToSumsOfWholeNumbers) {
  std::uint64_t seed = 40;
  for (const Heights& of : heights) {
    ++seed;
    const Scene s = scene(GetParam().make(1500, seed), of, seed, true);
    const CellView view = s.view();
    ExactSum area, above, below, net, absolute, squares;
    for_cells(view, 0, items_of(view), [&](const Cell& unsorted) {
      const Cell cell = sorted(unsorted);
      const Parts parts = split_volume(cell);
      const auto [d0, d1, d2] = cell.d;
      const double s1 = d1 + (d0 + d2);
      area.add(cell.area), above.add(parts.above), below.add(parts.below);
      net.add(parts.above), net.subtract(parts.below), absolute.add(parts.above), absolute.add(parts.below);
      squares.add(cell.area / 12 * (d1 * d1 + (d0 * d0 + d2 * d2) + s1 * s1));
    });
    const Measures m = measure(view, {});
    EXPECT_TRUE(area.rounds_to(m.area)) << of.name;
    EXPECT_TRUE(above.rounds_to(m.volume.above)) << of.name;
    EXPECT_TRUE(below.rounds_to(m.volume.below)) << of.name;
    EXPECT_TRUE(net.rounds_to(m.volume.net)) << of.name;
    EXPECT_TRUE(absolute.rounds_to(m.volume.absolute)) << of.name;
    EXPECT_TRUE(squares.rounds_to(describe(view, {}, 101, {}).totals.squares.value())) << of.name;
    EXPECT_EQ(m.area > 0, !GetParam().collinear);
  }
}

TEST_P(ExactSums, DoNotDependOnHowTrianglesAreNumbered) {
  std::uint64_t seed = 60;
  for (const Heights& of : heights) {
    ++seed;
    const Scene s = scene(GetParam().make(1500, seed), of, seed, true);
    if (s.t.real == 0) continue;
    const Regions rows = regions_of({star_over(s.xy, 1), star_over(s.xy, 2)});
    const std::vector<RegionSums> budget_of_s = budget(s.view(), rows, {});
    const std::vector<double> levels{12.5, 99.9};
    const Measures expected = measure(s.view(), {}, levels);
    const Detected detected = detect(s.view(), s.lod, {});
    const NodeWeights weights = weights_of_cells(s.view(), {});
    const WeightedMeasures weighted = weigh(s.view(), s.lod, LinearWeight{}, {});
    for (int round = 0; round < 3; ++round) {
      const Scene r = renumbered(s, ++seed);
      ASSERT_EQ(validate(r.t, r.xy).value_or("valid"), "valid");
      expect_equal(measure(r.view(), {}, levels), expected, of.name);
      const std::vector<RegionSums> again = budget(r.view(), rows, {});
      for (std::size_t k = 0; k < again.size(); ++k) {
        EXPECT_EQ(again[k].area, budget_of_s[k].area);
        EXPECT_EQ(again[k].volume.above, budget_of_s[k].volume.above);
        EXPECT_EQ(again[k].volume.below, budget_of_s[k].volume.below);
      }
      const Detected found = detect(r.view(), r.lod, {});
      EXPECT_EQ(found.above, detected.above);
      EXPECT_EQ(found.below, detected.below);
      EXPECT_EQ(found.area, detected.area);
      const NodeWeights of_nodes = weights_of_cells(r.view(), {});
      for (std::size_t i = 0; i < weights.size(); ++i) {
        ASSERT_EQ(of_nodes[i].net, weights[i].net);
        ASSERT_EQ(of_nodes[i].above, weights[i].above);
        ASSERT_EQ(of_nodes[i].below, weights[i].below);
      }
      const WeightedMeasures w = weigh(r.view(), r.lod, LinearWeight{}, {});
      EXPECT_EQ(w.integral, weighted.integral);
      EXPECT_EQ(w.above, weighted.above);
      EXPECT_EQ(w.below, weighted.below);
    }
  }
}

Scene swapped(Scene s) {
  std::swap(s.z1, s.z2);
  for (CellPiece& piece : s.pieces)
    for (Corner& c : piece.at) std::swap(c.z1, c.z2);
  return s;
}

void expect_mirrored(const Measures& m, Measures expected, const std::string& name) {
  std::swap(expected.volume.above, expected.volume.below);
  DifferenceStatistics& d = expected.difference;
  std::swap(d.max_above, d.max_below);
  expected.volume.net = 0.0 - expected.volume.net, d.mean = 0.0 - d.mean, d.median = 0.0 - d.median;
  std::reverse(d.histogram.areas.begin(), d.histogram.areas.end());
  expect_equal(m, expected, name);
}

TEST_P(ExactSums, ChangePlacesWithTheSurfacesToTheLastBit) {
  std::uint64_t seed = 80;
  for (const Heights& of : heights) {
    ++seed;
    const Scene s = scene(GetParam().make(1500, seed), of, seed, true);
    expect_mirrored(measure(swapped(s).view(), {}), measure(s.view(), {}), of.name);
  }
}

TEST(ExactSumsOfMany, AreTheSameWhereCellsAreSampled) {
  const Scene s = scene(uniform(60000, 90), heights[0], 91);
  ASSERT_GT(s.t.real, 1u << 16) << "more cells than the sample has";
  const Measures expected = measure(s.view(), {});
  expect_equal(measure(renumbered(s, 92).view(), {}), expected, "renumbered");
  expect_mirrored(measure(swapped(s).view(), {}), expected, "swapped");
}

TEST(ExactSumsOfMany, RefuseIntegralsThatAreNoNumbers) {
  Scene s = scene(uniform(50, 93), heights[0], 94);
  for (double& z : s.z2) z *= 1e200;  // d² is beyond doubles
  EXPECT_THROW((void)measure(s.view(), {}), InputError);
}

}  // namespace
}  // namespace isopach::test
