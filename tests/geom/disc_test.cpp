// disc_inside against rational numbers, on discs of chance, on lattices where discs touch the sides of boxes exactly,
// and with coordinates whose differences doubles cannot hold.
#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>

#include "isopach/geom/curve.hpp"
#include "isopach/geom/disc.hpp"
#include "isopach/geom/predicates.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

using Rational = boost::multiprecision::cpp_rational;

/// (cx − side)² > r², and the centre on the right side of it.
bool oracle(const Point2& a, const Point2& b, const Point2& c, const OpenBox& box) {
  const Rational bx = Rational(b.x) - Rational(a.x), by = Rational(b.y) - Rational(a.y),
                 cx = Rational(c.x) - Rational(a.x), cy = Rational(c.y) - Rational(a.y);
  const Rational d = 2 * (bx * cy - by * cx), b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
  const Rational ux = (cy * b2 - by * c2) / d, uy = (bx * c2 - cx * b2) / d, r2 = ux * ux + uy * uy;
  const auto clears = [&](const Rational& away) { return away > 0 && away * away > r2; };
  const Rational x = ux + Rational(a.x), y = uy + Rational(a.y);
  return (std::isinf(box.low.x) || clears(x - Rational(box.low.x))) &&
         (std::isinf(box.high.x) || clears(Rational(box.high.x) - x)) &&
         (std::isinf(box.low.y) || clears(y - Rational(box.low.y))) &&
         (std::isinf(box.high.y) || clears(Rational(box.high.y) - y));
}

struct Count {
  int inside = 0, outside = 0;
};

void expect_exact(const Point2& a, const Point2& b, const Point2& c, const OpenBox& box, Count& count) {
  if (orientation(a, b, c) == 0) {
    EXPECT_FALSE(exact::disc_inside(a, b, c, box));
    return;
  }
  const bool expected = oracle(a, b, c, box);
  EXPECT_EQ(disc_inside(a, b, c, box), expected);
  EXPECT_EQ(disc_inside(a, c, b, box), expected);
  EXPECT_EQ(exact::disc_inside(b, c, a, box), expected);
  ++(expected ? count.inside : count.outside);
}

TEST(Disc, OfChance) {
  Random random(1);
  Count count;
  const auto coordinate = [&] { return random.uniform(-1, 1); };
  for (int i = 0; i < 4000; ++i) {
    const double size = std::ldexp(1.0, static_cast<int>(random.uniform(-12, 1)));
    const Point2 at{coordinate(), coordinate()};
    const auto near = [&] { return Point2{at.x + size * coordinate(), at.y + size * coordinate()}; };
    expect_exact(near(), near(), near(), {{-1, -1}, {1, 1}}, count);
  }
  EXPECT_GT(count.inside, 500);
  EXPECT_GT(count.outside, 500);
}

TEST(Disc, ThatTouchesASide) {
  Random random(2);
  Count count;
  const auto whole = [&](int most) { return std::floor(random.uniform(0, most)); };
  for (int i = 0; i < 6000; ++i) {
    const auto corner = [&] { return Point2{whole(9), whole(9)}; };
    const OpenBox box{{whole(3) - 1, whole(3) - 1}, {7 + whole(3), 7 + whole(3)}};
    expect_exact(corner(), corner(), corner(), box, count);
  }
  EXPECT_GT(count.inside, 200);
  EXPECT_FALSE(disc_inside({0, 1}, {1, 0}, {2, 1}, {{0, -1}, {3, 3}})) << "touches x = 0";
  EXPECT_TRUE(disc_inside({0, 1}, {1, 0}, {2, 1}, {{std::nextafter(0.0, -1), -1}, {3, 3}}));
}

TEST(Disc, OfCoordinatesFarApartInSize) {
  Random random(3);
  Count count;
  const auto coordinate = [&] { return random.uniform(0, 1) * std::pow(10, random.uniform(-30, 6)); };
  for (int i = 0; i < 1500; ++i) {
    const auto corner = [&] { return Point2{coordinate(), coordinate()}; };
    expect_exact(corner(), corner(), corner(), {{-coordinate(), -coordinate()}, {2e6, 2e6}}, count);
    expect_exact(corner(), corner(), corner(), {{-1e40, -1e40}, {1e40, 1e40}}, count);
    OpenBox half;
    half.low.x = 0;
    expect_exact(corner(), corner(), corner(), half, count);
  }
  EXPECT_GT(count.inside, 200);
  EXPECT_GT(count.outside, 200);
}

TEST(Disc, SlenderTriangles) {
  Random random(4);
  Count count;
  for (int i = 0; i < 2000; ++i) {
    const double x = random.uniform(0.4, 0.6), width = std::pow(10, random.uniform(-15, -1));
    const Point2 a{x, 0.5}, b{x + width, 0.5 + width / 3}, c{x + 2 * width, 0.5 + width * random.uniform(0.6, 0.73)};
    expect_exact(a, b, c, {{0.3, 0.2}, {0.8, 0.9}}, count);
  }
  EXPECT_GT(count.inside, 200);
}

TEST(CurveSquare, HoldsThePointsOfItsKeysAndNoOther) {
  for (const Family& family : families()) {
    const Points points = family.make(300, 5);
    const CurveBox box = curve_box(box_of(points));
    for (const int level : {0, 1, 2, 5, 11, 32}) {
      for (std::size_t i = 0; i < points.size(); i += 7) {
        const OpenBox square = curve_square(box, points[i], level);
        const auto prefix = [&](const Point2& p) { return level == 0 ? 0 : curve_key(box, p) >> (64 - 2 * level); };
        for (const Point2& p : points) {
          const bool in_closed =
              p.x >= square.low.x && p.x < square.high.x && p.y >= square.low.y && p.y < square.high.y;
          ASSERT_EQ(in_closed, prefix(p) == prefix(points[i])) << family.name << " level " << level;
        }
        for (const double x : {square.low.x, std::nextafter(square.low.x, -HUGE_VAL)}) {
          if (std::isinf(x)) continue;
          const Point2 edge{x, points[i].y};
          ASSERT_EQ(prefix(edge) == prefix(points[i]), x == square.low.x) << family.name << " level " << level;
        }
      }
    }
  }
}

}  // namespace
}  // namespace isopach::test
