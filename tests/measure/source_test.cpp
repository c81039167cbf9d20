// Cells within a domain and the budget: against GEOS, cell by cell and polygon by polygon; partitions; bits.
#include "isopach/measure/source.hpp"

#include <gtest/gtest.h>

#include "isopach/base/parallel.hpp"
#include "isopach/measure/volume/budget.hpp"
#include "isopach/measure/volume/detail.hpp"
#include "isopach/measure/volume/distribution.hpp"
#include "isopach/measure/volume/weight.hpp"
#include "tests/overlay/couple.hpp"
#include "tests/support/polygons.hpp"

namespace isopach::test {
namespace {

Region region_of(const Rings& rings) {
  auto parts = trapezoids(edges_of(rings));
  EXPECT_TRUE(parts);
  return {edges_of(rings), parts ? *parts : std::vector<Trapezoid>{}};
}
Regions regions_of(const std::vector<Rings>& polygons, std::size_t cells) {
  std::vector<Region> regions;
  for (const Rings& rings : polygons) regions.push_back(region_of(rings));
  return {std::move(regions), cells};
}

/// T of one point set with two heights at each node.
struct Flagged {
  Surface s;
  std::vector<double> z2;
  std::vector<unsigned char> in_domain;
  std::vector<CellPiece> pieces;

  Flagged(const Points& points, std::uint64_t seed) : s(rough(points, seed)) {
    Random random(seed + 1);
    for (std::size_t i = 0; i < s.z.size(); ++i) z2.push_back(random.uniform(-1, 1));
    for (Index t = 0; t < s.mesh.triangulation.real; ++t) in_domain.push_back(random.below(9) != 0 ? 1 : 0);
  }
  [[nodiscard]] CellView view() const { return {s.mesh.triangulation, s.mesh.xy, s.z, z2, in_domain, pieces}; }
  void cut(const Domain& domain) { pieces = cut_cells(view(), in_domain, domain, {}); }
};

/// ∫ over one triangle ∩ polygon of d and of 1, by GEOS alone: the net volume.
struct Net {
  double area = 0, net = 0;
};
Net net_by_geos(const CellView& cells, const OGRGeometry& polygon) {
  Net sum;
  for (Index i = 0; i < cells.t.real; ++i) {
    if (cells.in_domain[i] == 0) continue;
    const auto& v = cells.t.triangles[i].v;
    const Point2 &a = cells.xy[v[0]], &b = cells.xy[v[1]], &c = cells.xy[v[2]];
    const Geometry shared(triangle(a, b, c)->Intersection(&polygon));
    const double area = test::area_of(shared.get());
    if (!(area > 0)) continue;
    // d at the centroid of a region on which d is linear.
    double cx = 0, cy = 0;
    OGRPoint centre;
    shared->Centroid(&centre);
    cx = centre.getX(), cy = centre.getY();
    const double whole = triangle_area(a, b, c);
    const Point2 p{cx, cy};
    const double d = (triangle_area(p, b, c) * cells.d(v[0]) + triangle_area(a, p, c) * cells.d(v[1]) +
                      triangle_area(a, b, p) * cells.d(v[2])) /
                     whole;
    sum.area += area;
    sum.net += area * d;
  }
  return sum;
}

std::vector<Rings> random_polygons(std::uint64_t seed, std::size_t count, double scale, double step) {
  const RandomStream random(seed, 3);
  std::vector<Rings> polygons;
  for (std::uint64_t i = 0; polygons.size() < count; ++i) {
    const std::uint64_t at = i * 1000;
    Point2 centre{scale * random.uniform(at), scale * random.uniform(at + 1)};
    if (step > 0) centre = {std::round(centre.x / step) * step, std::round(centre.y / step) * step};
    Rings rings{star(random, at + 10, centre, scale * (0.1 + 0.4 * random.uniform(at + 2)), 4 + i % 15, step)};
    if (i % 2 == 0) rings.push_back(star(random, at + 500, centre, scale * 0.03, 4, step / 4));
    if (is_valid(rings)) polygons.push_back(rings);
  }
  return polygons;
}

// include ∩ include₂ ∖ exclude and the rows of a budget, on uniform nodes and on grids whose lines the polygons share.
void compare_with_geos(const Points& points, double scale, double step, std::uint64_t seed) {
  Flagged cells(points, seed);
  const auto include = random_polygons(seed, 4, scale, step), exclude = random_polygons(seed + 50, 2, scale, step),
             rows = random_polygons(seed + 90, 5, scale, step);
  const auto united = [](const std::vector<Rings>& all) {
    Geometry sum = std::make_unique<OGRPolygon>();
    for (const Rings& r : all) {
      const OGRPolygon p = to_ogr(r);
      sum.reset(sum->Union(&p));
    }
    return sum;
  };
  const Geometry shape(united(include)->Difference(united(exclude).get()));
  Domain domain;
  domain.keep(regions_of(include, 1000));
  domain.take_away(regions_of(exclude, 1000));
  const Flagged whole = cells;
  cells.cut(domain);
  const Measures m = measure(cells.view(), {});
  const Net expected = net_by_geos(whole.view(), *shape);
  const double size = scale * scale;
  EXPECT_NEAR(m.area, expected.area, 1e-10 * size) << seed;
  EXPECT_NEAR(m.volume.net, expected.net, 1e-10 * size) << seed;
  EXPECT_GT(cells.pieces.size(), 0u);

  const auto sums = budget(cells.view(), regions_of(rows, 1000), {});
  ASSERT_EQ(sums.size(), rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const OGRPolygon polygon = to_ogr(rows[r]);
    const Net row = net_by_geos(whole.view(), *Geometry(shape->Intersection(&polygon)));
    EXPECT_NEAR(sums[r].area, row.area, 1e-10 * size) << seed << " " << r;
    EXPECT_NEAR(sums[r].volume.net, row.net, 1e-10 * size) << seed << " " << r;
  }
}

TEST(Source, AsByGeosTriangleByTriangle) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) compare_with_geos(uniform(150, seed), 1, 0, seed);
}
TEST(Source, AsByGeosOnGridsThatShareNodesAndSides) {
  for (std::uint64_t seed = 11; seed <= 13; ++seed) compare_with_geos(grid(144, seed), 11, 0.5, seed);
}

// Quads that cover [0, side]² between them, with corners on and off the nodes of a grid.
std::vector<Rings> cover(double side, std::size_t n, std::uint64_t seed, double step) {
  Random random(seed);
  std::vector<Point2> corner;
  for (std::size_t j = 0; j <= n; ++j)
    for (std::size_t i = 0; i <= n; ++i) {
      const double h = side / static_cast<double>(n);
      const auto moved = [&](std::size_t k, double by) {
        const double at = h * static_cast<double>(k);
        if (k == 0 || k == n) return at;
        return step > 0 ? std::round((at + by * h) / step) * step : at + by * h;
      };
      const double bx = random.uniform(-0.3, 0.3), by = random.uniform(-0.3, 0.3);
      corner.push_back({moved(i, bx), moved(j, by)});
    }
  std::vector<Rings> quads;
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t k = j * (n + 1) + i;
      quads.push_back({{corner[k], corner[k + 1], corner[k + n + 2], corner[k + n + 1]}});
    }
  return quads;
}

void expect_rows_sum_to_whole(const Measures& m, const std::vector<RegionSums>& rows) {
  double area = 0, above = 0, below = 0;
  for (const RegionSums& r : rows) area += r.area, above += r.volume.above, below += r.volume.below;
  EXPECT_NEAR(area, m.area, 1e-10 * m.area);
  EXPECT_NEAR(above, m.volume.above, 1e-10 * m.volume.above);
  EXPECT_NEAR(below, m.volume.below, 1e-10 * m.volume.below);
}

TEST(Budget, DisjointPolygonsThatCoverTheDomainSumToIt) {
  for (const double step : {0.0, 1.0, 0.25}) {
    const Flagged on_grid(grid(900, 1), 5);
    const Measures m = measure(on_grid.view(), {});
    for (const std::size_t n : {1, 3, 10})
      expect_rows_sum_to_whole(m, budget(on_grid.view(), regions_of(cover(29, n, n, step), 2000), {}));
  }
  for (const double far : {0.0, 1048576.0}) {
    Points points = uniform(3000, 2);
    for (Point2& p : points) p = {far + p.x, far + p.y};
    const Flagged strewn(points, 6);
    auto quads = cover(1, 12, 4, 0);
    for (Rings& rings : quads)
      for (Point2& p : rings[0]) p = {far + p.x, far + p.y};
    expect_rows_sum_to_whole(measure(strewn.view(), {}), budget(strewn.view(), regions_of(quads, 6000), {}));
  }
}

// Every cell, pieces too, cut at the quantile.
template <class Source>
void expect_distribution(const Source& cells) {
  const Described found = describe(cells, {{0.3, false, 0}, {0.9, true, 0}}, 20, {});
  double area = 0, below = 0, within = 0, binned = 0;
  for_cells(cells, 0, items_of(cells), [&](const Cell& cell) {
    area += cell.area;
    below += area_below(cell, found.quantiles[0]);
    within += area_below(cell, found.quantiles[1]) - area_below(cell, -found.quantiles[1]);
  });
  for (const double bin : found.histogram.areas) binned += bin;
  EXPECT_NEAR(below, 0.3 * area, 1e-12 * area);
  EXPECT_NEAR(within, 0.9 * area, 1e-12 * area);
  EXPECT_NEAR(binned, area, 1e-12 * area);
}

TEST(Source, InsideAndOutsideAreTheWholeForEveryMeasure) {
  const auto polygons = random_polygons(4, 6, 1, 0);
  const Flagged whole(uniform(2000, 9), 3);
  Flagged in = whole, out = whole;
  Domain keep, take;
  keep.keep(regions_of(polygons, 4000));
  take.take_away(regions_of(polygons, 4000));
  in.cut(keep);
  out.cut(take);
  const Measures all = measure(whole.view(), {}), inside = measure(in.view(), {}), outside = measure(out.view(), {});
  EXPECT_NEAR(inside.area + outside.area, all.area, 1e-13);
  EXPECT_NEAR(inside.volume.above + outside.volume.above, all.volume.above, 1e-13);
  EXPECT_NEAR(inside.volume.below + outside.volume.below, all.volume.below, 1e-13);
  const auto squares = [](const Measures& m) { return m.difference.rms * m.difference.rms * m.area; };
  EXPECT_NEAR(squares(inside) + squares(outside), squares(all), 1e-13);
  for (const Flagged* f : {&in, &out}) expect_distribution(f->view());
}

void expect_parts_of(const WeightedMeasures& in, const WeightedMeasures& out, const WeightedMeasures& all,
                     double error) {
  EXPECT_GT(in.integral, 0.1 * all.integral);
  EXPECT_NEAR(in.integral + out.integral, all.integral, error * all.integral);
  EXPECT_NEAR(in.above + out.above, all.above, error * all.above);
  EXPECT_NEAR(in.below + out.below, all.below, error * all.below);
}

// What is inside and what is outside add up to the whole: for a weight at the nodes and for a formula of degree 4 with
// slopes, both exact on every piece.
TEST(Source, WeightsAreCutOnEitherSurface) {
  const auto polygons = random_polygons(6, 5, 1, 0);
  Domain keep, take;
  keep.keep(regions_of(polygons, 2000));
  take.take_away(regions_of(polygons, 2000));
  const Flagged whole(uniform(600, 3), 5);
  Flagged in = whole, out = whole;
  in.cut(keep), out.cut(take);
  const Couple couple(rough(uniform(300, 1), 2), rough(uniform(400, 3), 4));
  const Overlay overlay = couple.overlay();
  const OverlayMesh m1 = couple.first(), m2 = couple.second();
  std::vector<double> mu(whole.s.z.size());
  Random random(7);
  for (double& value : mu) value = random.uniform(0, 3);
  const std::vector<double> mu_2(mu.begin(), mu.begin() + 400);
  const Weight formula = ExpressionWeight{
      "1 + x²y² + slope1 / 100", [](const Place& p) { return 1 + p.x * p.x * p.y * p.y + p.slope1 / 100; }, {}};
  for (const Weight& weight : {Weight(LinearWeight{}), formula}) {
    const bool is_linear = std::holds_alternative<LinearWeight>(weight);
    const auto of = [&](const Flagged& f) {
      return weigh(f.view(), is_linear ? std::span<const double>(mu) : std::span<const double>(), weight, {});
    };
    const auto of_overlay = [&](const Domain& domain) {
      return weigh({overlay, domain},
                   {m1, m2, is_linear ? std::span<const double>(mu_2) : std::span<const double>(), true}, weight, {});
    };
    expect_parts_of(of(in), of(out), of(whole), 1e-12);
    expect_parts_of(of_overlay(keep), of_overlay(take), of_overlay(Domain::everything()), 1e-12);
  }
}

TEST(Source, DetailIsCutByArea) {
  const auto polygons = random_polygons(3, 5, 1, 0);
  Domain keep, take;
  keep.keep(regions_of(polygons, 2000));
  take.take_away(regions_of(polygons, 2000));
  const Couple couple(rough(uniform(200, 1), 2), rough(uniform(900, 3), 4));
  const OverlayMesh m1 = couple.first(), m2 = couple.second();
  const auto in = detail_measure(m1, m2, false, keep, {}), out = detail_measure(m1, m2, false, take, {}),
             all = detail_measure(m1, m2, false, Domain::everything(), {});
  ASSERT_TRUE(in && out && all);
  EXPECT_GT(in->area, 0.1 * all->area);
  EXPECT_NEAR(in->area + out->area, all->area, 1e-13);
  EXPECT_NEAR(in->rho * in->area + out->rho * out->area, all->rho * all->area, 1e-13);
  EXPECT_NEAR(in->mean * in->area + out->mean * out->area, all->mean * all->area, 1e-13);
  EXPECT_LT(in->averaged, all->averaged);
  Domain far;
  far.keep(regions_of({{{{5, 5}, {6, 5}, {6, 6}}}}, 10));
  EXPECT_FALSE(detail_measure(m1, m2, false, far, {}));
}

TEST(Source, OverlayIsCutLikeItsCells) {
  const Couple couple(rough(uniform(400, 1), 2), rough(uniform(500, 3), 4));
  const Overlay overlay = couple.overlay();
  const auto polygons = random_polygons(8, 5, 1, 0);
  Domain keep, take;
  keep.keep(regions_of(polygons, 3000));
  take.take_away(regions_of(polygons, 3000));
  const Measures all = measure(overlay, {}), in = measure(OverlayCells{overlay, keep}, {}),
                 out = measure(OverlayCells{overlay, take}, {});
  expect_distribution(OverlayCells{overlay, keep});
  EXPECT_GT(in.area, 0.1);
  EXPECT_NEAR(in.area + out.area, all.area, 1e-12);
  EXPECT_NEAR(in.volume.above + out.volume.above, all.volume.above, 1e-12);
  EXPECT_NEAR(in.volume.below + out.volume.below, all.volume.below, 1e-12);
  const Measures sums = sum_up(OverlayCells{overlay, keep}, {});
  EXPECT_EQ(sums.volume.above, in.volume.above);
  Geometry united = std::make_unique<OGRPolygon>();
  for (const Rings& r : polygons) {
    const OGRPolygon p = to_ogr(r);
    united.reset(united->Union(&p));
  }
  double expected = 0;
  Overlay::Scratch scratch;
  for (std::size_t i = 0; i < overlay.items(); ++i)
    for (const OverlayCell& c : overlay.cells(i, scratch)) {
      Ring corners;
      for (unsigned k = 0; k < c.corners; ++k) {
        const Point2 p{c.origin.x + c.x[k], c.origin.y + c.y[k]};
        if (corners.empty() || !(corners.back() == p)) corners.push_back(p);
      }
      if (corners.size() < 3 || !is_valid({corners})) continue;  // cells without area but for rounding
      expected += shared_area(to_ogr({corners}), *united);
    }
  EXPECT_NEAR(in.area, expected, 1e-10);
  const auto rows = budget(OverlayCells{overlay, Domain()}, regions_of(cover(1, 5, 7, 0), 3000), {});
  expect_rows_sum_to_whole(all, rows);
  const OverlaySurface surface = surface_of({overlay, keep}, {});
  double area = 0;
  for (const auto& t : surface.triangles) area += triangle_area(surface.xy[t[0]], surface.xy[t[1]], surface.xy[t[2]]);
  EXPECT_NEAR(area, in.area, 1e-12);
}

TEST(Source, SharesOfNodesGiveBackPlaceAndHeight) {
  Flagged cells(uniform(300, 4), 8);
  Domain domain;
  domain.keep(regions_of(random_polygons(2, 4, 1, 0), 500));
  cells.cut(domain);
  const CellView view = cells.view();
  std::size_t pieces = 0;
  for_common(view, [&](const CommonCell& cell) {
    const auto z1 = cell.at_corners(cells.s.z);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(z1[k], cell.corner(k).z1, 1e-9);
    pieces += cell.piece != nullptr ? 1 : 0;
  });
  EXPECT_EQ(pieces, cells.pieces.size());
}

TEST(Source, SameBitsForAnyThreadsAndMirroredBySwapping) {
  const auto polygons = random_polygons(5, 30, 1, 0);
  const Points points = uniform(20000, 7);
  std::vector<Volume> found;
  std::vector<std::vector<RegionSums>> rows;
  for (const int threads : {1, 2, 5})
    run_with_threads(threads, [&] {
      Flagged cells(points, 1);
      Domain domain;
      domain.keep(regions_of(polygons, 40000));
      cells.cut(domain);
      found.push_back(measure(cells.view(), {}).volume);
      rows.push_back(budget(cells.view(), regions_of(polygons, 40000), {}));
    });
  for (std::size_t i = 1; i < found.size(); ++i) {
    EXPECT_EQ(found[i].above, found[0].above);
    EXPECT_EQ(found[i].below, found[0].below);
    for (std::size_t r = 0; r < rows[0].size(); ++r) {
      EXPECT_EQ(rows[i][r].area, rows[0][r].area);
      EXPECT_EQ(rows[i][r].volume.net, rows[0][r].volume.net);
    }
  }
  Flagged swapped(points, 1);
  std::swap(swapped.s.z, swapped.z2);
  Domain domain;
  domain.keep(regions_of(polygons, 40000));
  swapped.cut(domain);
  const Volume back = measure(swapped.view(), {}).volume;
  EXPECT_EQ(back.above, found[0].below);
  EXPECT_EQ(back.below, found[0].above);
}

}  // namespace
}  // namespace isopach::test
