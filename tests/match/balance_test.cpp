#include "isopach/match/surface/balance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numeric>

#include "tests/match/square.hpp"

namespace isopach {
namespace {

constexpr std::size_t patch = 32;

MatchSurface scan(std::size_t n, std::uint64_t seed) {
  return test::square(n, seed, [](const Point2&, std::size_t) { return 0.0; });
}

struct Located {
  MatchSurface moving, fixed;
  std::array<ResidualSide, 2> sides;

  Located(std::size_t n_moving, std::size_t n_fixed) : moving(scan(n_moving, 1)), fixed(scan(n_fixed, 2)) {
    sides[0].nodes = sides[1].target = &moving;
    sides[1].nodes = sides[0].target = &fixed;
    sides[1].moving_nodes = false;
    for (ResidualSide& side : sides) {
      const std::size_t n = side.nodes->xy.size();
      side.hint.assign(n, 0);
      side.n.assign(n, std::numeric_limits<double>::quiet_NaN());
      std::uint64_t visited = 0;
      for (std::size_t i = 0; i < n; ++i) {
        const Location found = locate(side.nodes->xy[i], side.target->t, side.target->xy, side.hint[i], visited);
        if (found.kind != Location::Kind::outside && side.target->facets[side.hint[i]].exists()) side.n[i] = 0;
      }
    }
  }
  void balance() {
    const Motion still;
    isopach::balance(sides, {View(sides[0], still, {0, 0, 0}, 1), View(sides[1], still, {0, 0, 0}, 1)}, patch);
  }
  /// What the noise of each node counts for, straight from the definition.
  [[nodiscard]] std::array<std::vector<double>, 2> counts() const {
    std::array<std::vector<double>, 2> all;
    for (std::size_t s = 0; s < 2; ++s) all[s].assign(sides[s].n.size(), 0.0);
    for (std::size_t s = 0; s < 2; ++s)
      for (std::size_t i = 0; i < sides[s].n.size(); ++i) {
        if (std::isnan(sides[s].n[i])) continue;
        const MatchSurface& target = *sides[s].target;
        const auto& v = target.t.triangles[sides[s].hint[i]].v;
        Eigen::Matrix3d corners;
        for (int k = 0; k < 3; ++k) corners.col(k) << target.xy[v[k]].x, target.xy[v[k]].y, 1;
        const Eigen::Vector3d share =
            corners.fullPivLu().solve(Eigen::Vector3d(sides[s].nodes->xy[i].x, sides[s].nodes->xy[i].y, 1));
        all[s][i] += sides[s].weight(i);
        for (int k = 0; k < 3; ++k) all[1 - s][v[k]] += sides[s].weight(i) * share(k);
      }
    return all;
  }
};

double unevenness(const std::vector<double>& counts) {
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t begin = 0; begin + patch <= counts.size(); begin += patch) {
    double mean = 0;
    for (std::size_t i = begin; i < begin + patch; ++i) mean += counts[i] / patch;
    for (std::size_t i = begin; i < begin + patch; ++i, ++n) sum += (counts[i] / mean - 1) * (counts[i] / mean - 1);
  }
  return sum / static_cast<double>(n);
}

class Densities : public testing::TestWithParam<std::size_t> {};

TEST_P(Densities, NoiseCountsMoreEvenly) {
  Located l(4000, GetParam());
  const auto before = l.counts();
  l.balance();
  const auto after = l.counts();
  for (std::size_t s = 0; s < 2; ++s) EXPECT_LT(unevenness(after[s]), 0.65 * unevenness(before[s])) << "side " << s;
}
INSTANTIATE_TEST_SUITE_P(Balance, Densities, testing::Values(4000, 2000, 500));

TEST(Balance, TheSumRemains) {
  Located l(3000, 1500);
  const auto sum = [](const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); };
  const auto before = l.counts();
  l.balance();
  const auto after = l.counts();
  const double all = sum(before[0]) + sum(before[1]);
  EXPECT_NEAR(sum(after[0]) + sum(after[1]), all, 1e-5 * all);
  for (const ResidualSide& side : l.sides)
    for (const float factor : side.balance) EXPECT_GE(factor, 0);
}

TEST(Balance, ANodeOfWeightZeroKeepsIt) {
  Located l(1000, 1000);
  l.moving.weight[500] = 0;
  l.balance();
  EXPECT_EQ(l.sides[0].weight(500), 0);
}

// The variance of a mean difference under noise, by the counts: against that by the plain areas.
TEST(Balance, AMeanHasLessNoise) {
  Located l(4000, 4000);
  const auto variance = [](const std::array<std::vector<double>, 2>& counts) {
    double squares = 0, sum = 0;
    for (const auto& side : counts)
      for (const double c : side) squares += c * c, sum += c;
    return squares / (sum * sum);
  };
  const double before = variance(l.counts());
  l.balance();
  EXPECT_LT(variance(l.counts()), 0.93 * before);
}

}  // namespace
}  // namespace isopach
