// The parameters of ISO 25178-2 against quadrature on each triangle, and against closed forms of sine waves.
#include "isopach/measure/texture/areal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/overlay/border.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

constexpr double turn = 2 * std::numbers::pi;

double cross(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Centroids of n² equal parts of every triangle: converges to the integrals without knowing their form.
ArealParameters by_quadrature(const TriangleSurface& s, int n) {
  double area = 0, first = 0;
  for (const auto& v : s.triangles) {
    const double a = cross(s.xy[v[0]], s.xy[v[1]], s.xy[v[2]]) / 2;
    area += a, first += a * (s.z[v[0]] + s.z[v[1]] + s.z[v[2]]) / 3;
  }
  ArealParameters p;
  p.area = area, p.mean = first / area;
  double m2 = 0, m3 = 0, m4 = 0, slope2 = 0, surface = 0;
  for (const auto& v : s.triangles) {
    const double a = cross(s.xy[v[0]], s.xy[v[1]], s.xy[v[2]]) / 2, part = a / (n * n);
    const double ux = s.xy[v[1]].x - s.xy[v[0]].x, uy = s.xy[v[1]].y - s.xy[v[0]].y, uz = s.z[v[1]] - s.z[v[0]];
    const double vx = s.xy[v[2]].x - s.xy[v[0]].x, vy = s.xy[v[2]].y - s.xy[v[0]].y, vz = s.z[v[2]] - s.z[v[0]];
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    surface += std::sqrt(nx * nx + ny * ny + nz * nz) / 2;
    slope2 += a * (nx * nx + ny * ny) / (nz * nz);
    const auto add = [&](double i, double j) {
      const double h = s.z[v[0]] + i / n * uz + j / n * vz - p.mean;
      p.sa += part * std::fabs(h), m2 += part * h * h, m3 += part * h * h * h, m4 += part * h * h * h * h;
    };
    for (int j = 0; j < n; ++j)
      for (int i = 0; i + j < n; ++i) {
        add(i + 1.0 / 3, j + 1.0 / 3);
        if (i + j + 1 < n) add(i + 2.0 / 3, j + 2.0 / 3);
      }
    for (const Index k : v) p.sp = std::max(p.sp, s.z[k] - p.mean), p.sv = std::max(p.sv, p.mean - s.z[k]);
  }
  p.sa /= area, p.sq = std::sqrt(m2 / area);
  p.ssk = m3 / area / std::pow(p.sq, 3), p.sku = m4 / area / std::pow(p.sq, 4);
  p.sz = p.sp + p.sv, p.sdr = surface / area - 1, p.sdq = std::sqrt(slope2 / area);
  return p;
}

void expect_near(const ArealParameters& p, const ArealParameters& q, double tolerance) {
  EXPECT_NEAR(p.area, q.area, 1e-12 * q.area);
  EXPECT_NEAR(p.mean, q.mean, 1e-11 * (1 + std::fabs(q.mean)));
  for (const auto value :
       {&ArealParameters::sa, &ArealParameters::sq, &ArealParameters::sz, &ArealParameters::sp, &ArealParameters::sv,
        &ArealParameters::ssk, &ArealParameters::sku, &ArealParameters::sdr, &ArealParameters::sdq})
    EXPECT_NEAR(p.*value, q.*value, tolerance * (1 + std::fabs(q.*value)));
}

struct Mesh {
  SortedTriangulation t;
  Array<double> z;
};
test::Points scaled(test::Points points, double x, double y) {
  for (Point2& p : points) p.x *= x, p.y *= y;
  return points;
}
template <class Height>
Mesh mesh_of(const test::Points& points, Height&& height) {
  Mesh m{triangulate_unsorted(points, {}), {}};
  for (const Point2& p : m.t.xy) m.z.push_back(height(p));
  return m;
}
TriangleSurface surface_of(const Mesh& m, unsigned pieces, std::span<const unsigned char> kept = {}) {
  return refined(m.t.triangulation, m.t.xy, m.z, kept, pieces, {});
}

TEST(Areal, IsTheIntegralOverEveryTriangle) {
  test::Random random(3);
  for (const double lift : {0.0, 1e6}) {
    const Mesh m =
        mesh_of(scaled(test::uniform(60, 2), 5, 3), [&](const Point2&) { return lift + random.uniform(-1, 2); });
    expect_near(areal_parameters(surface_of(m, 1), {}), by_quadrature(surface_of(m, 1), 300), lift == 0 ? 3e-5 : 1e-4);
  }
}

TEST(Areal, HeightsOfAnySizeHaveTheSameShape) {
  const auto with = [](int exponent) {
    test::Random random(4);
    const Mesh m = mesh_of(scaled(test::uniform(60, 2), 5, 3),
                           [&](const Point2&) { return std::ldexp(random.uniform(-1, 2), exponent); });
    return areal_parameters(surface_of(m, 1), {});
  };
  const ArealParameters plain = with(0);
  for (const int exponent : {-900, -400, -1, 200, 500}) {
    const ArealParameters p = with(exponent);
    EXPECT_EQ(p.ssk, plain.ssk) << exponent;
    EXPECT_EQ(p.sku, plain.sku) << exponent;
    EXPECT_EQ(p.sq, std::ldexp(plain.sq, exponent)) << exponent;
    EXPECT_EQ(p.sa, std::ldexp(plain.sa, exponent)) << exponent;
    EXPECT_EQ(p.sq_points, std::ldexp(plain.sq_points, exponent)) << exponent;
  }
}

TEST(Areal, FlatSurfacesAndNoneAreZeros) {
  const Mesh m = mesh_of(scaled(test::uniform(60, 2), 5, 3), [](const Point2&) { return 7.0; });
  const ArealParameters p = areal_parameters(surface_of(m, 3), {});
  EXPECT_EQ(p.mean, 7);
  for (const double v : {p.sa, p.sq, p.sz, p.ssk, p.sku, p.sdr, p.sdq}) EXPECT_EQ(v, 0);
  EXPECT_EQ(areal_parameters({}, {}).area, 0);
}

TEST(Areal, TiltedPlaneHasTheClosedForms) {
  const Mesh m = mesh_of(test::framed_square(50, 1), [](const Point2& p) { return p.x; });
  const ArealParameters p = areal_parameters(surface_of(m, 1), {});
  EXPECT_NEAR(p.sa, 0.25, 1e-12);
  EXPECT_NEAR(p.sq, std::sqrt(1.0 / 12), 1e-12);
  EXPECT_NEAR(p.sku, 1.8, 1e-12);
  EXPECT_NEAR(p.sdr, std::sqrt(2.0) - 1, 1e-12);
  EXPECT_NEAR(p.sdq, 1, 1e-12);
  EXPECT_NEAR(p.sz, 1, 1e-12);
}

TEST(Areal, CutTrianglesFillTheSameAreaAndMeet) {
  const Mesh m = mesh_of(scaled(test::uniform(80, 4), 5, 3), [](const Point2& p) { return p.x * p.y; });
  Array<unsigned char> kept(m.t.triangulation.real);
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = i % 3 != 0;
  const TriangleSurface whole = surface_of(m, 1, kept);
  for (const unsigned pieces : {2u, 3u, 5u}) {
    const TriangleSurface cut = surface_of(m, pieces, kept);
    EXPECT_EQ(cut.triangles.size(), whole.triangles.size() * pieces * pieces);
    double area = 0, sum = 0;
    for (const auto& v : whole.triangles) sum += cross(whole.xy[v[0]], whole.xy[v[1]], whole.xy[v[2]]);
    for (const auto& v : cut.triangles) {
      const double a = cross(cut.xy[v[0]], cut.xy[v[1]], cut.xy[v[2]]);
      EXPECT_GT(a, 0);
      area += a;
    }
    EXPECT_NEAR(area, sum, 1e-12 * sum);
    // the surface is a quadratic, which the smooth one reproduces
    for (std::size_t i = 0; i < cut.xy.size(); ++i) EXPECT_NEAR(cut.z[i], cut.xy[i].x * cut.xy[i].y, 1e-6) << pieces;
    for (std::size_t i = m.t.xy.size(); i < cut.xy.size(); ++i)  // points on sides are shared: no place twice
      EXPECT_NE(cut.xy[i], cut.xy[i - 1]);
  }
}

double sdr_of_sine(double slope) {  // mean of √(1 + slope² cos²) − 1
  const double k2 = slope * slope;
  return std::sqrt(1 + k2) * std::comp_ellint_2(std::sqrt(k2 / (1 + k2))) * 2 / std::numbers::pi - 1;
}

/// 10 by 10, n + 1 nodes a side, each up to a fifth of their distance off its place, those on the border along it.
test::Points uneven_grid(int n) {
  test::Random random(8);
  test::Points out;
  for (int row = 0; row <= n; ++row)
    for (int column = 0; column <= n; ++column) {
      const auto place = [&](int k) { return 10 * (k + (k == 0 || k == n ? 0 : random.uniform(-0.2, 0.2))) / n; };
      const double x = place(column);
      out.push_back({x, place(row)});
    }
  return out;
}

TEST(Areal, SineWavesAt20PointsAWavelength) {  // 10 wavelengths by 10, 20 × 20 points each
  for (const bool even : {false, true}) {
    const test::Points nodes = even ? uneven_grid(200) : scaled(test::framed_square(40000, 1), 10, 10);
    const double amplitude = 0.1, slope = turn * amplitude;
    const auto check = [](double value, double truth, const char* name) {
      EXPECT_NEAR(value, truth, 0.005 * truth) << name;
    };
    const Mesh m = mesh_of(nodes, [&](const Point2& p) { return amplitude * std::sin(turn * p.x); });
    const Footprint supported = footprint(m.t.triangulation, m.t.xy, true, {0}, {});  // no slivers along the rim
    Array<unsigned char> kept(m.t.triangulation.real);
    for (Index i = 0; i < m.t.triangulation.real; ++i) kept[i] = supported.keeps(i) ? 1 : 0;
    const ArealParameters p = areal_parameters(surface_of(m, 3, kept), {});
    check(p.sa, 2 * amplitude / std::numbers::pi, "Sa");
    check(p.sq, amplitude / std::sqrt(2.0), "Sq");
    check(p.sz, 2 * amplitude, "Sz");
    check(p.sku, 1.5, "Sku");
    check(p.sdq, slope / std::sqrt(2.0), "Sdq");
    check(p.sdr, sdr_of_sine(slope), "Sdr");
    EXPECT_NEAR(p.ssk, 0, 0.005);
    const Mesh crossed =
        mesh_of(nodes, [&](const Point2& q) { return amplitude * std::sin(turn * q.x) * std::sin(turn * q.y); });
    const ArealParameters c = areal_parameters(surface_of(crossed, 3, kept), {});
    check(c.sa, 4 * amplitude / (std::numbers::pi * std::numbers::pi), "Sa, crossed");
    check(c.sq, amplitude / 2, "Sq, crossed");
    check(c.sku, 2.25, "Sku, crossed");
    check(c.sz, 2 * amplitude, "Sz, crossed");
    check(c.sdq, slope / std::sqrt(2.0), "Sdq, crossed");
  }
}

TEST(Areal, SameBitsForAnyNumberOfThreads) {
  const Mesh m = mesh_of(scaled(test::uniform(9000, 2), 5, 3), [](const Point2& p) { return std::sin(3 * p.x + p.y); });
  std::vector<double> first;
  for (const int threads : {1, 2, 5}) {
    ArealParameters p;
    run_with_threads(threads, [&] { p = areal_parameters(surface_of(m, 2), {}); });
    const std::vector<double> now{p.area, p.mean, p.sa, p.sq, p.sz, p.sp, p.sv, p.ssk, p.sku, p.sdr, p.sdq};
    if (first.empty()) first = now;
    EXPECT_EQ(first, now);
  }
}

// Triangles average the noise of their corners: of white noise the areal Sq keeps 71 % where they are plane, more
// where they bend.
TEST(Areal, WhiteNoiseCountsInFullOverThePoints) {
  const RandomStream random(5, 0);
  std::uint64_t node = 0;
  const Mesh m = mesh_of(test::framed_square(20000, 3), [&](const Point2&) { return 7 + 0.5 * random.normal(node++); });
  const ArealParameters linear = areal_parameters(surface_of(m, 1), {});
  const ArealParameters cubic = areal_parameters(surface_of(m, 3), {});
  EXPECT_NEAR(linear.sq, 0.5 * std::sqrt(0.5), 0.01);
  EXPECT_GT(cubic.sq, linear.sq);
  for (const ArealParameters& p : {linear, cubic}) EXPECT_NEAR(p.sq_points, 0.5, 0.01);
  EXPECT_EQ(linear.sq_points, cubic.sq_points);  // corners of cut triangles are no points
}

TEST(Areal, OverThePointsOfTheTrianglesAlone) {
  TriangleSurface s;
  s.xy = {{0, 0}, {1, 0}, {0, 1}, {9, 9}};
  s.z = {1, 2, 6, 100};
  s.triangles = {{0, 1, 2}};
  s.measured = 4;
  EXPECT_NEAR(areal_parameters(s, {}).sq_points, std::sqrt((4.0 + 1 + 9) / 3), 1e-14);
}

}  // namespace
}  // namespace isopach
