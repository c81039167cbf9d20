// The bound holds, is as narrow as asked for, and is where dense sampling and closed forms say.
#include "isopach/distance/hausdorff.hpp"

#include <gtest/gtest.h>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/distance/vectors.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

Mesh mesh_over(const test::Points& points, const test::Height& height) {
  Mesh mesh;
  const SortedTriangulation t = triangulate_unsorted(points, {});
  for (const Point2& p : t.xy) mesh.points.push_back({p.x, p.y, height(p)});
  for (Index i = 0; i < t.triangulation.real; ++i) mesh.faces.push_back(t.triangulation.triangles[i].v);
  return mesh;
}

test::Height rough(double size, std::uint64_t seed) {
  return [size, random = test::Random(seed)](const Point2&) mutable { return random.uniform(-size, size); };
}

HausdorffBound bound(const Mesh& a, const Mesh& b, double tolerance) {
  return directed_hausdorff(a, SurfaceTree(b), tolerance, {});
}

struct Sampled {
  double largest = 0;  ///< of the samples
  double gap = 0;      ///< no point of the surface is farther than this from a sample
};
Sampled sampled(const Mesh& a, const Mesh& b, int k) {
  const SurfaceTree tree(b);
  Sampled s;
  for (std::size_t f = 0; f < a.faces.size(); ++f) {
    const auto c = a.corners(f);
    for (int i = 0; i <= k; ++i)
      for (int j = 0; i + j <= k; ++j) {
        const Point3 p =
            c[0] + (static_cast<double>(i) / k) * (c[1] - c[0]) + (static_cast<double>(j) / k) * (c[2] - c[0]);
        s.largest = std::max(s.largest, std::sqrt(tree.closest(p).at.distance2));
      }
    for (int e = 0; e < 3; ++e) s.gap = std::max(s.gap, length(c[(e + 1) % 3] - c[e]) / k);
  }
  return s;
}

struct Pair {
  std::string name;
  Mesh a, b;
};

std::vector<Pair> pairs() {
  std::vector<Pair> all;
  const auto flat = [](const Point2&) { return 0.0; };
  const auto wave = [](const Point2& p) { return 0.2 * std::sin(7 * p.x) * std::cos(5 * p.y); };
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto n = static_cast<std::size_t>(30 * seed);
    all.push_back({"rough", mesh_over(test::uniform(n, seed), rough(0.3, seed)),
                   mesh_over(test::uniform(2 * n, seed + 50), rough(0.3, seed + 9))});
    all.push_back({"wave", mesh_over(test::uniform(n, seed), wave), mesh_over(test::uniform(3 * n, seed + 50), wave)});
  }
  all.push_back(
      {"same nodes", mesh_over(test::uniform(80, 1), rough(0.1, 1)), mesh_over(test::uniform(80, 1), rough(0.1, 2))});
  all.push_back({"grids", mesh_over(test::grid(64, 1), rough(1, 1)), mesh_over(test::grid(64, 1), rough(1, 2))});
  all.push_back({"beside", mesh_over(test::uniform(50, 1), flat), mesh_over(test::huge(20, 3), flat)});
  all.push_back({"clusters", mesh_over(test::clustered(60, 1), rough(0.1, 3)), mesh_over(test::uniform(60, 3), flat)});
  return all;
}

TEST(Hausdorff, BoundHoldsAndIsThatOfDenseSampling) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    Box3 box;
    for (const Point3& p : pair.a.points) box.add(p);
    for (const Point3& p : pair.b.points) box.add(p);
    const double size = length(box.max - box.min);
    for (const bool swap : {false, true}) {
      const Mesh &from = swap ? pair.b : pair.a, &to = swap ? pair.a : pair.b;
      const Sampled s = sampled(from, to, 24);
      for (const double tolerance : {1e-2 * size, 1e-5 * size, 1e-9 * size}) {
        const HausdorffBound h = bound(from, to, tolerance);
        EXPECT_LE(h.lower, h.upper);
        EXPECT_LE(h.upper - h.lower, tolerance);
        EXPECT_GE(h.upper, s.largest);          // no sample beats the bound
        EXPECT_LE(h.lower, s.largest + s.gap);  // and no point is farther than sampling allows
        EXPECT_NEAR(std::sqrt(SurfaceTree(to).closest(h.at).at.distance2), h.lower, 1e-11 * size);
      }
    }
  }
}

TEST(Hausdorff, EqualsSamplingRefinedToTheTolerance) {
  const double tolerance = 2e-3;
  const std::vector<Pair> all = pairs();
  for (const Pair& pair : {all[0], all[1]}) {
    const Sampled s = sampled(pair.a, pair.b, 200);
    const HausdorffBound h = bound(pair.a, pair.b, tolerance);
    EXPECT_NEAR(h.lower, s.largest, tolerance + s.gap);
    EXPECT_LE(s.largest, h.upper);
    EXPECT_GE(s.largest, bound(pair.a, pair.b, 1e-8).lower - s.gap);
  }
}

TEST(Hausdorff, MaximumInsideATriangleOnARidge) {
  // One triangle spanned over a valley of two planes: the farthest point lies between the corners, over the bottom.
  Mesh roof, valley;
  roof.points = {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
  roof.faces = {{0, 1, 2}, {0, 2, 3}};
  valley.points = {{-1, -3, 1}, {0, -3, 0}, {1, -3, 1}, {-1, 3, 1}, {0, 3, 0}, {1, 3, 1}};
  valley.faces = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  const HausdorffBound h = bound(roof, valley, 1e-9);
  EXPECT_NEAR(h.lower, std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(h.upper, std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(h.at.x, 0, 1e-6);
  EXPECT_NEAR(bound(valley, roof, 1e-9).upper, std::sqrt(1 + 4), 1e-9);  // its ends stick out by 2, a depth 1 lower
}

TEST(Hausdorff, OneSurfaceTriangulatedTwice) {
  // The distance is 0, or 0.25, everywhere: nothing but cutting along the other's edges ends this.
  const auto plane = [](double lift) { return [lift](const Point2& p) { return 0.3 * p.x - 0.2 * p.y + lift; }; };
  const test::Points p = test::framed_square(300, 1), q = test::framed_square(200, 5);
  for (const double lift : {0.0, 0.25}) {
    const HausdorffBound h = bound(mesh_over(p, plane(0)), mesh_over(q, plane(lift)), 1e-9);
    EXPECT_LE(h.upper - h.lower, 1e-9);
    EXPECT_LT(h.pieces, 200'000u);
    if (lift == 0) {
      EXPECT_LE(h.upper, 1e-9);
    }
  }
  const Mesh same = mesh_over(p, rough(0.5, 2));
  EXPECT_LE(bound(same, same, 1e-9).upper, 1e-12);
}

TEST(Hausdorff, ParallelPlates) {
  const test::Points p = test::framed_square(300, 1), q = test::framed_square(200, 5);
  const auto level = [](double z) { return [z](const Point2&) { return z; }; };
  for (const double height : {1e-3, 0.7}) {
    const HausdorffBound h = bound(mesh_over(p, level(0)), mesh_over(q, level(height)), 1e-10);
    EXPECT_NEAR(h.lower, height, 1e-10);
    EXPECT_NEAR(h.upper, height, 1e-10);
  }
}

TEST(Hausdorff, AMissingPieceIsSeenFromOneSide) {
  const auto level = [](const Point2&) { return 0.0; };
  Mesh whole = mesh_over(test::grid(100, 1), level), part = whole;
  part.faces.clear();
  for (std::size_t f = 0; f < whole.faces.size(); ++f) {
    const auto c = whole.corners(f);
    if (std::max({c[0].x, c[1].x, c[2].x}) <= 6) part.faces.push_back(whole.faces[f]);
  }
  EXPECT_NEAR(bound(whole, part, 1e-6).upper, 3, 1e-6);
  EXPECT_LE(bound(part, whole, 1e-6).upper, 1e-6);
}

TEST(Hausdorff, SameBitsForAnyThreads) {
  const Mesh a = mesh_over(test::uniform(3000, 1), rough(0.1, 2)), b = mesh_over(test::uniform(2000, 3), rough(0.1, 4));
  std::vector<HausdorffBound> all;
  for (const int threads : {1, 2, 5}) run_with_threads(threads, [&] { all.push_back(bound(a, b, 1e-8)); });
  for (const HausdorffBound& h : all) {
    EXPECT_EQ(h.lower, all[0].lower);
    EXPECT_EQ(h.upper, all[0].upper);
    EXPECT_EQ(h.at, all[0].at);
    EXPECT_EQ(h.pieces, all[0].pieces);
  }
}

TEST(Hausdorff, RefusesWhatRoundingForbidsAndSaysWhenItGivesUp) {
  const Mesh a = mesh_over(test::utm(50, 1), rough(1, 1)), b = mesh_over(test::utm(60, 2), rough(1, 2));
  try {
    static_cast<void>(bound(a, b, 1e-12));
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("@tolerance"), std::string::npos);
  }
  try {
    static_cast<void>(directed_hausdorff(a, SurfaceTree(b), 1e-4, {}, 100));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::not_converged);
    EXPECT_NE(std::string(error.what()).find("@tolerance"), std::string::npos);
  }
}

}  // namespace
}  // namespace isopach
