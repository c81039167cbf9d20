// The fold rule against its definition; folds, cliffs, ridges and noise whose answer is known.
#include "isopach/overlay/folds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/geom/predicates.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {
namespace {

using Height = std::function<double(const Point2&, Random&)>;

struct Scan {
  SortedTriangulation s;
  Array<double> z;
  Footprint kept;

  [[nodiscard]] Folds folds() const { return find_folds(s.triangulation, s.xy, z, {}, kept, {}); }
  [[nodiscard]] double share() const { return folds().area / kept.area; }
};

Scan scan_of(const Points& points, const Array<double>& height, bool trim = true) {
  Scan scan;
  scan.s = triangulate_unsorted(points, {});
  scan.kept = footprint(scan.s.triangulation, scan.s.xy, trim, {}, {});
  const auto less = [](const Point2& p, const Point2& q) { return p.x != q.x ? p.x < q.x : p.y < q.y; };
  std::vector<std::pair<Point2, double>> all;
  for (std::size_t i = 0; i < points.size(); ++i) all.emplace_back(points[i], height[i]);
  std::sort(all.begin(), all.end(), [&](const auto& p, const auto& q) { return less(p.first, q.first); });
  for (const Point2& p : scan.s.xy)
    scan.z.push_back(std::lower_bound(all.begin(), all.end(), p, [&](const auto& e, const Point2& q) {
                       return less(e.first, q);
                     })->second);
  return scan;
}

Scan scan_of(const Points& points, const Height& height, std::uint64_t seed = 1, bool trim = true) {
  Random random(seed);
  Array<double> z;
  for (const Point2& p : points) z.push_back(height(p, random));
  return scan_of(points, z, trim);
}

/// The definition at the head of folds.hpp, node by node, from the list of triangles alone.
class Twin {
 public:
  explicit Twin(const Scan& scan) : scan_(scan), neighbours_(scan.s.xy.size()) {
    const Triangulation& t = scan.s.triangulation;
    for (Index i = 0; i < t.real; ++i)
      if (scan.kept.keeps(i))
        for (const Index v : t.triangles[i].v)
          for (const Index w : t.triangles[i].v)
            if (v != w) neighbours_[v].insert(w);
  }

  [[nodiscard]] std::vector<unsigned char> triangles() const {
    const std::size_t n = neighbours_.size();
    std::vector<bool> weak(n), sure(n), folded(n);
    for (Index i = 0; i < n; ++i)
      weak[i] = covered(i, torn_steps, false), sure[i] = covered(i, surely_torn_steps, true);
    std::vector<Index> group(n);
    for (Index i = 0; i < n; ++i) group[i] = i;
    for (bool changed = true; changed;) {  // the least index of those that belong together
      changed = false;
      for (Index i = 0; i < n; ++i)
        for (const Index v : near(i))
          if (weak[i] && weak[v] && group[v] < group[i]) group[i] = group[v], changed = true;
    }
    for (Index i = 0; i < n; ++i) {
      std::size_t in_group = 0;
      for (Index v = 0; v < n; ++v) in_group += sure[v] && group[v] == group[i];
      if (!weak[i] || in_group < 2) continue;
      folded[i] = true;
      for (const Index v : neighbours_[i]) folded[v] = true;
    }
    std::vector<unsigned char> flags;
    for (Index i = 0; i < scan_.s.triangulation.real; ++i) {
      const auto& v = scan_.s.triangulation.triangles[i].v;
      flags.push_back(scan_.kept.keeps(i) && (folded[v[0]] || folded[v[1]] || folded[v[2]]) ? 1 : 0);
    }
    return flags;
  }

 private:
  [[nodiscard]] double step(Index i, Index v) const { return scan_.z[v] - scan_.z[i]; }
  [[nodiscard]] static double ranked(std::vector<double> values, std::size_t rank) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    return values[std::min(rank, values.size()) - 1];
  }
  [[nodiscard]] double spacing(Index i) const {
    std::vector<double> lengths;
    for (const Index v : neighbours_[i]) {
      const double dx = scan_.s.xy[v].x - scan_.s.xy[i].x, dy = scan_.s.xy[v].y - scan_.s.xy[i].y;
      lengths.push_back(dx * dx + dy * dy);
    }
    return std::sqrt(ranked(lengths, 3));
  }
  [[nodiscard]] double own_step(Index i) const {
    std::vector<double> steps;
    for (const Index v : neighbours_[i]) steps.push_back(std::fabs(step(i, v)));
    return ranked(steps, 2);
  }
  [[nodiscard]] std::set<Index> near(Index i) const {
    std::set<Index> all = neighbours_[i];
    for (const Index v : neighbours_[i]) all.insert(neighbours_[v].begin(), neighbours_[v].end());
    return all;
  }
  [[nodiscard]] double limit(Index i, double factor) const {
    std::vector<double> steps{own_step(i)};
    for (const Index v : neighbours_[i]) steps.push_back(own_step(v));
    std::sort(steps.begin(), steps.end());
    return std::max(torn_spacings * spacing(i), factor * steps[steps.size() / 2]);
  }
  [[nodiscard]] bool covered(Index i, double factor, bool among) const {
    for (const double sign : {1.0, -1.0}) {
      std::vector<Index> others;
      for (const Index v : neighbours_[i])
        if (sign * step(i, v) > limit(i, factor) && sign * step(i, v) > limit(v, factor)) others.push_back(v);
      // In no closed half-plane: the line through any of them has others strictly on either side.
      const auto strictly = [&](Index v, int side) {
        return std::any_of(others.begin(), others.end(),
                           [&](Index w) { return orientation(scan_.s.xy[i], scan_.s.xy[v], scan_.s.xy[w]) == side; });
      };
      if (!others.empty() &&
          std::all_of(others.begin(), others.end(), [&](Index v) { return strictly(v, 1) && strictly(v, -1); }) &&
          (!among || others.size() == neighbours_[i].size() || runs(i, others) >= 2))
        return true;
    }
    return false;
  }
  /// How often, round the node, one of `others` follows one that is not.
  [[nodiscard]] std::size_t runs(Index i, const std::vector<Index>& others) const {
    std::vector<Index> ring(neighbours_[i].begin(), neighbours_[i].end());
    const Point2& o = scan_.s.xy[i];
    const auto half = [&](const Point2& p) { return p.y > o.y || (p.y == o.y && p.x > o.x) ? 0 : 1; };
    std::sort(ring.begin(), ring.end(), [&](Index v, Index w) {
      const Point2 &p = scan_.s.xy[v], &q = scan_.s.xy[w];
      return half(p) != half(q) ? half(p) < half(q) : orientation(o, p, q) > 0;
    });
    const auto is = [&](std::size_t k) { return std::find(others.begin(), others.end(), ring[k]) != others.end(); };
    std::size_t count = 0;
    for (std::size_t k = 0; k < ring.size(); ++k) count += is(k) && !is((k + ring.size() - 1) % ring.size());
    return count;
  }

  const Scan& scan_;
  std::vector<std::set<Index>> neighbours_;
};

void expect_twin(const Scan& scan, const std::string& name) {
  const Folds found = scan.folds();
  const std::vector<unsigned char> twin = Twin(scan).triangles();
  const bool any = std::any_of(twin.begin(), twin.end(), [](unsigned char f) { return f != 0; });
  ASSERT_EQ(found.any(), any) << name;
  if (any) {
    EXPECT_TRUE(std::equal(twin.begin(), twin.end(), found.folded.begin(), found.folded.end())) << name;
  }
}

TEST(Folds, EqualTheDefinition) {
  for (const Family& family : families())
    for (const std::uint64_t seed : {1u, 2u}) {
      const Points points = distinct(family.make(300, seed));
      Box2 box;
      for (const Point2& p : points) box.add(p);
      const double side = std::max(box.max.x - box.min.x, box.max.y - box.min.y);
      for (const double share : {0.5, 0.1}) {
        const Scan layers = scan_of(points, [&](const Point2&, Random& r) {
          return side * ((r.uniform() < share ? 0.3 : 0) + 0.001 * r.bell());
        });
        expect_twin(layers, family.name);
        const Scan untrimmed = scan_of(
            points, [&](const Point2&, Random& r) { return side * std::floor(3 * r.uniform()) / 3; }, seed, false);
        expect_twin(untrimmed, family.name + ", three levels");
      }
      expect_twin(scan_of(points, [&](const Point2&, Random& r) { return side * r.bell(); }), family.name + ", noise");
    }
}

// Nodes with hundreds of neighbours, whose spacing and steps are kept instead of being asked again by each of them.
TEST(Folds, EqualTheDefinitionRoundHubs) {
  for (const std::size_t spokes : {70u, 250u}) {
    Points points{{0, 0}};
    for (std::size_t k = 0; k < spokes; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(spokes);
      points.push_back({std::cos(angle), std::sin(angle)});
    }
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const auto layers = [](const Point2&, Random& r) { return r.uniform() < 0.5 ? 1.0 : 0.0; };
      expect_twin(scan_of(points, layers, seed, false), "two layers");
      expect_twin(scan_of(
                      points, [](const Point2&, Random& r) { return r.bell(); }, seed, false),
                  "noise");
      points[0] = {0.1 * static_cast<double>(seed), 0.05};
    }
  }
}

Points in_square(std::size_t n, std::uint64_t seed) { return uniform(n, seed); }

// Of a node with two kept edges these are its spacing, however long the others are: they must not hide it.
TEST(Folds, AreFoundAtNodesOfOneKeptTriangle) {
  Points points{{0, 0}, {1, 0}, {0.5, 0.9}};
  for (int k = 0; k < 6; ++k) points.push_back({100 * std::cos(k + 0.1), 100 * std::sin(k + 0.1)});
  Scan scan = scan_of(points, [](const Point2&, Random&) { return 0.0; });
  const auto is_near = [&](Index node) { return std::hypot(scan.s.xy[node].x, scan.s.xy[node].y) < 2; };
  scan.kept.removed.clear();
  for (Index i = 0; i < scan.s.triangulation.real; ++i) {
    const auto& v = scan.s.triangulation.triangles[i].v;
    scan.kept.removed.push_back(is_near(v[0]) && is_near(v[1]) && is_near(v[2]) ? 0 : 1);
  }
  std::vector<double> spread(points.size(), 0);
  for (Index i = 0; i < spread.size(); ++i) spread[i] = is_near(i) ? 10 : 0;
  const Folds found = find_folds(scan.s.triangulation, scan.s.xy, scan.z, spread, scan.kept, {});
  ASSERT_TRUE(found.any());
  for (Index i = 0; i < scan.s.triangulation.real; ++i) EXPECT_EQ(found.holds(i), scan.kept.keeps(i));
}

// More triangles than one block of the pass that chooses the nodes to be looked at: nine patches of two layers.
TEST(Folds, EqualTheDefinitionAcrossBlocks) {
  for (const double rim : {0.0, 0.3})  // without and with a hole
    expect_twin(scan_of(
                    [&] {
                      Points points = in_square(rim > 0 ? 4000 : 3000, 8);
                      std::erase_if(points, [&](const Point2& p) { return std::hypot(p.x - 0.5, p.y - 0.5) < rim; });
                      return points;
                    }(),
                    [](const Point2& p, Random& r) {
                      const bool in_patch = std::hypot(std::fmod(3 * p.x, 1) - 0.5, std::fmod(3 * p.y, 1) - 0.5) < 0.2;
                      return p.x + (in_patch && r.uniform() < 0.5 ? 0.2 : 0) + 0.0005 * r.bell();
                    }),
                "patches");
}

TEST(Folds, TwoSheetsAreFoldedAllOver) {
  for (const double share : {0.5, 0.3})
    EXPECT_GT(scan_of(in_square(20000, 1),
                      [&](const Point2& p, Random& r) {
                        return 2 * p.x + (r.uniform() < share ? 0.2 : 0) + 0.0005 * r.bell();
                      })
                  .share(),
              0.95);
}

TEST(Folds, HalfTheAreaIsHalf) {
  EXPECT_NEAR(
      scan_of(in_square(20000, 2),
              [](const Point2& p, Random& r) { return (p.x < 0.5 && r.uniform() < 0.5 ? 0.2 : 0) + 0.0005 * r.bell(); })
          .share(),
      0.5, 0.03);
}

TEST(Folds, NoiseAndReliefAreNone) {
  for (const double noise : {0.0, 0.001, 0.01, 1.0, 100.0})
    EXPECT_LT(
        scan_of(in_square(20000, 3),
                [&](const Point2& p, Random& r) { return std::sin(9 * p.x) * std::cos(7 * p.y) + noise * r.bell(); })
            .share(),
        2e-4)
        << noise;
  EXPECT_EQ(scan_of(in_square(20000, 4), [](const Point2& p, Random&) { return 6 * p.x; }).share(), 0);
}

TEST(Folds, CliffsStepsAndBlocksAreNone) {
  const double high = 1;  // 140 spacings
  const std::vector<Height> cliffs{
      [&](const Point2& p, Random& r) { return (p.x + 0.3 * p.y > 0.6 ? high : 0) + 0.001 * r.bell(); },
      [&](const Point2& p, Random& r) { return (p.x + 0.02 * std::sin(80 * p.y) > 0.5 ? high : 0) + 0.001 * r.bell(); },
      [&](const Point2& p, Random&) { return 0.1 * std::floor(10 * p.x); },
      [&](const Point2& p, Random&) {  // blocks and shafts 5 spacings wide
        return std::hypot(std::fmod(16 * p.x, 1) - 0.5, std::fmod(16 * p.y, 1) - 0.5) < 0.3 ? high : 0;
      },
      [&](const Point2& p, Random& r) {  // a gorge 7 spacings wide
        return (std::fabs(p.x - 0.5) < 0.025 ? 0 : high) + 0.001 * r.bell();
      }};
  for (std::size_t k = 0; k < cliffs.size(); ++k) {
    EXPECT_LT(scan_of(in_square(20000, 5), cliffs[k]).share(), 2e-3) << k;
    Points on_grid;
    for (int i = 0; i < 140; ++i)
      for (int j = 0; j < 140; ++j) on_grid.push_back({i / 140.0, j / 140.0});
    EXPECT_EQ(scan_of(on_grid, cliffs[k]).share(), 0) << k;
  }
}

TEST(Folds, OneOutlierIsNone) {
  Points points = in_square(5000, 6);
  Array<double> z(points.size());
  std::fill(z.begin(), z.end(), 0.0);
  z[100] = 50, z[2000] = -50;
  EXPECT_FALSE(scan_of(points, z).folds().any());
}

/// A hemisphere with the ground under it: seen from above two layers inside the circle.
TEST(Folds, GroundUnderABallIsOneUpToItsRim) {
  Random random(7);
  Points points;
  Array<double> z;
  for (int i = 0; i < 20000; ++i) {
    points.push_back({random.uniform(), random.uniform()});
    z.push_back(0.0005 * random.bell());
    if (i % 3 != 0) continue;
    const double x = random.bell(), y = random.bell(), h = random.bell(), r = std::sqrt(x * x + y * y + h * h);
    points.push_back({0.5 + 0.25 * x / r, 0.5 + 0.25 * y / r});
    z.push_back(0.4 + 0.25 * h / r);
  }
  EXPECT_NEAR(scan_of(points, z).share(), 3.14159265 * 0.0625, 0.02);
}

TEST(Folds, MergedLayersAreSeenByTheirSpread) {
  Points points;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j) points.push_back({double(i), double(j)});
  const Scan scan = scan_of(points, [](const Point2&, Random&) { return 10.0; });
  Array<double> spread(points.size());
  std::fill(spread.begin(), spread.end(), 20.0);
  EXPECT_NEAR(find_folds(scan.s.triangulation, scan.s.xy, scan.z, spread, scan.kept, {}).area, scan.kept.area, 1e-9);
  std::fill(spread.begin(), spread.end(), 0.5);
  EXPECT_FALSE(find_folds(scan.s.triangulation, scan.s.xy, scan.z, spread, scan.kept, {}).any());
}

TEST(Folds, ThreadsUpsideDownUnitAndPlaceDoNotMatter) {
  const Points points = in_square(20000, 8);
  const Height height = [](const Point2& p, Random& r) {
    return (p.x < 0.3 && r.uniform() < 0.4 ? 0.2 : 0) + 0.0005 * r.bell();
  };
  const Scan scan = scan_of(points, height);
  const Folds folds = scan.folds();
  ASSERT_TRUE(folds.any());
  for (const int threads : {1, 2, 7})
    run_with_threads(threads, [&] {
      const Folds again = scan.folds();
      EXPECT_EQ(again.folded, folds.folded);
      EXPECT_EQ(again.area, folds.area);
    });
  Scan turned = scan;
  for (double& z : turned.z) z = -z;
  EXPECT_EQ(turned.folds().folded, folds.folded);
  Points moved = points;
  for (Point2& p : moved) p = {1024 * p.x + 1048576, 1024 * p.y + 4194304};
  const Scan far = scan_of(moved, [&](const Point2& p, Random& r) {
    return 1024 * height({(p.x - 1048576) / 1024, (p.y - 4194304) / 1024}, r);
  });
  EXPECT_NEAR(far.share(), scan.share(), 1e-3);
}

TEST(Folds, OfNothingAreNone) {
  for (const std::size_t n : {0u, 1u, 2u, 3u}) {
    Points points = distinct(uniform(n, 1));
    EXPECT_FALSE(scan_of(points, [](const Point2&, Random&) { return 1.0; }).folds().any());
  }
}

}  // namespace
}  // namespace isopach::test
