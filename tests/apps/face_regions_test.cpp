// Closed forms on random triangulations that the cuts cross everywhere, and subdivision.
#include "isopach/apps/face_regions.hpp"

#include <gtest/gtest.h>

#include "isopach/base/sum.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "tests/support/points.hpp"
#include "tests/support/polygons.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

/// The square [−1, 1]², triangulated at random; z1 = 0.
struct Sample {
  Array<Point2> xy;
  Array<double> z1, z2;
  Triangulation t;
  Array<unsigned char> in_domain;

  template <class F>
  Sample(std::size_t n, F&& d) {
    Box2 box{{-1, -1}, {1, 1}};
    Array<Point2> points;
    for (const Point2& p : test::uniform(n, 3)) points.push_back({2 * p.x - 1, 2 * p.y - 1});
    for (const double x : {-1.0, 1.0})
      for (const double y : {-1.0, 1.0}) points.push_back({x, y});
    const CurveBox curve = curve_box(box);
    (void)curve_order(points, curve, nullptr, &xy);
    t = triangulate(xy, curve, {});
    z1.assign(xy.size(), 0.0);
    for (const Point2& p : xy) z2.push_back(d(p));
    in_domain.assign(t.real, 1);
  }
  [[nodiscard]] CellView view() const { return {t, xy, z1, z2, in_domain}; }
};

/// f(u, w) at the centroids of the n² equal triangles of a triangle; u, w: shares of its second and third corner.
template <class F>
void for_subdivision(int n, const F& f) {
  for (int a = 0; a < n; ++a)
    for (int b = 0; a + b < n; ++b)
      for (int flip = 0; flip < (a + b + 1 < n ? 2 : 1); ++flip)
        f((a + (flip ? 2.0 : 1.0) / 3) / n, (b + (flip ? 2.0 : 1.0) / 3) / n);
}

TEST(FaceRegions, LinearDifferencesInClosedForm) {
  const Sample across(300, [](const Point2& p) { return p.x - 0.5; });
  const auto halves = face_regions(across.view(), FaceParts::halves, {});
  ASSERT_EQ(halves.size(), 3u);
  EXPECT_EQ(halves[1].name, "upper half");
  EXPECT_NEAR(halves[0].area, 2, 1e-12);
  EXPECT_NEAR(halves[0].volume.above, 0.25, 1e-12);
  EXPECT_NEAR(halves[0].volume.below, 0.25, 1e-12);
  EXPECT_NEAR(halves[0].directional, 0, 1e-12);
  EXPECT_NEAR(halves[0].absolute, 0.25, 1e-12);
  EXPECT_NEAR(halves[0].rms, std::sqrt(1.0 / 12), 1e-12);
  EXPECT_NEAR(halves[0].largest, 0.5, 1e-12);
  for (std::size_t k = 1; k < 3; ++k) EXPECT_NEAR(halves[k].volume.above, 0.125, 1e-12);

  const Sample up(300, [](const Point2& p) { return p.y; });
  const auto thirds = face_regions(up.view(), FaceParts::thirds, {});
  ASSERT_EQ(thirds.size(), 4u);
  const char* names[] = {"whole", "upper third", "middle third", "lower third"};
  const double directional[] = {0, 2.0 / 3, 0, -2.0 / 3}, absolute[] = {0.5, 2.0 / 3, 1.0 / 6, 2.0 / 3};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(thirds[k].name, names[k]);
    EXPECT_NEAR(thirds[k].directional, directional[k], 1e-12);
    EXPECT_NEAR(thirds[k].absolute, absolute[k], 1e-12);
    EXPECT_NEAR(thirds[k].area, k == 0 ? 2 : 2.0 / 3, 1e-12);
  }
}

TEST(FaceRegions, RoughDifferencesBySubdivision) {
  test::Random random(5);
  Sample s(60, [&](const Point2&) { return random.uniform(-1, 1); });
  for (std::size_t i = 0; i < s.in_domain.size(); i += 7) s.in_domain[i] = 0;
  double low = 1, high = -1;
  for (std::size_t i = 0; i < s.t.real; ++i)
    if (s.in_domain[i] != 0)
      for (const Index v : s.t.triangles[i].v) low = std::min(low, s.xy[v].y), high = std::max(high, s.xy[v].y);
  double area[4]{}, net[4]{}, absolute[4]{}, squares[4]{};
  constexpr int n = 150;
  const CellView view = s.view();
  for (std::size_t i = 0; i < s.t.real; ++i) {
    if (s.in_domain[i] == 0) continue;
    const auto& v = s.t.triangles[i].v;
    const double part = cell_at(view, i).area / (n * n);
    for_subdivision(n, [&](double u, double w) {
      const auto mix = [&](double p, double q, double r) { return p + u * (q - p) + w * (r - p); };
      const double x = mix(s.xy[v[0]].x, s.xy[v[1]].x, s.xy[v[2]].x);
      const double y = mix(s.xy[v[0]].y, s.xy[v[1]].y, s.xy[v[2]].y);
      const double d = mix(view.d(v[0]), view.d(v[1]), view.d(v[2]));
      if (x < 0) return;
      const double share = (y - low) / (high - low);
      for (const int k : {0, share > 2.0 / 3 ? 1 : share > 1.0 / 3 ? 2 : 3})
        area[k] += part, net[k] += part * d, absolute[k] += part * std::fabs(d), squares[k] += part * d * d;
    });
  }
  const auto regions = face_regions(view, FaceParts::thirds, {});
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(regions[k].area, area[k], 2e-3);
    EXPECT_NEAR(regions[k].volume.net, net[k], 2e-3);
    EXPECT_NEAR(regions[k].volume.absolute, absolute[k], 2e-3);
    EXPECT_NEAR(regions[k].rms * regions[k].rms * regions[k].area, squares[k], 2e-3);
  }
}

FacePolygons polygons_of(const std::vector<test::Rings>& all, const Upright& place) {
  FacePolygons polygons;
  for (const test::Rings& rings : all) {
    Region region{test::edges_of(rings), {}};
    region.parts = trapezoids(region.edges).value();
    polygons.names.push_back("p" + std::to_string(polygons.names.size()));
    polygons.regions.push_back(Regions({region}, 1000));
  }
  polygons.place = place;
  return polygons;
}

test::Ring rectangle(double x0, double y0, double x1, double y1) { return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}; }

// Rough to the point that, seen from the tilted side, triangles turn their backs.
TEST(FaceRegions, PolygonsOverATiltedFaceBySubdivision) {
  test::Random random(7);
  Sample s(60, [&](const Point2&) { return random.uniform(-0.5, 0.5); });
  for (double& z : s.z1) z = random.uniform(-0.5, 0.5);
  for (std::size_t i = 0; i < s.in_domain.size(); i += 7) s.in_domain[i] = 0;
  Upright place = Upright{}.turned_and_shifted(8, 20, 0.05);
  place.origin = {0.1, -0.2, 0.3};
  const RandomStream stream(11, 0);
  const std::vector<test::Rings> drawn{{test::star(stream, 0, {0.1, -0.2}, 0.9, 15)},
                                       {test::star(stream, 100, {-0.6, 0.3}, 0.6, 9)},
                                       {rectangle(-3, -3, 3, 3), rectangle(-0.2, -0.3, 0.5, 0.4)}};
  const FacePolygons polygons = polygons_of(drawn, place);
  const CellView view = s.view();
  const auto seen = [&](double x, double y, double z) {
    const Point3 p = place.origin + x * place.axis(0) + y * place.axis(1) + z * place.axis(2);
    return Point2{p.x, p.y};
  };
  double area[4]{}, net[4]{}, absolute[4]{}, squares[4]{};
  std::size_t turned = 0;
  constexpr int n = 120;
  for (std::size_t i = 0; i < s.t.real; ++i) {
    if (s.in_domain[i] == 0) continue;
    const auto& v = s.t.triangles[i].v;
    const auto corner = [&](std::size_t k) { return seen(s.xy[v[k]].x, s.xy[v[k]].y, s.z2[v[k]]); };
    turned += triangle_area(corner(0), corner(1), corner(2)) < 0 ? 1 : 0;
    const double part = cell_at(view, i).area / (n * n);
    for_subdivision(n, [&](double u, double w) {
      const auto mix = [&](double p, double q, double r) { return p + u * (q - p) + w * (r - p); };
      const double x = mix(s.xy[v[0]].x, s.xy[v[1]].x, s.xy[v[2]].x);
      const double y = mix(s.xy[v[0]].y, s.xy[v[1]].y, s.xy[v[2]].y);
      if (x < 0) return;
      const double z1 = mix(s.z1[v[0]], s.z1[v[1]], s.z1[v[2]]), z2 = mix(s.z2[v[0]], s.z2[v[1]], s.z2[v[2]]);
      const double d = z2 - z1;
      for (std::size_t k = 0; k < 4; ++k) {
        if (k > 0 && !test::inside(drawn[k - 1], seen(x, y, z2)) && !test::inside(drawn[k - 1], seen(-x, y, z1)))
          continue;
        area[k] += part, net[k] += part * d, absolute[k] += part * std::fabs(d), squares[k] += part * d * d;
      }
    });
  }
  EXPECT_GT(turned, 3u);
  const auto regions = face_regions(view, polygons, {});
  ASSERT_EQ(regions.size(), 4u);
  EXPECT_EQ(regions[0].name, "whole");
  EXPECT_EQ(regions[2].name, "p1");
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_GT(area[k], 0.2);
    EXPECT_NEAR(regions[k].area, area[k], 3e-3);
    EXPECT_NEAR(regions[k].volume.net, net[k], 3e-3);
    EXPECT_NEAR(regions[k].volume.absolute, absolute[k], 3e-3);
    EXPECT_NEAR(regions[k].rms * regions[k].rms * regions[k].area, squares[k], 3e-3);
    EXPECT_LE(regions[k].largest, regions[0].largest);
  }
}

TEST(FaceRegions, PolygonsCountAPairOfPlacesOnce) {
  test::Random random(9);
  const Sample s(200, [&](const Point2&) { return random.uniform(-1, 1); });
  std::vector<test::Rings> tiles;
  for (double x = 0; x < 1; x += 0.25)
    for (double y = -1; y < 1; y += 0.25) tiles.push_back({rectangle(x, y, x + 0.25, y + 0.25)});
  const test::Rings right{{{0.2, 0.1}, {0.7, -0.3}, {0.6, 0.5}}}, left{{{-0.2, 0.1}, {-0.7, -0.3}, {-0.6, 0.5}}};
  std::vector<test::Rings> drawn{right, left, {right[0], left[0]}, {rectangle(-2, -2, 2, 2)}};
  drawn.insert(drawn.end(), tiles.begin(), tiles.end());
  const auto rows = face_regions(s.view(), polygons_of(drawn, Upright{}), {});
  const auto parts = face_regions(s.view(), FaceParts::thirds, {});
  for (std::size_t k = 2; k < 4; ++k) {  // on either side, on both
    EXPECT_NEAR(rows[k].area, rows[1].area, 1e-13);
    EXPECT_NEAR(rows[k].volume.net, rows[1].volume.net, 1e-13);
    EXPECT_NEAR(rows[k].largest, rows[1].largest, 1e-13);
  }
  EXPECT_NEAR(rows[1].area, 0.18, 1e-13);
  Sum area, above, below;
  for (std::size_t k = 5; k < rows.size(); ++k)
    area.add(rows[k].area), above.add(rows[k].volume.above), below.add(rows[k].volume.below);
  for (const SideDifference& whole : {rows[0], rows[4], parts[0]}) {
    EXPECT_NEAR(whole.area, area.value(), 1e-12);
    EXPECT_NEAR(whole.volume.above, above.value(), 1e-12);
    EXPECT_NEAR(whole.volume.below, below.value(), 1e-12);
    EXPECT_NEAR(whole.rms, rows[0].rms, 1e-12);
  }
}

TEST(FaceRegions, NothingHasNothing) {
  Sample s(20, [](const Point2&) { return 1.0; });
  std::fill(s.in_domain.begin(), s.in_domain.end(), 0);
  for (const SideDifference& r : face_regions(s.view(), FaceParts::thirds, {})) EXPECT_EQ(r.absolute, 0);
}

}  // namespace
}  // namespace isopach
