// Quantiles and histograms by area against cutting every cell at the value in question.
#include "isopach/measure/volume/distribution.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "isopach/delaunay/triangulate.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

struct Sample {
  SortedTriangulation mesh;
  std::vector<double> z1, z2;
  std::vector<unsigned char> in_domain;

  [[nodiscard]] CellView view() const { return {mesh.triangulation, mesh.xy, z1, z2, in_domain}; }
};

Sample sample(std::size_t n, std::uint64_t seed, double (*d)(Random&, const Point2&)) {
  Random random(seed);
  Sample s{triangulate_unsorted(uniform(n, seed), {}), {}, {}, {}};
  for (const Point2& p : s.mesh.xy) {
    s.z1.push_back(0);
    s.z2.push_back(d(random, p));
  }
  s.in_domain.assign(s.mesh.triangulation.real, 1);
  for (Index t = 0; t < s.mesh.triangulation.real; t += 7) s.in_domain[t] = 0;
  return s;
}
double rough(Random& random, const Point2&) { return random.uniform(-1, 1.5); }
double mostly_zero(Random& random, const Point2& p) { return p.x < 0.7 ? 0 : random.uniform(-1, 1); }
double one_outlier(Random& random, const Point2& p) { return p.x < 0.001 ? 1e5 : 1e-3 * random.bell(); }
double plane(Random&, const Point2& p) { return p.x; }
double constant(Random&, const Point2&) { return 0.3; }
double few_values(Random& random, const Point2&) { return 0.25 * static_cast<double>(random.below(5)) - 0.5; }
double tiny_beside_huge(Random& random, const Point2& p) {
  return p.x < 0.5 ? 1e-200 * random.uniform(-1, 1) : (p.x < 0.9 ? 1e-9 : 1e3) * random.bell();
}
double rough_in_a_corner(Random& random, const Point2& p) {
  return p.x + p.y < 0.02 ? random.uniform(-1, 50) : 1e-4 * p.x;
}

/// Area of the domain where low <= d <= high.
long double brute_area(const Sample& s, long double low, long double high) {
  long double sum = 0;
  for (Index t = 0; t < s.mesh.triangulation.real; ++t) {
    if (s.in_domain[t] == 0) continue;
    const auto& v = s.mesh.triangulation.triangles[t].v;
    const auto d = [&](Index i) { return static_cast<long double>(s.z2[v[i]] - s.z1[v[i]]); };
    sum += brute_area_between({s.mesh.xy[v[0]], s.mesh.xy[v[1]], s.mesh.xy[v[2]]}, {d(0), d(1), d(2)}, low, high);
  }
  return sum;
}

TEST(AreaBelow, EqualsCuttingTheCell) {
  const std::array<Point2, 3> p = {{{0, 0}, {1, 0}, {0, 1}}};
  Random random(121);
  for (int i = 0; i < 20000; ++i) {
    const auto value = [&] { return static_cast<double>(random.below(9)) - 4; };  // equal values too
    const std::array<double, 3> d{value(), value(), random.below(2) == 0 ? value() : random.uniform(-4, 4)};
    const double v = random.uniform(-5, 5);
    EXPECT_NEAR(area_below({0.5, d}, v), static_cast<double>(brute_area_between(p, {d[0], d[1], d[2]}, -1e9L, v)),
                1e-15);
  }
}

TEST(AreaBelow, CountsAFlatCellWhole) {
  EXPECT_EQ(area_below({0.5, {2, 2, 2}}, 2), 0.5);
  EXPECT_EQ(area_below({0.5, {2, 2, 2}}, std::nextafter(2.0, 0)), 0);
}

void expect_quantiles(const Sample& s, const std::string& name) {
  const double area = static_cast<double>(brute_area(s, -1e9L, 1e9L));
  double limit = 0;
  for (const double z : s.z2) limit = std::max(limit, std::fabs(z));
  std::vector<Quantile> wanted;
  for (const double share : {0.01, 0.25, 0.5, 0.9, 0.95, 0.999})
    for (const auto& [absolute, centre] : {std::pair{false, 0.0}, std::pair{true, 0.0}, std::pair{true, 0.3}})
      wanted.push_back({share, absolute, centre});
  wanted.push_back({0.5, true, 0, 6});  // about the median
  wanted.push_back({0.9, true, 0, wanted.size() - 1});
  const CellView view = s.view();
  const std::vector<double> found = describe(view, wanted, 101, {}).quantiles;
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const auto& [share, absolute, given, about] = wanted[i];
    const double centre = about == Quantile::nothing ? given : found[about];
    const auto area_up_to = [&, absolute = absolute](long double v) {
      return static_cast<double>(absolute ? brute_area(s, centre - v, centre + v) : brute_area(s, -1e9L, v));
    };
    const double step = 1e-9 * (limit + std::fabs(centre)), target = share * area;
    EXPECT_GE(area_up_to(static_cast<long double>(found[i]) + step), target * (1 - 1e-12)) << name << " " << share;
    if (!absolute || found[i] > step) {
      EXPECT_LE(area_up_to(static_cast<long double>(found[i]) - step), target * (1 + 1e-12)) << name << " " << share;
    }
  }
}

TEST(Quantiles, HaveTheirShareOfTheAreaOnEitherSide) {
  for (const std::size_t n : {20, 500, 3000}) {
    expect_quantiles(sample(n, 122, rough), "rough");
    expect_quantiles(sample(n, 123, mostly_zero), "mostly zero");
    expect_quantiles(sample(n, 124, plane), "plane");
  }
  expect_quantiles(sample(3000, 125, one_outlier), "one outlier");
  for (const auto& d : {constant, few_values, tiny_beside_huge}) expect_quantiles(sample(2000, 129, d), "atoms");
  expect_quantiles(sample(90000, 130, rough_in_a_corner), "more cells than are sampled");
}

// Quiet slots, slots in which quantiles lie, cells over many bins and outliers: all must be counted where they belong.
void expect_histogram(const Sample& s, std::size_t bins, const std::string& name) {
  const CellView view = s.view();
  for (const bool with_quantiles : {false, true}) {
    const std::vector<Quantile> wanted =
        with_quantiles ? std::vector<Quantile>{{0.5}, {0.9, true}} : std::vector<Quantile>{};
    const Described found = describe(view, wanted, bins, {});
    const Histogram& h = found.histogram;
    ASSERT_EQ(h.areas.size(), bins);
    const double area = static_cast<double>(brute_area(s, -1e9L, 1e9L));
    EXPECT_NEAR(found.totals.of.area.value(), area, 1e-13) << name;
    for (std::size_t k = 0; k < bins; ++k) {
      const long double low = k == 0 ? -1e9L : h.edges[k], high = k + 1 == bins ? 1e9L : h.edges[k + 1];
      EXPECT_NEAR(h.areas[k], static_cast<double>(brute_area(s, low, high)), 1e-13) << name << " " << k;
    }
    EXPECT_NEAR(std::accumulate(h.areas.begin(), h.areas.end(), 0.0), area, 1e-13) << name;
  }
}

TEST(Histogram, EqualsCuttingAndAddsUpToTheDomain) {
  for (const std::size_t bins : {1, 5, 40}) {
    expect_histogram(sample(2000, 126, rough), bins, "rough");
    expect_histogram(sample(2000, 126, plane), bins, "plane");
    expect_histogram(sample(2000, 126, rough_in_a_corner), bins, "rough in a corner");
    expect_histogram(sample(2000, 126, one_outlier), bins, "one outlier");
  }
}

// The number of bins in a unit of d is infinite there, and times a d of 0 no number.
TEST(Histogram, OfHeightsNextToZeroIsThatOfLargerOnes) {
  Sample s = sample(2000, 131, rough);
  const std::vector<double> expected = describe(s.view(), {}, 40, {}).histogram.areas;
  for (double& z : s.z2) z *= 1e-309;
  const std::vector<double> found = describe(s.view(), {{0.5}, {0.9, true}}, 40, {}).histogram.areas;
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], expected[k], 1e-9) << k;
}

TEST(Histogram, OfAMeasureIsSymmetricAndHoldsTheDomain) {
  for (const auto& d : {rough, mostly_zero, plane, one_outlier}) {
    const Sample s = sample(2000, 127, d);
    const Measures m = measure(s.view(), {});
    const Histogram& h = m.difference.histogram;
    ASSERT_EQ(h.edges.size(), h.areas.size() + 1);
    for (std::size_t k = 0; k < h.edges.size(); ++k) EXPECT_EQ(h.edges[k], -h.edges[h.edges.size() - 1 - k]);
    EXPECT_NEAR(std::accumulate(h.areas.begin(), h.areas.end(), 0.0), m.area, 1e-12);
    for (const double area : h.areas) EXPECT_GE(area, 0);
  }
}

TEST(Statistics, OfAPlaneAreThoseOfAUniformVariable) {
  // d = x over the unit square with its corners: uniform on [0, 1].
  Points square = uniform(3000, 128);
  square.insert(square.end(), {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  Sample s{triangulate_unsorted(square, {}), {}, {}, {}};
  for (const Point2& p : s.mesh.xy) s.z1.push_back(1), s.z2.push_back(1 + p.x);
  s.in_domain.assign(s.mesh.triangulation.real, 1);
  const DifferenceStatistics d = measure(s.view(), {}).difference;
  EXPECT_NEAR(d.mean, 0.5, 1e-12);
  EXPECT_NEAR(d.rms, std::sqrt(1.0 / 3), 1e-12);
  EXPECT_NEAR(d.std, std::sqrt(1.0 / 12), 1e-12);
  EXPECT_NEAR(d.median, 0.5, 1e-12);
  EXPECT_NEAR(d.nmad, 1.4826 * 0.25, 1e-12);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(d.abs_percentiles[i], percentile_levels[i] / 100.0, 1e-12);
  EXPECT_EQ(d.max_above, 1);
  EXPECT_EQ(d.max_below, 0);
}

}  // namespace
}  // namespace isopach::test
