#include "isopach/apps/self_turns.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/random.hpp"

namespace isopach {
namespace {

/// Points of the surface of a box with these half sides.
OrientedCloud box(double a, double b, double c) {
  OrientedCloud cloud;
  test::Random random(3);
  const double half[3] = {a, b, c}, area[3] = {b * c, a * c, a * b};
  for (int i = 0; i < 6000; ++i) {
    const double u = random.uniform() * (area[0] + area[1] + area[2]);
    const int side = u < area[0] ? 0 : u < area[0] + area[1] ? 1 : 2;
    double p[3];
    for (int k = 0; k < 3; ++k) p[k] = half[k] * random.uniform(-1, 1);
    p[side] = half[side] * (random.uniform() < 0.5 ? -1 : 1);
    cloud.points.push_back({p[0], p[1], p[2]});
  }
  cloud.areas.resize(cloud.points.size());
  std::fill(cloud.areas.begin(), cloud.areas.end(), 1.0);
  return cloud;
}

double angle_between(const Motion& a, const std::array<double, 9>& b) {
  double trace = 0;
  for (std::size_t i = 0; i < 9; ++i) trace += a.rotation[i] * b[i];
  return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0)) * 180 / std::numbers::pi;
}

double nearest(const std::vector<Motion>& turns, const std::array<double, 9>& symmetry) {
  double least = 180;
  for (const Motion& m : turns) least = std::min(least, angle_between(m, symmetry));
  return least;
}

constexpr std::array<double, 9> half_turn_z{-1, 0, 0, 0, -1, 0, 0, 0, 1}, quarter_turn_z{0, -1, 0, 1, 0, 0, 0, 0, 1},
    third_turn{0, 0, 1, 1, 0, 0, 0, 1, 0};

TEST(SelfTurns, ThreeSidesAllowHalfTurnsAlone) {
  const std::vector<Motion> turns = self_turns(box(40, 22, 6), {});
  EXPECT_EQ(turns.size(), 3u);
  EXPECT_LT(nearest(turns, half_turn_z), 3);
}

TEST(SelfTurns, SquareBarTurnsByQuarters) {
  EXPECT_LT(nearest(self_turns(box(20, 20, 60), {}), quarter_turn_z), 15);
  EXPECT_LT(nearest(self_turns(box(40, 40, 4), {}), quarter_turn_z), 15);
}

TEST(SelfTurns, CubeTurnsAboutItsDiagonals) {
  const std::vector<Motion> turns = self_turns(box(20, 20, 20), {});
  // Starts: a search leads home from twice as far.
  EXPECT_LT(nearest(turns, third_turn), 32);
  EXPECT_LT(nearest(turns, quarter_turn_z), 32);
}

}  // namespace
}  // namespace isopach
