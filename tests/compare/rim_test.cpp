// The rim of the domain: cells of T are cut along both borders, so that T covers what the exact overlay covers.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "isopach/compare/compare.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/points.hpp"

namespace isopach::test {
namespace {

using Shape = std::function<bool(const Point2&)>;

Points inside(const Points& points, const Shape& shape, const Point2& shift) {
  Points kept;
  for (const Point2& p : points)
    if (shape(p)) kept.push_back({p.x + shift.x, p.y + shift.y});
  return kept;
}
bool everywhere(const Point2&) { return true; }
bool in_l(const Point2& p) { return p.x < 0.5 || p.y < 0.4; }
bool round_a_hole(const Point2& p) { return std::hypot(p.x - 0.5, p.y - 0.45) > 0.22; }
bool beside_a_crack(const Point2& p) { return std::fabs(p.x - 0.5 - 0.1 * p.y) > 0.03; }

Points lattice(int side) {
  Points points;
  for (int i = 0; i <= side; ++i)
    for (int k = 0; k <= side; ++k) points.push_back({static_cast<double>(i) / side, static_cast<double>(k) / side});
  return points;
}
Points turned(Points points, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  for (Point2& p : points) p = {c * p.x - s * p.y, s * p.x + c * p.y};
  return points;
}

struct Case {
  std::string name;
  Points a, b;
};
std::vector<Case> cases() {
  const Points many = uniform(3000, 1), others = uniform(2500, 2);
  return {{"squares", inside(many, everywhere, {0, 0}), inside(others, everywhere, {0.2, 0.1})},
          {"Ls", inside(many, in_l, {0, 0}), inside(others, in_l, {0.05, 0.03})},
          {"holes", inside(many, round_a_hole, {0, 0}), inside(others, round_a_hole, {0.1, 0.1})},
          {"an L and a hole", inside(many, in_l, {0, 0}), inside(others, round_a_hole, {0, 0})},
          {"a crack, sparse on dense", inside(uniform(8000, 3), beside_a_crack, {0, 0}), uniform(300, 4)},
          {"lattices", lattice(40), inside(lattice(30), everywhere, {1.0 / 3, 0.25})},
          {"lattices that share nodes", lattice(40), inside(lattice(20), in_l, {0.25, 0.5})},
          {"turned lattices", turned(lattice(30), 0.3), turned(lattice(25), 0.31)},
          {"the same nodes", inside(many, in_l, {0, 0}), inside(many, in_l, {0, 0})},
          {"far away", inside(many, in_l, {5e5, 4e6}), inside(others, in_l, {5e5 + 0.05, 4e6 + 0.03})}};
}

Cloud plane(const Points& points, double x, double y, double z) {
  return cloud_over(points, [&](const Point2& p) { return z + x * (p.x - 0.5) + y * (p.y - 0.5); });
}

TEST(RimOfTheDomain, CoversWhatTheOverlayCovers) {
  for (const Case& c : cases())
    for (const BorderRule border : {BorderRule::trim, BorderRule::hull}) {
      const Cloud a = plane(c.a, 0.3, -0.2, 1), b = plane(c.b, -0.1, 0.4, 1.02);
      CompareOptions common;
      common.border = border;
      CompareOptions overlay = common;
      overlay.surface = Surface::overlay;
      const Comparison t = compare(a, b, common, {}), exact = compare(a, b, overlay, {});
      const double area = exact.measures.area, gross = exact.measures.volume.absolute;
      const double digits = c.name == "far away" ? 1e-9 : 1e-12;
      EXPECT_NEAR(t.measures.area, area, digits * area) << c.name;
      EXPECT_NEAR(t.coverage, exact.coverage, digits) << c.name;
      // Planes are planes over T and over the overlay: no height from beyond a border enters.
      if (border == BorderRule::trim || c.name == "squares" || c.name == "lattices" || c.name == "turned lattices") {
        EXPECT_NEAR(t.measures.volume.net, exact.measures.volume.net, digits * gross) << c.name;
        EXPECT_NEAR(t.measures.volume.absolute, gross, digits * gross) << c.name;
      }
    }
}

TEST(RimOfTheDomain, SwappedScansSwapAboveAndBelowToTheLastBit) {
  for (const Case& c : cases()) {
    const auto hills = [](const Point2& p) { return 0.1 * std::sin(9 * p.x) * std::cos(7 * p.y); };
    const Cloud a = cloud_over(c.a, hills), b = cloud_over(c.b, [&](const Point2&p) { return 1.1 * hills(p) + 0.01; });
    const Comparison there = compare(a, b, {}, {}), back = compare(b, a, {}, {});
    EXPECT_EQ(there.measures.area, back.measures.area) << c.name;
    EXPECT_EQ(there.measures.volume.above, back.measures.volume.below) << c.name;
    EXPECT_EQ(there.measures.volume.below, back.measures.volume.above) << c.name;
    EXPECT_EQ(there.cells.pieces.size(), back.cells.pieces.size()) << c.name;
  }
}

TEST(RimOfTheDomain, TheSameBitsInAnyOrderAndForAnyNumberOfThreads) {
  const Case c = cases()[3];
  const Cloud a = plane(c.a, 0.3, -0.2, 1), b = plane(c.b, -0.1, 0.4, 1.02);
  Context one, five;
  one.threads = 1, five.threads = 5;
  const Comparison first = compare(a, b, {}, one), second = compare(shuffled(a, 1), shuffled(b, 2), {}, five);
  EXPECT_EQ(first.measures.area, second.measures.area);
  EXPECT_EQ(first.measures.volume.above, second.measures.volume.above);
  EXPECT_EQ(first.measures.volume.below, second.measures.volume.below);
  EXPECT_EQ(first.trimmed_area, second.trimmed_area);
}

// What lies over both hulls is measured or trimmed; nothing is lost between.
TEST(RimOfTheDomain, MeasuredAndTrimmedAreTheIntersectionOfTheHulls) {
  for (const Case& c : cases()) {
    const Cloud a = plane(c.a, 0, 0, 0), b = plane(c.b, 0, 0, 1);
    CompareOptions hull;
    hull.border = BorderRule::hull;
    const Comparison trimmed = compare(a, b, {}, {}), whole = compare(a, b, hull, {});
    const double digits = c.name == "far away" ? 1e-9 : 1e-12;
    EXPECT_NEAR(trimmed.measures.area / (1 - trimmed.trimmed_area), whole.measures.area, digits * whole.measures.area)
        << c.name;
  }
}

}  // namespace
}  // namespace isopach::test
