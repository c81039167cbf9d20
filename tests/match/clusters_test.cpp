#include "isopach/match/clusters.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/random.hpp"

namespace isopach {
namespace {

// Three shifts, seen by cells in a row of squares of a 16 × 16 board, along a Z-order curve.
constexpr std::size_t side = 16;
constexpr std::size_t shift_x = 3, shift_z = 5;

struct Place {
  double x, y;
};
Place place(std::size_t i) {
  std::size_t x = 0, y = 0;
  for (std::size_t bit = 0; bit < 4; ++bit) x |= (i >> (2 * bit) & 1) << bit, y |= (i >> (2 * bit + 1) & 1) << bit;
  return {static_cast<double>(x), static_cast<double>(y)};
}

/// Each cell: one residual of each motion, with the error that `error` gives to (place, motion).
template <class Error>
std::vector<ScoreCell> board(const Error& error) {
  std::vector<ScoreCell> cells(side * side);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Place p = place(i);
    for (std::size_t k = shift_x; k <= shift_z; ++k) {
      Vector7 j{};
      j[k] = 1;
      cells[i].information.add(j, 1);
      cells[i].score[k] = error(p, k);
    }
    cells[i].weight = 1, cells[i].x = p.x, cells[i].y = p.y;
  }
  return cells;
}

const std::vector<Vector7> shifts{{0, 0, 0, 1, 0, 0, 0}, {0, 0, 0, 0, 1, 0, 0}, {0, 0, 0, 0, 0, 1, 0}};

double variance(const Symmetric7& m, std::size_t k) {
  std::size_t i = 0;
  for (std::size_t r = 0; r < k; ++r) i += parameters - r;
  return m.m[i];
}

/// Mean over boards with errors of their own, over the truth `expected`.
template <class Make>
double mean_ratio(const Make& make, double expected) {
  constexpr int boards = 40;
  double sum = 0;
  for (int b = 0; b < boards; ++b) sum += variance(clustered_scores(make(b), shifts), shift_z) / boards;
  return sum / expected;
}

TEST(Clusters, IndependentCellsAddTheirVariances) {
  const double ratio = mean_ratio(
      [](int b) {
        test::Random random(static_cast<std::uint64_t>(b + 1));
        return board([&](const Place&, std::size_t) { return random.bell(); });
      },
      side * side);
  EXPECT_GT(ratio, 0.9);
  EXPECT_LT(ratio, 1.2);
}

// Columns of the board that err as a whole: the variance of a sum is that of 16 columns of 16 cells each, 16 times that
// of independent cells. Clusters of four cells alone would give a quarter of it and less.
TEST(Clusters, StripsThatErrAsAWholeAreFound) {
  for (const bool across : {false, true}) {
    const double ratio = mean_ratio(
        [&](int b) {
          test::Random random(static_cast<std::uint64_t>(b + 1));
          std::array<double, side> strip{};
          for (double& s : strip) s = random.bell();
          return board([&](const Place& p, std::size_t k) {
            const double of_strip = strip[static_cast<std::size_t>(across ? p.x : p.y)];
            return 0.3 * random.bell() + (k == shift_z ? of_strip : 0);
          });
        },
        side * side * (side + 0.09));
    EXPECT_GT(ratio, 0.7) << across;
    EXPECT_LT(ratio, 1.4) << across;
  }
}

TEST(Clusters, NothingIsSaidOutsideTheSpan) {
  test::Random random(1);
  const auto cells = board([&](const Place&, std::size_t) { return random.bell(); });
  const std::vector<Vector7> along_x{{0, 0, 0, 1, 0, 0, 0}};
  const Symmetric7 m = clustered_scores(cells, along_x);
  EXPECT_GT(variance(m, shift_x), 0);
  EXPECT_EQ(variance(m, shift_z), 0);
  EXPECT_EQ(variance(clustered_scores({}, shifts), shift_x), 0);
  EXPECT_EQ(variance(clustered_scores(cells, {}), shift_x), 0);
}

}  // namespace
}  // namespace isopach
