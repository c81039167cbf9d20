// Laws of the predicates, against big integers, near degeneracy, at all magnitudes; which branch decided is checked
// too.
#include "isopach/geom/predicates.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/oracle.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

void expect_orientation(const Point2& a, const Point2& b, const Point2& c) {
  const int truth = exact_orientation(a, b, c);
  const auto where = [&] {
    return ::testing::Message() << std::hexfloat << "(" << a.x << ", " << a.y << ") (" << b.x << ", " << b.y << ") ("
                                << c.x << ", " << c.y << ")";
  };
  EXPECT_EQ(orientation(a, b, c), truth) << where();
  EXPECT_EQ(exact::orientation(a, b, c), truth) << where();
  const int filtered = orientation_filtered(a, b, c);
  EXPECT_TRUE(filtered == 2 || filtered == truth) << where();
  EXPECT_EQ(orientation(b, c, a), truth) << where();
  EXPECT_EQ(orientation(c, a, b), truth) << where();
  EXPECT_EQ(orientation(b, a, c), -truth) << where();
  EXPECT_EQ(orientation(a, c, b), -truth) << where();
  EXPECT_EQ(orientation(c, b, a), -truth) << where();
}

void expect_in_circle(const Point2& a, Point2 b, Point2 c, const Point2& d) {
  const int turn = exact_orientation(a, b, c);
  if (turn < 0) std::swap(b, c);
  const int truth = exact_in_circle(a, b, c, d);
  const auto where = [&] {
    return ::testing::Message() << std::hexfloat << "(" << a.x << ", " << a.y << ") (" << b.x << ", " << b.y << ") ("
                                << c.x << ", " << c.y << ") (" << d.x << ", " << d.y << ")";
  };
  EXPECT_EQ(in_circle(a, b, c, d), truth) << where();
  EXPECT_EQ(exact::in_circle(a, b, c, d), truth) << where();
  const int filtered = in_circle_filtered(a, b, c, d);
  EXPECT_TRUE(filtered == 2 || filtered == truth) << where();
  EXPECT_EQ(in_circle(b, c, a, d), truth) << where();
  EXPECT_EQ(in_circle(c, a, b, d), truth) << where();
  EXPECT_EQ(in_circle(b, a, c, d), -truth) << where();
  EXPECT_EQ(in_circle(d, b, c, a), -truth) << where();
  EXPECT_EQ(in_circle(a, d, c, b), -truth) << where();
  EXPECT_EQ(in_circle(a, b, d, c), -truth) << where();
  if (turn == 0 || a == d || b == d || c == d) return;
  const bool inside = tied_in_circle(a, b, c, d);
  EXPECT_EQ(inside_circle(a, b, c, d), inside) << where();
  EXPECT_EQ(inside_circle(b, c, a, d), inside) << where();
  EXPECT_EQ(inside_circle(c, a, b, d), inside) << where();
  if (truth == 0) {
    EXPECT_EQ(tie_is_inside(a, b, c, d), inside) << where();
    EXPECT_EQ(tie_is_inside(c, a, b, d), inside) << where();
  }
}

double ulps(double x, int steps) {
  for (; steps > 0; --steps) x = std::nextafter(x, std::numeric_limits<double>::infinity());
  for (; steps < 0; ++steps) x = std::nextafter(x, -std::numeric_limits<double>::infinity());
  return x;
}

class PredicateFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, PredicateFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(PredicateFamilies, EqualBigIntegersOnRandomQuadruples) {
  const Points points = GetParam().make(300, 21);
  Random random(22);
  const auto pick = [&]() -> const Point2& { return points[random.below(points.size())]; };
  for (int i = 0; i < 1000; ++i) {
    const Point2 &a = pick(), &b = pick(), &c = pick(), &d = pick();
    expect_orientation(a, b, c);
    expect_in_circle(a, b, c, d);
  }
}

TEST_P(PredicateFamilies, EqualBigIntegersOnNeighbours) {
  // Consecutive points of a sorted family are those that a triangulation asks about.
  const Points points = distinct(GetParam().make(500, 23));
  for (std::size_t i = 3; i < points.size(); ++i) {
    expect_orientation(points[i - 3], points[i - 1], points[i - 2]);
    expect_in_circle(points[i - 3], points[i - 2], points[i - 1], points[i]);
  }
}

// Kettner et al. 2008: points one ulp apart round a line, where naive arithmetic shows stripes of wrong signs.
TEST(Orientation, IsRightOneUlpFromALineAndBothBranchesDecide) {
  int undecided = 0, decided = 0;
  for (const auto& [b, c] : {std::pair{Point2{12, 12}, Point2{24, 24}}, std::pair{Point2{17.3, 17.3}, Point2{24, 24}},
                             std::pair{Point2{8.8, 12.1}, Point2{1e5 / 3, 2e5 / 7}}})
    for (int i = 0; i < 48; ++i)
      for (int j = 0; j < 48; ++j) {
        const Point2 a{ulps(0.5, i), ulps(0.5, j)};
        expect_orientation(a, b, c);
        orientation_filtered(a, b, c) == 2 ? ++undecided : ++decided;
      }
  EXPECT_GT(undecided, 500);
  EXPECT_GT(decided, 500);
}

TEST(InCircle, IsRightOneUlpFromACircleAndBothBranchesDecide) {
  int undecided = 0, decided = 0;
  const Points circle = cocircular(36, 3);
  Random random(24);
  for (int i = 0; i < 3000; ++i) {
    // Shifted and scaled so that the ulps of the four points differ.
    const double shift = std::ldexp(1.0, static_cast<int>(random.below(40)));
    Point2 p[4];
    for (Point2& q : p) {
      q = circle[random.below(circle.size())];
      q = {q.x + shift, q.y - 3 * shift};
    }
    const int steps = static_cast<int>(random.below(3)) - 1;
    p[3].y = ulps(p[3].y, random.below(8) == 0 ? 1000000 * steps : steps);
    expect_in_circle(p[0], p[1], p[2], p[3]);
    in_circle_filtered(p[0], p[1], p[2], p[3]) == 2 ? ++undecided : ++decided;
  }
  EXPECT_GT(undecided, 500);
  EXPECT_GT(decided, 100);
}

TEST(Filters, DecideGenericPointsAlone) {
  const Points points = uniform(4000, 25);
  int decided = 0;
  for (std::size_t i = 0; i + 3 < points.size(); i += 4) {
    decided += orientation_filtered(points[i], points[i + 1], points[i + 2]) != 2;
    decided += in_circle_filtered(points[i], points[i + 1], points[i + 2], points[i + 3]) != 2;
  }
  EXPECT_EQ(decided, 2000);
}

TEST(Filters, LeaveTiesToTheExactStage) {
  EXPECT_EQ(orientation_filtered({0, 0}, {1, 1}, {2, 2}), 2);
  EXPECT_EQ(orientation({0, 0}, {1, 1}, {2, 2}), 0);
  EXPECT_EQ(in_circle_filtered({0, 0}, {1, 0}, {1, 1}, {0, 1}), 2);
  EXPECT_EQ(in_circle({0, 0}, {1, 0}, {1, 1}, {0, 1}), 0);
}

// The widths at which the exact stage changes its arithmetic, and those on either side.
TEST(ExactStages, AreRightAtEveryWidthOfInteger) {
  Random random(26);
  for (int width = 1; width <= 140; ++width)
    for (int i = 0; i < 12; ++i) {
      Point2 p[4];
      for (Point2& q : p) {
        q.x = std::ldexp(1 + random.uniform(), width - 1) * (random.below(2) == 0 ? 1 : -1);
        q.y = std::ldexp(1 + random.uniform(), width - 1) * (random.below(2) == 0 ? 1 : -1);
        if (random.below(3) == 0) q.x = static_cast<double>(random.below(3));  // low bits, so that they span the width
        q = {std::trunc(q.x), std::trunc(q.y)};
      }
      expect_orientation(p[0], p[1], p[2]);
      expect_in_circle(p[0], p[1], p[2], p[3]);
      // All bits of 61- to 63-bit integers at their largest.
      const double high = std::ldexp(1.0, width) - (width <= 53 ? 1 : std::ldexp(1.0, width - 53));
      expect_in_circle({high, -high}, {-high, high}, {1, static_cast<double>(i)}, {-high, -high});
      expect_in_circle({high, high}, {-high, high}, {-high, -high}, {high, -high});
      expect_in_circle({high, high}, {-high, high}, {-high, -high}, {high, ulps(-high, 1)});
    }
}

TEST(Predicates, AreRightAtAllMagnitudes) {
  Random random(27);
  const auto number = [&](int low, int high) {
    const int exponent = low + static_cast<int>(random.below(static_cast<std::size_t>(high - low)));
    return std::ldexp(random.uniform() - 0.5, exponent);
  };
  // The same magnitude for all, then mixed ones.
  for (const int exponent : {-1070, -1000, -500, -340, -300, -200, -100, 100, 200, 300, 340, 500, 1000})
    for (int i = 0; i < 50; ++i) {
      Point2 p[4];
      for (Point2& q : p) q = {number(exponent, exponent + 3), number(exponent, exponent + 3)};
      expect_orientation(p[0], p[1], p[2]);
      expect_in_circle(p[0], p[1], p[2], p[3]);
    }
  for (int i = 0; i < 2000; ++i) {
    Point2 p[4];
    for (Point2& q : p) q = {number(-1074, 1023), number(-1074, 1023)};
    expect_orientation(p[0], p[1], p[2]);
    expect_in_circle(p[0], p[1], p[2], p[3]);
  }
}

TEST(Predicates, AreRightAtTheEndsOfTheRange) {
  const double big = std::numeric_limits<double>::max(), least = std::numeric_limits<double>::denorm_min();
  const double values[] = {big, -big, least, -least, 0, 1, std::numeric_limits<double>::min()};
  Random random(28);
  const auto pick = [&] { return values[random.below(7)]; };
  for (int i = 0; i < 1000; ++i) {
    const Point2 a{pick(), pick()}, b{pick(), pick()}, c{pick(), pick()}, d{pick(), pick()};
    expect_orientation(a, b, c);
    expect_in_circle(a, b, c, d);
  }
}

// A product that underflows loses its relative bound; if a far point then scales the rest up, an absolute guard that
// does not scale with it could let a wrong sign through.
TEST(InCircle, IsRightWhenAFarPointScalesUpAnUnderflow) {
  Random random(29);
  const auto small = [&] { return std::ldexp(random.uniform() - 0.5, -536); };
  for (int i = 0; i < 2000; ++i) {
    const Point2 far{std::ldexp(random.uniform() - 0.5, 500), std::ldexp(random.uniform() - 0.5, 500)};
    expect_in_circle(far, {small(), small()}, {small(), small()}, {small(), small()});
  }
  // Any mixture of such magnitudes. Under contraction to fused multiply-adds the difference of two equal products is
  // the rounding error of one of them, so the guard has to grow with the lifts.
  const auto mixed = [&] { return std::ldexp(random.uniform() - 0.5, static_cast<int>(random.below(600)) - 300); };
  for (int i = 0; i < 20000; ++i) {
    const Point2 a{mixed(), mixed()}, b{mixed(), mixed()}, c{mixed(), mixed()}, d{mixed(), mixed()};
    const int filtered = in_circle_filtered(a, b, c, d);
    if (filtered != 2) {
      EXPECT_EQ(filtered, exact_in_circle(a, b, c, d)) << i;
    }
  }
}

}  // namespace
}  // namespace isopach::test
