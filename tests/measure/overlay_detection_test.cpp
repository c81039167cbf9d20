// A level of detection that varies over the exact overlay: against clipping all pairs of triangles, dense sampling, and
// both scans' deviations at every vertex.
#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/uncertainty/detection.hpp"
#include "isopach/measure/volume/budget.hpp"
#include "isopach/measure/volume/detail.hpp"
#include "isopach/measure/volume/distribution.hpp"
#include "isopach/measure/volume/weight.hpp"
#include "tests/overlay/couple.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/polygons.hpp"

namespace isopach::test {
namespace {

/// The couple and the same meshes with deviations for heights.
struct Levelled {
  Couple d, sigma;

  Levelled(const Points& a, const Points& b, std::uint64_t seed, double most_1, double most_2)
      : d(rough(a, seed), rough(b, seed + 1)),
        sigma(deviations(a, seed + 2, most_1), deviations(b, seed + 3, most_2)) {}

  [[nodiscard]] Detected detected(double rest, double k) const {
    const std::vector<Overlay> of{sigma.overlay()};
    return detect(d.overlay(), OverlayLevel{of, rest, k}, {});
  }

 private:
  static Surface deviations(const Points& xy, std::uint64_t seed, double most) {
    Random random(seed);
    return surface(xy, [&](const Point2&) { return random.uniform(0, most); });
  }
};

struct Corner {
  long double x, y, d, level;
};
using Polygon = std::vector<Corner>;

template <class F>
Polygon keep(const Polygon& p, F&& inside) {
  Polygon kept;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Corner &u = p[i], &v = p[(i + 1) % p.size()];
    const long double s = inside(u), t = inside(v);
    if (s >= 0) kept.push_back(u);
    if ((s >= 0) == (t >= 0)) continue;
    const long double w = s / (s - t);
    kept.push_back(
        {u.x + w * (v.x - u.x), u.y + w * (v.y - u.y), u.d + w * (v.d - u.d), u.level + w * (v.level - u.level)});
  }
  return kept;
}

std::pair<long double, long double> area_and_integral_of_d(const Polygon& p) {
  long double area = 0, integral = 0;
  for (std::size_t i = 2; i < p.size(); ++i) {
    const long double a = ((p[i - 1].x - p[0].x) * (p[i].y - p[0].y) - (p[i - 1].y - p[0].y) * (p[i].x - p[0].x)) / 2;
    area += a, integral += a * (p[0].d + p[i - 1].d + p[i].d) / 3;
  }
  return {area, integral};
}

/// Of all pairs of triangles; level: deviation of the second surface alone, so that it is linear on a cell.
Detected by_clipping(const Levelled& l) {
  using Three = std::array<Point2, 3>;
  const auto corners = [](const Surface& s, Index t, std::size_t k) {
    return s.mesh.xy[s.mesh.triangulation.triangles[t].v[k]];
  };
  const auto linear = [](const Three& p, const Surface& s, Index t, const Corner& c) {
    const auto& v = s.mesh.triangulation.triangles[t].v;
    const auto area = [](long double ax, long double ay, long double bx, long double by) { return ax * by - ay * bx; };
    std::array<long double, 3> w{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Point2 &q = p[(k + 1) % 3], &r = p[(k + 2) % 3];
      w[k] = area(q.x - c.x, q.y - c.y, r.x - c.x, r.y - c.y);
    }
    return (w[0] * s.z[v[0]] + w[1] * s.z[v[1]] + w[2] * s.z[v[2]]) / (w[0] + w[1] + w[2]);
  };
  long double above = 0, below = 0, area = 0;
  for (Index t = 0; t < l.d.a.mesh.triangulation.real; ++t)
    for (Index u = 0; u < l.d.b.mesh.triangulation.real; ++u) {
      Three p{}, q{};
      for (std::size_t k = 0; k < 3; ++k) p[k] = corners(l.d.a, t, k), q[k] = corners(l.d.b, u, k);
      Polygon part;
      for (const Point2& c : p) part.push_back({c.x, c.y, 0, 0});
      for (std::size_t k = 0; k < 3 && part.size() > 2; ++k) {
        const Point2 &from = q[k], &to = q[(k + 1) % 3];
        part = keep(
            part, [&](const Corner& c) { return (to.x - from.x) * (c.y - from.y) - (to.y - from.y) * (c.x - from.x); });
      }
      if (part.size() < 3) continue;
      for (Corner& c : part) {
        c.d = linear(q, l.d.b, u, c) - linear(p, l.d.a, t, c);
        c.level = linear(q, l.sigma.b, u, c);
      }
      const auto [up, gained] = area_and_integral_of_d(keep(part, [](const Corner& c) { return c.d - c.level; }));
      const auto [down, lost] = area_and_integral_of_d(keep(part, [](const Corner& c) { return -c.d - c.level; }));
      area += up + down, above += gained, below -= lost;
    }
  return {static_cast<double>(above), static_cast<double>(below), static_cast<double>(area)};
}

TEST(DetectOverOverlay, EqualsClippingAllPairs) {
  std::vector<std::pair<Points, Points>> pairs;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    pairs.emplace_back(uniform(20 + 6 * seed, 10 * seed), uniform(150 - 5 * seed, 10 * seed + 1));
  const Points shared = uniform(80, 7);
  Points some(shared.begin(), shared.begin() + 50);
  for (const Point2& p : uniform(30, 8)) some.push_back(p);
  pairs.emplace_back(shared, some);
  pairs.emplace_back(grid(64, 1), grid(36, 2));
  std::uint64_t seed = 100;
  for (const auto& [a, b] : pairs) {
    const Levelled l(a, b, seed += 10, 0, 0.8);
    const Detected found = l.detected(0, 1), expected = by_clipping(l);
    const double volume = expected.above + expected.below;
    ASSERT_GT(volume, 0);
    EXPECT_NEAR(found.above, expected.above, 1e-9 * volume);
    EXPECT_NEAR(found.below, expected.below, 1e-9 * volume);
    EXPECT_NEAR(found.area, expected.area, 1e-9 * expected.area);
  }
}

/// As in source_test.cpp.
Region region_of(const Rings& rings) {
  auto parts = trapezoids(edges_of(rings));
  EXPECT_TRUE(parts);
  return {edges_of(rings), parts ? *parts : std::vector<Trapezoid>{}};
}

TEST(DetectOverOverlay, OfARegionAndOfTheRestAddUp) {
  const Levelled l(uniform(120, 61), uniform(90, 62), 63, 0, 0.8);
  const Rings region{{{0.21, 0.13}, {0.83, 0.31}, {0.57, 0.88}, {0.4, 0.45}}};
  Domain in, out;
  in.keep(Regions({region_of(region)}, 200));
  out.take_away(Regions({region_of(region)}, 200));
  const std::vector<Overlay> of{l.sigma.overlay()};
  const Overlay cells = l.d.overlay();
  const auto detected = [&](const Domain& domain) { return detect({cells, domain}, OverlayLevel{of, 0, 1}, {}); };
  const Detected whole = detected(Domain::everything()), inside = detected(in), outside = detected(out);
  EXPECT_GT(inside.area, 0.05);
  EXPECT_GT(outside.area, 0.05);
  EXPECT_NEAR(inside.area + outside.area, whole.area, 1e-12);
  EXPECT_NEAR(inside.above + outside.above, whole.above, 1e-12);
  EXPECT_NEAR(inside.below + outside.below, whole.below, 1e-12);
}

TEST(DetectOverOverlay, IsThatOfDenseSampling) {
  const Points a = framed_square(60, 21), b = framed_square(90, 22);
  const Levelled l(a, b, 23, 0.3, 0.4);
  const double rest = 0.1, k = 1.7;
  const int n = 500;
  Points samples;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) samples.push_back({(i % 2 == 0 ? j : n - 1 - j) + 0.5, i + 0.5});
  for (Point2& p : samples) p = {p.x / n, p.y / n};
  const auto values = [&](const Surface& s) {
    const Locations where = localise_in_order(samples, s.mesh.triangulation, s.mesh.xy, {});
    return interpolate(where, samples, s.mesh.triangulation, s.mesh.xy, s.z, {});
  };
  const Array<double> z1 = values(l.d.a), z2 = values(l.d.b), s1 = values(l.sigma.a), s2 = values(l.sigma.b);
  Detected expected;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double d = z2[i] - z1[i];
    if (std::fabs(d) <= k * std::hypot(rest, s1[i], s2[i])) continue;
    expected.area += 1. / (n * n);
    (d > 0 ? expected.above : expected.below) += std::fabs(d) / (n * n);
  }
  const Detected found = l.detected(rest, k);
  // Between its corners a cell's level is a little too high, for a root of squares bends downwards: at worst by this,
  // where deviations vary from nothing to all from node to node.
  EXPECT_NEAR(found.area, 0.99 * expected.area, 0.01 * expected.area);
  EXPECT_NEAR(found.above, 0.99 * expected.above, 0.01 * expected.above);
  EXPECT_NEAR(found.below, 0.99 * expected.below, 0.01 * expected.below);
}

Cloud noisy_cloud(const Points& xy, std::uint64_t seed) {
  Cloud cloud = rough_cloud(xy, seed);
  Random random(seed + 1);
  cloud.attributes.push_back({"noise", Array<double>(cloud.points.size())});
  for (double& s : cloud.attributes[0].values) s = random.uniform(0.05, 0.3);
  return cloud;
}

// Through a comparison, with a shift and with a covariance of the pose: at nodes the level of the points, at crossings
// that of both scans' triangles.
TEST(DetectOverOverlay, HasTheLevelOfBothScansAtEveryVertex) {
  const Cloud a = noisy_cloud(framed_square(40, 31), 32), b = noisy_cloud(framed_square(55, 34), 35);
  const auto noise_of = [](const Cloud& c) {
    Points xy;
    for (const Point3& p : c.points) xy.push_back({p.x, p.y});
    return brute_surface(xy, {c.attributes[0].values.begin(), c.attributes[0].values.end()});
  };
  const BruteSurface s1 = noise_of(a), s2 = noise_of(b);
  for (const isopach::Surface surface : {isopach::Surface::overlay, isopach::Surface::both}) {
    CompareOptions o;
    o.check_layers = false;
    o.border = BorderRule::hull;
    o.surface = surface;
    o.keep_overlay = true;
    UncertaintyOptions& u = o.uncertainty;
    u.sigma1 = u.sigma2 = {SigmaSource::Kind::attribute, 0, "noise"};
    u.model = UncertaintyModel::registration;
    u.registration_error = 0.1;
    const Comparison c = compare(a, b, o, {});
    ASSERT_EQ(c.overlay_lod.size(), c.overlay_surface.xy.size());
    for (std::size_t i = 0; i < c.overlay_lod.size(); i += 11) {  // nodes of both and crossings, mixed
      const Point3 p = c.frame.to_input({c.overlay_surface.xy[i].x, c.overlay_surface.xy[i].y, 0});
      const Point2 q{p.x, p.y};
      const double expected = 1.959963984540054 * std::hypot(static_cast<double>(s1.clamped_at(q)),
                                                             static_cast<double>(s2.clamped_at(q)), 0.1);
      EXPECT_NEAR(c.overlay_lod[i], expected, 1e-9);
    }
    u.registration_error = 0;
    PoseCovariance pose;
    pose.matrix[14] = pose.matrix[21] = 0;
    pose.matrix[35] = 0.01;  // a shift in z of 0.1, known by a covariance
    u.registration_covariance = pose;
    const Comparison same = compare(a, b, o, {});
    for (std::size_t i = 0; i < c.overlay_lod.size(); ++i) EXPECT_NEAR(same.overlay_lod[i], c.overlay_lod[i], 1e-9);
    if (surface == isopach::Surface::both) continue;
    EXPECT_NEAR(same.uncertainty.detected->area, c.uncertainty.detected->area, 1e-9);
    EXPECT_LT(c.uncertainty.detected->above, c.measures.volume.above);
    CompareOptions common = o;
    common.surface = isopach::Surface::common;
    common.keep_overlay = false;
    EXPECT_NE(compare(a, b, common, {}).uncertainty.detected->above, c.uncertainty.detected->above);
  }
}

// Inside and outside of the same polygon are the whole; every vertex of the pieces has a level.
TEST(DetectOverOverlay, IsClippedWithTheDomain) {
  const Cloud a = noisy_cloud(framed_square(200, 51), 52), b = noisy_cloud(framed_square(170, 54), 55);
  PolygonSet triangle;
  triangle.polygons = {{"triangle", {{{0.21, 0.2}, {0.83, 0.3}, {0.6, 0.77}}}}};
  CompareOptions o;
  o.check_layers = false;
  o.surface = isopach::Surface::overlay;
  o.keep_overlay = true;
  o.uncertainty.sigma1 = o.uncertainty.sigma2 = {SigmaSource::Kind::attribute, 0, "noise"};
  const Comparison whole = compare(a, b, o, {});
  CompareOptions inner = o, outer = o;
  inner.area.include = {triangle};
  outer.area.exclude = {triangle};
  const Comparison in = compare(a, b, inner, {}), out = compare(a, b, outer, {});
  ASSERT_EQ(in.overlay_lod.size(), in.overlay_surface.xy.size());
  for (const double lod : in.overlay_lod) EXPECT_GT(lod, 0);
  const Detected &w = *whole.uncertainty.detected, &i = *in.uncertainty.detected, &e = *out.uncertainty.detected;
  ASSERT_GT(i.area, 0);
  EXPECT_LE(i.area, in.domain_area);
  // A cell that is cut has its level at more corners, and is then a little less too high in between.
  EXPECT_NEAR(i.area + e.area, w.area, 2e-3 * w.area);
  EXPECT_NEAR(i.above + e.above, w.above, 2e-3 * w.above);
  EXPECT_NEAR(i.below + e.below, w.below, 2e-3 * w.below);
}

TEST(DetectOverOverlay, IsThatOfOneLevelWhereTheSigmasAreTheSame) {
  Cloud a = noisy_cloud(framed_square(300, 41), 42), b = noisy_cloud(framed_square(250, 44), 45);
  CompareOptions o;
  o.check_layers = false;
  o.surface = isopach::Surface::overlay;
  o.keep_overlay = true;
  o.uncertainty.sigma1 = {SigmaSource::Kind::constant, 0.1, ""};
  o.uncertainty.sigma2 = {SigmaSource::Kind::constant, 0.2, ""};
  const Comparison one = compare(a, b, o, {});
  ASSERT_EQ(one.overlay_lod.size(), one.overlay_surface.xy.size());
  for (const double lod : one.overlay_lod) EXPECT_EQ(lod, *one.uncertainty.lod);
  for (double& s : b.attributes[0].values) s = 0.2;
  b.attributes[0].values[7] = 0.2 + 1e-12;  // no longer one level
  o.uncertainty.sigma2 = {SigmaSource::Kind::attribute, 0, "noise"};
  const Detected found = *compare(a, b, o, {}).uncertainty.detected;
  EXPECT_NEAR(found.area, one.uncertainty.detected->area, 1e-9);
  EXPECT_NEAR(found.above, one.uncertainty.detected->above, 1e-9);
  EXPECT_NEAR(found.below, one.uncertainty.detected->below, 1e-9);
  // Exchanged scans mirror, whatever the number of threads.
  std::swap(o.uncertainty.sigma1, o.uncertainty.sigma2);
  Context seven;
  seven.threads = 7;
  const Detected back = *compare(b, a, o, seven).uncertainty.detected;
  EXPECT_NEAR(back.above, found.below, 1e-12);
  EXPECT_NEAR(back.below, found.above, 1e-12);
}

}  // namespace
}  // namespace isopach::test
