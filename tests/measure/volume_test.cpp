// The closed forms of one cell against cutting it in two; sums over cells against the same, added up.
#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/measure/measures.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

constexpr std::array<Point2, 3> half_square = {{{0, 0}, {1, 0}, {0, 1}}};

void expect_parts(const std::array<double, 3>& d) {
  const isopach::Parts found = split_volume({0.5, d});
  const Parts expected = brute_triangle_parts(half_square, {d[0], d[1], d[2]});
  // Cutting works on coordinates, so a part much smaller than the cell has an absolute error there.
  const double lost = 1e-18 * (std::fabs(d[0]) + std::fabs(d[1]) + std::fabs(d[2]));
  EXPECT_NEAR(found.above, static_cast<double>(expected.above), 1e-14 * static_cast<double>(expected.above) + lost);
  EXPECT_NEAR(found.below, static_cast<double>(expected.below), 1e-14 * static_cast<double>(expected.below) + lost);
  EXPECT_GE(found.above, 0);
  EXPECT_GE(found.below, 0);
  const isopach::Parts mirrored = split_volume({0.5, {-d[0], -d[1], -d[2]}});
  EXPECT_EQ(mirrored.above, found.below);
  EXPECT_EQ(mirrored.below, found.above);
  for (const std::array<int, 3>& order : {std::array{1, 2, 0}, std::array{2, 0, 1}, std::array{1, 0, 2}}) {
    const auto k = [&](std::size_t i) { return d[static_cast<std::size_t>(order[i])]; };
    const isopach::Parts turned = split_volume({0.5, {k(0), k(1), k(2)}});
    EXPECT_EQ(turned.above, found.above);
    EXPECT_EQ(turned.below, found.below);
  }
}

TEST(SplitVolume, EqualsCuttingTheCellForEveryPatternOfSigns) {
  const double values[] = {-3, -1, -1e-9, 0, 1e-12, 0.5, 1, 1e6};
  for (const double a : values)
    for (const double b : values)
      for (const double c : values) expect_parts({a, b, c});
}

TEST(SplitVolume, EqualsCuttingTheCellAtRandom) {
  Random random(111);
  for (int i = 0; i < 20000; ++i) {
    std::array<double, 3> d{};
    for (double& v : d) v = std::ldexp(random.uniform(-1, 1), static_cast<int>(random.below(20)));
    expect_parts(d);
  }
}

TEST(SplitVolume, KeepsItsRelativeAccuracyInTheSmallestCorner) {
  for (const double c : {1e-3, 1e-9, 1e-100}) {
    // V+ = A c³ / (3 (c + 1) (c + 2)) for d = (c, −1, −2).
    EXPECT_DOUBLE_EQ(split_volume({0.5, {-1, c, -2}}).above, 0.5 * c * c * c / (3 * (c + 1) * (c + 2)));
    EXPECT_DOUBLE_EQ(split_volume({0.5, {1, 2, -c}}).below, 0.5 * c * c * c / (3 * (c + 1) * (c + 2)));
  }
}

TEST(SplitVolume, OfTheSmallestHeightsIsThatOfLargeOnes) {
  for (const double unit : {0x1p-400, 0x1p-600, 0x1p-1000})
    for (const std::array<double, 3>& d : {std::array{-1.0, 2.0, -3.0}, {1, 2, -3}, {1, -4, 0.5}, {-1, 0, 1}}) {
      const isopach::Parts small = split_volume({0.5, {d[0] * unit, d[1] * unit, d[2] * unit}});
      const isopach::Parts large = split_volume({0.5, d});
      EXPECT_EQ(small.above, large.above * unit);
      EXPECT_EQ(small.below, large.below * unit);
    }
}

TEST(SplitVolume, OfZeroIsZero) {
  const isopach::Parts zero = split_volume({7, {0, 0, 0}});
  EXPECT_EQ(zero.above, 0);
  EXPECT_EQ(zero.below, 0);
}

struct Sample {
  SortedTriangulation mesh;
  std::vector<double> z1, z2;
  std::vector<unsigned char> in_domain;

  [[nodiscard]] CellView view() const { return {mesh.triangulation, mesh.xy, z1, z2, in_domain}; }
};

Sample sample(std::size_t n, std::uint64_t seed, double offset = 0) {
  Random random(seed);
  Sample s{triangulate_unsorted(uniform(n, seed), {}), {}, {}, {}};
  for (std::size_t i = 0; i < s.mesh.xy.size(); ++i) {
    s.z1.push_back(offset + random.uniform(-1, 1));
    s.z2.push_back(offset + random.uniform(-1, 1.5));
  }
  for (Index t = 0; t < s.mesh.triangulation.real; ++t) s.in_domain.push_back(random.below(5) != 0 ? 1 : 0);
  return s;
}

/// f(corners, differences) over the cells of the domain.
template <class F>
void for_cells(const Sample& s, F&& f) {
  for (Index t = 0; t < s.mesh.triangulation.real; ++t) {
    if (s.in_domain[t] == 0) continue;
    const auto& v = s.mesh.triangulation.triangles[t].v;
    const auto d = [&](Index i) { return static_cast<long double>(s.z2[v[i]] - s.z1[v[i]]); };
    f(std::array{s.mesh.xy[v[0]], s.mesh.xy[v[1]], s.mesh.xy[v[2]]}, std::array{d(0), d(1), d(2)});
  }
}

TEST(Measure, AddsUpTheCellsOfTheDomainOnly) {
  const Sample s = sample(3000, 112);
  const Measures m = measure(s.view(), {});
  Parts sum;
  long double squares = 0, highest = 0, lowest = 0;
  for_cells(s, [&](const std::array<Point2, 3>& p, const std::array<long double, 3>& d) {
    const Parts part = brute_triangle_parts(p, d);
    sum = {sum.area + part.area, sum.above + part.above, sum.below + part.below};
    // The rule of the three middles of the sides is exact for squares of linear functions.
    for (std::size_t k = 0; k < 3; ++k) {
      const long double middle = (d[k] + d[(k + 1) % 3]) / 2;
      squares += part.area / 3 * middle * middle;
      highest = std::max(highest, d[k]);
      lowest = std::min(lowest, d[k]);
    }
  });
  const auto near = [](double found, long double expected) {
    EXPECT_NEAR(found, static_cast<double>(expected), 1e-13 * std::fabs(static_cast<double>(expected)));
  };
  near(m.area, sum.area);
  near(m.volume.above, sum.above);
  near(m.volume.below, sum.below);
  near(m.volume.absolute, sum.above + sum.below);
  near(m.volume.net, sum.above - sum.below);
  near(m.rho, (sum.above + sum.below) / sum.area);
  near(m.difference.mean, (sum.above - sum.below) / sum.area);
  near(m.difference.rms, std::sqrt(squares / sum.area));
  const long double mean = (sum.above - sum.below) / sum.area;
  near(m.difference.std, std::sqrt(squares / sum.area - mean * mean));
  EXPECT_EQ(m.difference.max_above, static_cast<double>(highest));
  EXPECT_EQ(m.difference.max_below, static_cast<double>(-lowest));
}

TEST(Measure, SwapsAboveAndBelowToTheLastBit) {
  Sample s = sample(20000, 113);
  const Measures forward = measure(s.view(), {});
  std::swap(s.z1, s.z2);
  const Measures back = measure(s.view(), {});
  EXPECT_EQ(back.volume.above, forward.volume.below);
  EXPECT_EQ(back.volume.below, forward.volume.above);
  EXPECT_EQ(back.volume.net, -forward.volume.net);
  EXPECT_EQ(back.rho, forward.rho);
  EXPECT_EQ(back.difference.mean, -forward.difference.mean);
  EXPECT_EQ(back.difference.rms, forward.difference.rms);
  EXPECT_EQ(back.difference.max_above, forward.difference.max_below);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(back.difference.abs_percentiles[i], forward.difference.abs_percentiles[i], 1e-12);
}

TEST(Measure, HasTheSameBitsForAnyNumberOfThreads) {
  const Sample s = sample(50000, 114);
  const Measures expected = measure(s.view(), {});
  for (const int threads : {1, 2, 7})
    run_with_threads(threads, [&] {
      const Measures m = measure(s.view(), {});
      EXPECT_EQ(m.area, expected.area);
      EXPECT_EQ(m.volume.above, expected.volume.above);
      EXPECT_EQ(m.volume.below, expected.volume.below);
      EXPECT_EQ(m.difference.rms, expected.difference.rms);
      EXPECT_EQ(m.difference.median, expected.difference.median);
      EXPECT_EQ(m.difference.nmad, expected.difference.nmad);
      EXPECT_EQ(m.difference.abs_percentiles, expected.difference.abs_percentiles);
      EXPECT_EQ(m.difference.histogram.areas, expected.difference.histogram.areas);
    });
}

TEST(Measure, OfNoCellIsZero) {
  Sample s = sample(50, 115);
  std::fill(s.in_domain.begin(), s.in_domain.end(), static_cast<unsigned char>(0));
  const Measures m = measure(s.view(), {});
  EXPECT_EQ(m.area, 0);
  EXPECT_EQ(m.rho, 0);
  EXPECT_EQ(m.volume.absolute, 0);
}

}  // namespace
}  // namespace isopach::test
