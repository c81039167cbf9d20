// Closest points and crossings against every triangle, one by one, in long double.
#include "isopach/distance/surface_tree.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "tests/support/points.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

using Real = long double;
struct Vec {
  Real x, y, z;
};
Vec vec(const Point3& p) { return {p.x, p.y, p.z}; }
Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Real dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(const Vec& a, const Vec& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

Real to_segment2(const Vec& p, const Vec& a, const Vec& b) {
  const Vec ab = b - a, ap = p - a;
  const Real l2 = dot(ab, ab), s = l2 > 0 ? std::clamp(dot(ap, ab) / l2, Real(0), Real(1)) : Real(0);
  const Vec r{ap.x - s * ab.x, ap.y - s * ab.y, ap.z - s * ab.z};
  return dot(r, r);
}

Real brute_distance(const Point3& q, const std::array<Point3, 3>& corners) {
  const Vec p = vec(q), c[3] = {vec(corners[0]), vec(corners[1]), vec(corners[2])};
  Real best = std::min({to_segment2(p, c[0], c[1]), to_segment2(p, c[1], c[2]), to_segment2(p, c[2], c[0])});
  const Vec n = cross(c[1] - c[0], c[2] - c[0]);
  const Real n2 = dot(n, n);
  bool inside = n2 > 0;
  for (int k = 0; k < 3 && inside; ++k) inside = dot(cross(c[(k + 1) % 3] - c[k], p - c[k]), n) > 0;
  if (inside) {
    const Real h = dot(p - c[0], n);
    best = std::min(best, h * h / n2);
  }
  return std::sqrt(best);
}

Mesh rough_mesh(const test::Points& points, double height, std::uint64_t seed) {
  Mesh mesh;
  const SortedTriangulation t = triangulate_unsorted(points, {});
  test::Random random(seed);
  for (const Point2& p : t.xy) mesh.points.push_back({p.x, p.y, random.uniform(-height, height)});
  for (Index i = 0; i < t.triangulation.real; ++i) mesh.faces.push_back(t.triangulation.triangles[i].v);
  return mesh;
}

double extent(const Mesh& mesh) {
  double largest = 0;
  for (const Point3& p : mesh.points) largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  return largest;
}

/// Random, on nodes, on edges, over the middle of faces, far away.
std::vector<Point3> queries(const Mesh& mesh, std::uint64_t seed) {
  test::Random random(seed);
  Box3 box;
  for (const Point3& p : mesh.points) box.add(p);
  const double dx = box.max.x - box.min.x, dy = box.max.y - box.min.y;
  std::vector<Point3> all;
  for (int i = 0; i < 60; ++i) {
    all.push_back({random.uniform(box.min.x - 0.2 * dx, box.max.x + 0.2 * dx),
                   random.uniform(box.min.y - 0.2 * dy, box.max.y + 0.2 * dy),
                   random.uniform(2 * box.min.z, 2 * box.max.z)});
    const auto c = mesh.corners(random.below(mesh.faces.size()));
    all.push_back(c[0]);
    all.push_back({(c[0].x + c[1].x) / 2, (c[0].y + c[1].y) / 2, (c[0].z + c[1].z) / 2});
    all.push_back({(c[0].x + c[1].x + c[2].x) / 3, (c[0].y + c[1].y + c[2].y) / 3, box.max.z});
  }
  all.push_back({box.max.x + 10 * dx, box.max.y + 10 * dy, 0});
  return all;
}

TEST(SurfaceTree, ClosestIsThatOfEveryTriangleTried) {
  for (const test::Family& family : test::families()) {
    if (family.collinear) continue;
    SCOPED_TRACE(family.name);
    for (const double height : {0.0, 0.3, 50.0}) {
      const Mesh mesh = rough_mesh(family.make(300, 7), height, 11);
      if (mesh.faces.empty()) continue;
      const SurfaceTree tree(mesh);
      const double scale = extent(mesh);
      for (const Point3& q : queries(mesh, 3)) {
        Real best = std::numeric_limits<Real>::infinity();
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) best = std::min(best, brute_distance(q, mesh.corners(f)));
        const Closest found = tree.closest(q);
        ASSERT_NE(found.face, no_index);
        const double distance = std::sqrt(found.at.distance2);
        // Relative to the coordinates, or to the distance where the query is farther away than these.
        EXPECT_NEAR(distance, static_cast<double>(best), 1e-12 * std::max(scale, distance));
        EXPECT_NEAR(static_cast<double>(brute_distance(found.at.point, mesh.corners(found.face))), 0, 1e-12 * scale);
      }
    }
  }
}

TEST(SurfaceTree, DegenerateFaces) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 5, 5}};
  mesh.faces = {{0, 1, 2}, {3, 3, 3}, {0, 0, 1}};
  const SurfaceTree tree(mesh);
  EXPECT_DOUBLE_EQ(tree.closest({1.5, 2, 0}).at.distance2, 4);
  EXPECT_DOUBLE_EQ(tree.closest({3, 0, 0}).at.distance2, 1);
  EXPECT_DOUBLE_EQ(tree.closest({6, 5, 5}).at.distance2, 1);
  EXPECT_EQ(tree.cross({1, 0, 1}, {0, 0, 1}).face, no_index);
}

TEST(SurfaceTree, SliversAreAsExactAsOthers) {
  for (const double width : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15}) {
    Mesh mesh;
    mesh.points = {{0, 0, 0}, {1, 0.3, 0.2}, {0.5, 0.15 + width, 0.1}};
    mesh.faces = {{0, 1, 2}};
    const SurfaceTree tree(mesh);
    test::Random random(5);
    for (int i = 0; i < 200; ++i) {
      const double u = random.uniform(), v = random.uniform() * (1 - u);
      const auto c = mesh.corners(0);
      const double lift = i % 2 == 0 ? 0 : random.uniform(-1, 1);
      const Point3 q{c[0].x + u * (c[1].x - c[0].x) + v * (c[2].x - c[0].x),
                     c[0].y + u * (c[1].y - c[0].y) + v * (c[2].y - c[0].y),
                     c[0].z + u * (c[1].z - c[0].z) + v * (c[2].z - c[0].z) + lift};
      EXPECT_NEAR(std::sqrt(tree.closest(q).at.distance2), static_cast<double>(brute_distance(q, c)), 1e-12) << width;
    }
  }
}

TEST(SurfaceTree, UprightLinesMeetTheSurfaceOnceEverywhereOverIt) {
  // Integer nodes: lines through nodes and edges are exact, and none may slip through.
  const Mesh mesh = rough_mesh(test::grid(400, 1), 3, 5);
  const SurfaceTree tree(mesh);
  for (double x = 0; x <= 19; x += 0.25)
    for (double y = 0; y <= 19; y += 0.25) {
      const Crossing c = tree.cross({x, y, 100}, {0, 0, 1});
      ASSERT_NE(c.face, no_index) << x << ' ' << y;
      EXPECT_NEAR(std::sqrt(tree.closest({x, y, 100 + c.t}).at.distance2), 0, 1e-12);
    }
  EXPECT_EQ(tree.cross({-0.001, 3, 0}, {0, 0, 1}).face, no_index);
}

TEST(SurfaceTree, SlantedLinesAgainstEveryTriangle) {
  const Mesh mesh = rough_mesh(test::uniform(400, 3), 0.3, 5);
  const SurfaceTree tree(mesh);
  test::Random random(9);
  int met = 0;
  for (int i = 0; i < 500; ++i) {
    const Point3 p{random.uniform(-0.2, 1.2), random.uniform(-0.2, 1.2), random.uniform(-0.5, 0.5)};
    const Point3 d{random.uniform(-1, 1), random.uniform(-1, 1), i % 3 == 0 ? 0 : random.uniform(-1, 1)};
    Real best = std::numeric_limits<Real>::infinity();
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto c = mesh.corners(f);
      const Vec a = vec(c[0]), e1 = vec(c[1]) - a, e2 = vec(c[2]) - a, s = vec(p) - a, w = vec(d);
      const Real det = dot(cross(w, e2), e1);
      if (det == 0) continue;
      const Real u = dot(cross(w, e2), s) / det, v = dot(cross(s, e1), w) / det, t = dot(cross(s, e1), e2) / det;
      if (u >= 0 && v >= 0 && u + v <= 1 && std::abs(t) < std::abs(best)) best = t;
    }
    const Crossing c = tree.cross(p, d);
    ASSERT_EQ(c.face == no_index, !std::isfinite(static_cast<double>(best)));
    if (c.face == no_index) continue;
    ++met;
    EXPECT_NEAR(c.t, static_cast<double>(best), 1e-10 * std::max(1.0, std::fabs(c.t)));
  }
  EXPECT_GT(met, 100);
}

TEST(SurfaceTree, AFaceIsFoundForAnySize) {
  for (std::size_t n = 1; n < 70; ++n) {  // one leaf, uneven leaves, several levels
    Mesh mesh;
    for (std::size_t i = 0; i < n; ++i) {
      const auto x = static_cast<double>(i);
      mesh.points.insert(mesh.points.end(), {{3 * x, 0, 0}, {3 * x + 1, 0, 0}, {3 * x, 1, 0}});
      mesh.faces.push_back({static_cast<Index>(3 * i), static_cast<Index>(3 * i + 1), static_cast<Index>(3 * i + 2)});
    }
    const SurfaceTree tree(mesh);
    for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(tree.closest({3.0 * static_cast<double>(i) + 0.2, 0.2, 1}).face, i);
  }
}

/// Height fields of long thin triangles, and needles in space.
struct SliverFamily {
  const char* name;
  Mesh (*make)(std::size_t n);
};

Mesh lifted(const test::Points& points, double height) { return rough_mesh(points, height, 17); }

/// A hub and n nodes on a line that doubles hold exactly, as others would leave slivers of rounding along it.
test::Points fan(std::size_t n, const Point2& hub, double x, double height) {
  test::Points points{hub};
  for (std::size_t i = 0; i < n; ++i) points.push_back({x, height * static_cast<double>(i) / static_cast<double>(n)});
  return points;
}

/// A hub and n nodes on a quarter of a circle around it.
test::Points quarter(std::size_t n, const Point2& hub) {
  test::Points points{hub};
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 1.57 * static_cast<double>(i) / static_cast<double>(n);
    points.push_back({hub.x + 3 * std::cos(angle), hub.y + 3 * std::sin(angle)});
  }
  return points;
}

template <class At>
test::Points along(std::size_t n, At&& at) {
  test::Points points;
  for (std::size_t i = 0; i < n; ++i) points.push_back(at(static_cast<double>(i) / static_cast<double>(n), i));
  return points;
}

Mesh needles(std::size_t n) {
  Mesh mesh;
  test::Random random(23);
  const auto in_cube = [&](double half) {
    return Point3{random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half)};
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Point3 a = in_cube(1), b = in_cube(1), aside = in_cube(1e-4);
    mesh.points.insert(mesh.points.end(), {a, b, {b.x + aside.x, b.y + aside.y, b.z + aside.z}});
    const auto first = static_cast<Index>(3 * i);
    mesh.faces.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

const SliverFamily sliver_families[] = {
    {"fan",
     [](auto n) {
       return lifted(fan(n, {0, 0}, 1e6, 20), 0.5);
     }},
    {"fan_from_the_other_side",
     [](auto n) {
       return lifted(fan(n, {1e6, 10}, 0, 20), 0.5);
     }},
    {"flat_quarter",
     [](auto n) {
       return lifted(quarter(n, {0, 0}), 0);
     }},
    {"quarter_far_from_the_origin",
     [](auto n) {
       return lifted(quarter(n, {5e5, 4e6}), 0);
     }},
    {"parabola",
     [](auto n) {
       return lifted(along(n, [](double s, std::size_t) { return Point2{20 * s, 400 * s * s}; }), 0);
     }},
    {"rough_parabola",
     [](auto n) {
       return lifted(along(n, [](double s, std::size_t) { return Point2{20 * s, 400 * s * s}; }), 1);
     }},
    {"two_columns",
     [](auto n) {
       return lifted(along(n,
                           [](double s, std::size_t i) {
                             const double x = static_cast<double>(i % 2);
                             return Point2{0.8 * x - 0.6 * s, 0.6 * x + 0.8 * s};
                           }),
                     0);
     }},
    {"wheel",
     [](auto n) {
       test::Points points = along(n, [](double s, std::size_t) {
         return Point2{std::cos(6.283 * s), std::sin(6.283 * s)};
       });
       points.push_back({0.01, 0.003});
       return lifted(points, 0.01);
     }},
    {"spiral",
     [](auto n) {
       return lifted(along(n,
                           [](double s, std::size_t) {
                             const double t = 60 * s;
                             return Point2{t * std::cos(t), t * std::sin(t)};
                           }),
                     0.01);
     }},
};

/// Nodes of the surface, moved by up to `lift` upwards.
std::vector<Point3> over_nodes(const Mesh& mesh, std::size_t count, double lift) {
  test::Random random(31);
  std::vector<Point3> all;
  for (std::size_t i = 0; i < count; ++i) {
    Point3 p = mesh.points[i * mesh.points.size() / count];
    p.z += lift * random.uniform();
    all.push_back(p);
  }
  return all;
}

/// The closest of all triangles, of equally near ones the first: what the tree has to find, to the last bit.
Closest closest_of_all(const Mesh& mesh, const Point3& p) {
  Closest best;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const ClosestPoint q = closest_on_triangle(p, mesh.corners(f));
    if (q.distance2 < best.at.distance2) best = {q, static_cast<Index>(f)};
  }
  return best;
}

void expect_closest_of_all(const Mesh& mesh, const std::vector<Point3>& places) {
  const SurfaceTree tree(mesh);
  for (const Point3& p : places) {
    const Closest found = tree.closest(p), best = closest_of_all(mesh, p);
    ASSERT_EQ(found.face, best.face) << found.at.distance2 << ' ' << best.at.distance2 << ' ' << p.x << ' ' << p.y
                                     << ' ' << p.z;
    ASSERT_EQ(found.at.distance2, best.at.distance2) << p.x << ' ' << p.y << ' ' << p.z;
  }
}

TEST(SurfaceTree, ClosestOfSliversIsThatOfEveryTriangleTried) {
  for (const SliverFamily& family : sliver_families)
    for (const std::size_t n : {3, 40, 600}) {
      SCOPED_TRACE(family.name + (' ' + std::to_string(n)));
      const Mesh mesh = family.make(n);
      expect_closest_of_all(mesh, queries(mesh, 3));
      for (const double lift : {0.0, 0.3}) expect_closest_of_all(mesh, over_nodes(mesh, 50, lift));
    }
}

TEST(SurfaceTree, ClosestOfNeedlesInSpaceIsThatOfEveryTriangleTried) {
  const Mesh mesh = needles(500);
  expect_closest_of_all(mesh, queries(mesh, 3));
}

TEST(SurfaceTree, ClosestToAFanSeenFromTheHubOfAnother) {
  const Mesh one = sliver_families[0].make(600), other = sliver_families[1].make(600);
  for (const double lift : {0.0, 0.3, 100.0}) {
    expect_closest_of_all(one, over_nodes(other, 200, lift));
    expect_closest_of_all(other, over_nodes(one, 200, lift));
  }
}

TEST(SurfaceTree, UprightLinesThroughSliversMeetThem) {
  for (const SliverFamily& family : sliver_families) {
    SCOPED_TRACE(family.name);
    const Mesh mesh = family.make(600);
    const SurfaceTree tree(mesh);
    for (std::size_t f = 0; f < mesh.faces.size(); f += 7) {
      const auto c = mesh.corners(f);
      if (face_area(c) < 1e-9) continue;  // rounding of its middle may be wider than itself
      const Point3 middle{(c[0].x + c[1].x + c[2].x) / 3, (c[0].y + c[1].y + c[2].y) / 3,
                          (c[0].z + c[1].z + c[2].z) / 3 + 2};
      const Crossing crossing = tree.cross(middle, {0, 0, 1});
      ASSERT_NE(crossing.face, no_index) << f;
      EXPECT_NEAR(crossing.t, -2, 1e-3);
    }
  }
}

double looks(const Mesh& mesh, const std::vector<Point3>& places) {
  const SurfaceTree tree(mesh);
  SearchCounts counts;
  for (const Point3& p : places) static_cast<void>(tree.closest(p, counts));
  return static_cast<double>(counts.boxes + counts.triangles) / static_cast<double>(places.size());
}

TEST(SurfaceTree, AQueryOfSliversLooksAtTenTimesWhatOneOfUniformNodesDoesAtMost) {
  constexpr std::size_t n = 20000, count = 1000;
  const Mesh uniform = lifted(test::uniform(n, 5), 0.001);
  const double usual = looks(uniform, over_nodes(uniform, count, 0));
  EXPECT_LT(usual, 150);
  for (const SliverFamily& family : sliver_families) {
    const Mesh mesh = family.make(n);
    for (const double lift : {0.0, 0.01})
      EXPECT_LT(looks(mesh, over_nodes(mesh, count, lift)), 10 * usual) << family.name << ' ' << lift;
  }
  const Mesh fan = sliver_families[0].make(n), opposite = sliver_families[1].make(n);
  EXPECT_LT(looks(fan, over_nodes(opposite, count, 0)), 10 * usual);
}

TEST(SurfaceTree, CountsAreThoseOfTheSameSearch) {
  const Mesh mesh = sliver_families[0].make(600);
  const SurfaceTree tree(mesh);
  SearchCounts counts;
  for (const Point3& p : queries(mesh, 3)) {
    const SearchCounts before = counts;
    EXPECT_EQ(tree.closest(p, counts).face, tree.closest(p).face);
    EXPECT_GT(counts.boxes, before.boxes);
  }
}

}  // namespace
}  // namespace isopach
