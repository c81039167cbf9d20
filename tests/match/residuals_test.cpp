// Residuals against every triangle tried, their derivatives against differences; motions against matrices.
#include "isopach/match/surface/residuals.hpp"

#include <gtest/gtest.h>

#include "isopach/base/random.hpp"
#include "isopach/geom/predicates.hpp"
#include "isopach/measure/measures.hpp"
#include "tests/match/poses.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

MatchSurface surface(const test::Points& points, std::uint64_t seed) {
  Box2 box;
  for (const Point2& p : points) box.add(p);
  Array<Point2> sorted;
  (void)curve_order(points, curve_box(box), nullptr, &sorted);
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  test::Random random(seed);
  Array<double> z;
  for (const Point2& p : sorted) z.push_back(0.3 * std::sin(3 * p.x) * p.y + 0.05 * random.uniform(-1, 1));
  return make_surface(sorted, z, curve_box(box), true, 0, {});
}

// The same with slopes that are not smoothed and facets that do not rise, so that derivatives are those of the
// residuals themselves.
MatchSurface sharp(MatchSurface s) {
  for (std::size_t i = 0; i < s.facets.size(); ++i) {
    Facet& f = s.facets[i];
    if (!f.exists()) continue;
    f.smooth_gx = f.gx, f.smooth_gy = f.gy, f.rise = 0;
    s.cosine[i] = static_cast<float>(1 / std::sqrt(1 + f.gx * f.gx + f.gy * f.gy));
  }
  return s;
}

Motion some_motion(double size) {
  return moved(Motion{}, {size, -2 * size, 3 * size, size, size, -size, size}, {0.5, 0.5, 0});
}

// Σ area · n²/2 over both sides, by trying every triangle.
double brute_force(const MatchSurface& moving, const MatchSurface& fixed, const Motion& motion) {
  double sum = 0;
  const auto side = [&](const MatchSurface& nodes, const MatchSurface& target, bool moves) {
    for (std::size_t i = 0; i < nodes.xy.size(); ++i) {
      const Point3 own{nodes.xy[i].x, nodes.xy[i].y, nodes.z[i]}, there = moves ? motion.apply(own) : motion.undo(own);
      const Point2 q{there.x, there.y};
      for (Index t = 0; t < target.t.real; ++t) {
        const auto& v = target.t.triangles[t].v;
        const Point2 &a = target.xy[v[0]], &b = target.xy[v[1]], &c = target.xy[v[2]];
        if (!target.footprint.keeps(t) || orientation(a, b, q) < 0 || orientation(b, c, q) < 0 ||
            orientation(c, a, q) < 0)
          continue;
        const double all = triangle_area(a, b, c), wb = triangle_area(a, q, c) / all, wc = triangle_area(a, b, q) / all;
        const double bubble = 4 * (wb * wc + (1 - wb - wc) * (wb + wc));
        const double z = target.facets[t].rise * bubble + target.z[v[0]] + wb * (target.z[v[1]] - target.z[v[0]]) +
                         wc * (target.z[v[2]] - target.z[v[0]]);
        const double n = (there.z - z) * target.cosine[t] * (moves ? 1 : motion.scale);
        sum += nodes.weight[i] * n * n / 2;
        break;
      }
    }
  };
  side(moving, fixed, true);
  side(fixed, moving, false);
  return sum;
}

constexpr Loss squares{Loss::Kind::huber, 1e9};

TEST(Residuals, SumOfSquaresIsThatOfEveryTriangleTried) {
  for (const auto& [p, q] :
       {std::pair{test::uniform(150, 1), test::uniform(200, 2)}, std::pair{test::grid(12, 12), test::uniform(150, 3)},
        std::pair{test::grid(10, 9), test::grid(10, 9)}}) {
    const MatchSurface moving = surface(p, 4), fixed = surface(q, 5);
    Residuals r(moving, fixed, {0.5, 0.5, 0}, 0.5);
    for (const double size : {0.0, 0.01, 0.1, 0.02}) {  // hints of one motion serve the next
      if (size == 0 && p == q) continue;                // every node on a node: any facet there will do
      const Motion motion = some_motion(size);
      const double expected = brute_force(moving, fixed, motion);
      EXPECT_NEAR(r.evaluate(motion, squares, {}).loss, expected, 1e-6 * expected);
    }
  }
}

// Weights that change without a motion: the same bits as by looking for every node again.
TEST(Residuals, NewWeightsAtTheSameMotion) {
  MatchSurface moving = surface(test::uniform(3000, 1), 4), fixed = surface(test::uniform(2500, 2), 5);
  test::Random random(6);
  Array<double> mu;
  for (std::size_t i = 0; i < fixed.xy.size(); ++i) mu.push_back(random.uniform());
  weigh(fixed, mu);
  for (const std::size_t stride : {1, 3}) {
    Residuals r(moving, fixed, {0.4, 0.6, 0.1}, 0.5);
    r.sample(stride);
    const Motion motion = some_motion(0.02);
    const ResidualSums before = r.evaluate(motion, squares, {});
    r.even_out();
    r.trust_share(0.7);
    const Loss loss{Loss::Kind::tukey, r.spread()};
    const ResidualSums again = r.reweighed(motion, loss, {}), anew = r.evaluate(motion, loss, {});
    EXPECT_LT(again.trusted, before.trusted);
    EXPECT_EQ(again.nodes, before.nodes);
    EXPECT_EQ(again.h.m, anew.h.m);
    EXPECT_EQ(again.b, anew.b);
    const ResidualSums without = r.evaluate(motion, loss, {}, false);
    EXPECT_EQ(without.h.m, Symmetric7{}.m);
    EXPECT_EQ(without.b, Vector7{});
    EXPECT_EQ(without.loss, anew.loss);
    for (const auto sum : {&ResidualSums::area, &ResidualSums::trusted, &ResidualSums::loss, &ResidualSums::fitted,
                           &ResidualSums::volume, &ResidualSums::within, &ResidualSums::squares,
                           &ResidualSums::curvature, &ResidualSums::bend})
      EXPECT_EQ(again.*sum, anew.*sum);
  }
}

// Along a step so small that no node changes its facet the loss is a smooth function.
TEST(Residuals, DerivativesAreThoseOfDifferences) {
  const MatchSurface moving = sharp(surface(test::uniform(150, 1), 4)),
                     fixed = sharp(surface(test::uniform(200, 2), 5));
  const Motion motion = some_motion(0.02);
  for (const Loss& loss : {squares, Loss{Loss::Kind::huber, 0.02}, Loss{Loss::Kind::tukey, 0.03}}) {
    Residuals r(moving, fixed, {0.4, 0.6, 0.1}, 0.5);
    const ResidualSums at = r.evaluate(motion, loss, {});
    for (std::size_t k = 0; k < parameters; ++k) {
      constexpr double h = 1e-7;
      Vector7 step{};
      step[k] = h;
      const double plus = r.evaluate(moved(motion, r.twist(step), r.centre()), loss, {}).loss;
      step[k] = -h;
      const double minus = r.evaluate(moved(motion, r.twist(step), r.centre()), loss, {}).loss;
      // b holds the slope of the facets at the residual; where the facet itself turns with the motion (tilts, scale) n
      // changes by second order in n alone.
      EXPECT_NEAR((plus - minus) / (2 * h), -at.b[k], 0.02 * std::fabs(at.b[k]) + 1e-6) << k;
    }
  }
}

// The mean slope around corners: that of a plane exactly, and less noise than any facet has.
TEST(Residuals, SmoothedSlopesLoseTheNoiseAlone) {
  MatchSurface s = surface(test::uniform(3000, 1), 4);
  test::Random random(7);
  const auto slopes_of = [&](double noise) {
    for (std::size_t i = 0; i < s.z.size(); ++i)
      s.z[i] = 0.3 * s.xy[i].x - 0.2 * s.xy[i].y + noise * random.uniform(-1, 1);
    s = make_surface(s.xy, s.z, s.t, {});
    double facets = 0, smoothed = 0;
    for (std::size_t i = 0; i < s.facets.size(); ++i) {
      const Facet& f = s.facets[i];
      if (!f.exists()) continue;
      facets += std::pow(f.gx - 0.3, 2) + std::pow(f.gy + 0.2, 2);
      smoothed += std::pow(f.smooth_gx - 0.3, 2) + std::pow(f.smooth_gy + 0.2, 2);
      EXPECT_NEAR(s.cosine[i], 1 / std::sqrt(1 + std::pow(f.smooth_gx, 2) + std::pow(f.smooth_gy, 2)), 1e-6);
    }
    return std::pair{facets, smoothed};
  };
  EXPECT_LT(slopes_of(0).second, 1e-8);
  const auto [facets, smoothed] = slopes_of(1e-3);
  EXPECT_LT(smoothed, 0.2 * facets);
}

// Slopes from 0 to 4, heights with normal noise.
MatchSurface bent(std::size_t n, std::uint64_t seed) {
  MatchSurface s = surface(test::uniform(n, seed), seed);
  const RandomStream random(seed, 5);
  for (std::size_t i = 0; i < s.z.size(); ++i)
    s.z[i] = 2 * s.xy[i].x * s.xy[i].x + 1e-4 * random.normal(static_cast<std::uint64_t>(i));
  Array<unsigned char> kept(s.t.real);  // no long triangles along the hull: the surface is curved
  for (Index i = 0; i < s.t.real; ++i) kept[i] = s.footprint.keeps(i) ? 1 : 0;
  return make_surface(s.xy, s.z, s.t, kept);
}

TEST(Residuals, NoiseOfHeightsIsEvenedOutOverSlopes) {
  const MatchSurface moving = bent(20000, 1), fixed = bent(20000, 2);
  Residuals r(moving, fixed, {0.5, 0.5, 0}, 0.5);
  // The mean square over that of the median: 1 if all residuals are of one normal distribution.
  const auto mixture = [&] {
    const ResidualSums sums = r.evaluate(Motion{}, squares, {});
    return 2 * sums.loss / sums.area / (r.spread() * r.spread());
  };
  EXPECT_GT(mixture(), 1.15);
  r.even_out();
  EXPECT_NEAR(mixture(), 1, 0.1);
}

TEST(Residuals, ASampleIsEveryEighthPatch) {
  const MatchSurface moving = bent(20000, 1), fixed = bent(20000, 2);
  Residuals all(moving, fixed, {0.5, 0.5, 0}, 0.5), some(moving, fixed, {0.5, 0.5, 0}, 0.5);
  const Motion motion = some_motion(1e-4);
  (void)all.evaluate(motion, squares, {});
  some.sample(8);
  const ResidualSums sums = some.evaluate(motion, squares, {});
  double area = 0;
  for (std::size_t i = 0; i < moving.xy.size(); ++i) {
    const bool sampled = i / Residuals::largest_patch % 8 == 0;
    EXPECT_EQ(some.fitted(i, squares), sampled && all.fitted(i, squares)) << i;
    area += moving.weight[i];
  }
  EXPECT_NEAR(sums.area, 2 * area / 8, 0.05 * area);
  some.sample(1);
  EXPECT_NEAR(some.evaluate(motion, squares, {}).loss, all.evaluate(motion, squares, {}).loss, 1e-18);
}

// Along z of a flat pair the equations' right side falls by the second derivative of the loss.
TEST(Residuals, CurvatureIsThatOfDifferences) {
  const auto flat = [](std::uint64_t seed) {
    MatchSurface s = surface(test::uniform(400, seed), seed);
    test::Random random(seed);
    for (double& z : s.z) z = 1e-4 * random.uniform(-1, 1);
    return make_surface(s.xy, s.z, s.t, {});
  };
  const MatchSurface moving = flat(1), fixed = flat(2);
  for (const Loss& loss : {squares, Loss{Loss::Kind::huber, 5e-5}, Loss{Loss::Kind::tukey, 4e-5}}) {
    Residuals r(moving, fixed, {0.5, 0.5, 0}, 0.5);
    constexpr double h = 1e-9;
    Motion up, down;
    up.shift.z = h, down.shift.z = -h;
    const double fall = (r.evaluate(down, loss, {}).b[5] - r.evaluate(up, loss, {}).b[5]) / (2 * h);
    const ResidualSums at = r.evaluate(Motion{}, loss, {});
    EXPECT_NEAR(at.curvature, fall, 0.02 * at.fitted);
    EXPECT_LE(at.curvature, at.fitted * (1 + 1e-12));
  }
}

TEST(Residuals, TrustSeesWhatNoNodeShows) {
  // A fifth of the surface is lifted by half the noise.
  const test::Points p = test::uniform(20000, 1), q = test::uniform(20000, 2);
  const auto rough = [](const test::Points& points, std::uint64_t seed, double lift) {
    MatchSurface s = surface(points, seed);
    test::Random random(seed);
    for (std::size_t i = 0; i < s.z.size(); ++i) s.z[i] = 1e-3 * (random.uniform(-1, 1) + (s.xy[i].x < 0.2 ? lift : 0));
    return make_surface(s.xy, s.z, s.t, {});
  };
  const MatchSurface moving = rough(p, 3, 0.6), fixed = rough(q, 4, 0);
  Residuals r(moving, fixed, {0.5, 0.5, 0}, 0.5);
  const double all = r.evaluate(Motion{}, squares, {}).trusted;
  EXPECT_NEAR(r.spread(), 0.7e-3, 0.2e-3);
  r.trust_by_mean();
  const double some = r.evaluate(Motion{}, squares, {}).trusted;
  EXPECT_LT(some, 0.9 * all);
  EXPECT_GT(some, 0.6 * all);
  r.trust_share(0.5);
  EXPECT_NEAR(r.evaluate(Motion{}, squares, {}).trusted, 0.5 * all, 0.01 * all);
  r.trust_all();
  EXPECT_EQ(r.evaluate(Motion{}, squares, {}).trusted, all);
}

TEST(Motion, MovesAndUndoes) {
  const Motion motion = moved(some_motion(0.3), {0.1, 0.2, -0.3, 1, 2, 3, 0.1}, {3, 4, 5});
  const Point3 p{0.3, -0.7, 2}, back = motion.undo(motion.apply(p));
  EXPECT_NEAR(back.x, p.x, 1e-14);
  EXPECT_NEAR(back.y, p.y, 1e-14);
  EXPECT_NEAR(back.z, p.z, 1e-14);
  const Point3 centre = moved(Motion{}, {0.1, 0.2, 0.3, 0, 0, 0, 0.5}, {3, 4, 5}).apply({3, 4, 5});
  EXPECT_NEAR(std::hypot(centre.x - 3, centre.y - 4, centre.z - 5), 0, 1e-14);
}

TEST(Motion, PoseIsTheMotionInInputCoordinates) {
  Frame frame;
  frame.origin = {4194304, 5242880, 0};
  frame.rotation = {0, 1, 0, 0, 0, 1, 1, 0, 0};
  const Motion motion = some_motion(0.1);
  const Pose start = test::turn_and_shift({1, 2, 3}, 30, {4e6, 5e6, 100}, {1, 2, 3}),
             pose = pose_of(motion, frame, start);
  for (const Point3& p : {Point3{4194404, 5242980, 120}, Point3{4194004.5, 5242080, -20}}) {
    const Point3 want = frame.to_input(motion.apply(frame.to_field(start.apply(p)))), got = pose.apply(p);
    EXPECT_NEAR(got.x, want.x, 5e-9);
    EXPECT_NEAR(got.y, want.y, 5e-9);
    EXPECT_NEAR(got.z, want.z, 5e-9);
  }
}

}  // namespace
}  // namespace isopach
