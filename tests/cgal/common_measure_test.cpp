// The common measure computed a second time, with CGAL: two triangulations, each node located in the other, the
// triangulation of the union, and the integrals in long double. Ties of the union are broken by the library's rule, so
// only pairs without them, or whose ties are few, can agree to the last digits.
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <gtest/gtest.h>

#include <map>
#include <optional>

#include "isopach/compare/compare.hpp"
#include "isopach/io/read.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/oracle.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach::test {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

struct Heights {
  std::optional<long double> z1, z2;
};
using Vertex = CGAL::Triangulation_vertex_base_with_info_2<Heights, Kernel>;
using Delaunay = CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex>>;
using Node = std::pair<Kernel::Point_2, Heights>;

struct Before {
  bool operator()(const Point2& p, const Point2& q) const { return lexicographic_less(p, q); }
};
using Nodes = std::map<Point2, long double, Before>;

/// Nodes with the mean of their heights, as the default of a comparison.
Nodes nodes_of(const Cloud& cloud) {
  std::map<Point2, std::pair<long double, int>, Before> sums;
  for (const Point3& p : cloud.points) {
    auto& [sum, count] = sums[{p.x, p.y}];
    sum += p.z;
    ++count;
  }
  Nodes nodes;
  for (const auto& [p, s] : sums) nodes[p] = s.first / s.second;
  return nodes;
}

Delaunay triangulated(const Nodes& nodes) {
  std::vector<Node> input;
  for (const auto& [p, z] : nodes) input.emplace_back(Kernel::Point_2(p.x, p.y), Heights{z, {}});
  Delaunay dt;
  dt.insert(input.begin(), input.end());
  return dt;
}

long double cross(const Kernel::Point_2& o, const Kernel::Point_2& a, const Kernel::Point_2& b) {
  const long double ax = static_cast<long double>(a.x()) - o.x(), ay = static_cast<long double>(a.y()) - o.y();
  const long double bx = static_cast<long double>(b.x()) - o.x(), by = static_cast<long double>(b.y()) - o.y();
  return ax * by - ay * bx;
}

std::optional<long double> height_at(const Delaunay& dt, const Kernel::Point_2& q, Delaunay::Face_handle& hint) {
  const auto face = dt.locate(q, hint);
  hint = face;
  if (dt.is_infinite(face)) {
    // A point on the hull may be answered with the face beyond it.
    const auto inner = face->neighbor(face->index(dt.infinite_vertex()));
    for (int k = 0; k < 3; ++k)
      if (CGAL::orientation(inner->vertex(k)->point(), inner->vertex(dt.ccw(k))->point(), q) < 0) return {};
    return height_at(dt, q, hint = inner);
  }
  const auto &a = face->vertex(0)->point(), &b = face->vertex(1)->point(), &c = face->vertex(2)->point();
  const long double wa = cross(q, b, c), wb = cross(q, c, a), wc = cross(q, a, b);
  const auto z = [&](int k) { return *face->vertex(k)->info().z1; };
  return (wa * z(0) + wb * z(1) + wc * z(2)) / (wa + wb + wc);
}

std::vector<HullSide> hull_sides(const Delaunay& dt) {
  std::vector<HullSide> sides;
  const auto around = dt.incident_faces(dt.infinite_vertex());
  for (auto f = around;;) {
    const int k = f->index(dt.infinite_vertex());
    const auto p = f->vertex(dt.cw(k)), q = f->vertex(dt.ccw(k));  // the hull lies left of p→q
    sides.push_back({{p->point().x(), p->point().y()}, {q->point().x(), q->point().y()}, *p->info().z1, *q->info().z1});
    if (++f; f == around) break;
  }
  return sides;
}

Parts measure_with_cgal(const Cloud& a, const Cloud& b) {
  const Nodes nodes_a = nodes_of(a), nodes_b = nodes_of(b);
  const Delaunay t1 = triangulated(nodes_a), t2 = triangulated(nodes_b);
  std::map<Point2, Heights, Before> united;
  Delaunay::Face_handle hint1 = t1.finite_faces_begin(), hint2 = t2.finite_faces_begin();
  for (const auto& [p, z] : nodes_a) united[p] = {z, height_at(t2, {p.x, p.y}, hint2)};
  for (const auto& [p, z] : nodes_b) {
    Heights& h = united[p];
    h.z2 = z;
    if (!h.z1) h.z1 = height_at(t1, {p.x, p.y}, hint1);
  }
  std::vector<Node> input;
  for (const auto& [p, h] : united) input.emplace_back(Kernel::Point_2(p.x, p.y), h);
  Delaunay t;
  t.insert(input.begin(), input.end());
  const std::vector<HullSide> hull_1 = hull_sides(t1), hull_2 = hull_sides(t2);
  Parts total;
  for (auto f = t.finite_faces_begin(); f != t.finite_faces_end(); ++f) {
    std::array<CellCorner, 3> cell{};
    bool known = true;
    for (int k = 0; k < 3; ++k) {
      const auto& [z1, z2] = f->vertex(k)->info();
      known = known && z1 && z2;
      const auto& p = f->vertex(k)->point();
      cell[static_cast<std::size_t>(k)] = {p.x(), p.y(), z1.value_or(0), z2.value_or(0)};
    }
    const Parts part = known ? brute_parts_in_hulls(cell, {}, {}) : brute_parts_in_hulls(cell, hull_1, hull_2);
    total = {total.area + part.area, total.above + part.above, total.below + part.below};
  }
  return total;
}

// What CGAL triangulates is measured over convex hulls, folds and all: heights that are noise look folded here and
// there.
CompareOptions over_hulls() {
  CompareOptions options;
  options.border = BorderRule::hull;
  options.folds = FoldRule::keep;
  return options;
}

void expect_equal(const Comparison& c, const Parts& expected, double tolerance) {
  const auto near = [&](double found, long double wanted, const char* what) {
    EXPECT_NEAR(found, static_cast<double>(wanted), tolerance * std::fabs(static_cast<double>(wanted))) << what;
  };
  near(c.domain_area, expected.area, "area");
  near(c.measures.volume.above, expected.above, "above");
  near(c.measures.volume.below, expected.below, "below");
  near(c.measures.rho, (expected.above + expected.below) / expected.area, "rho");
}

TEST(CgalCommonMeasure, OfUniformPairs) {
  for (const std::uint64_t seed : {211, 212, 213}) {
    const Cloud a = rough_cloud(uniform(10000, seed), seed), b = rough_cloud(uniform(13000, seed + 10), seed + 20);
    expect_equal(compare(a, b, over_hulls(), {}), measure_with_cgal(a, b), 1e-12);
  }
}

TEST(CgalCommonMeasure, OfHarderFamilies) {
  for (const auto& make : {clustered, utm, thin_strip, huge, far_outlier}) {
    const Cloud a = rough_cloud(distinct(make(4000, 214)), 215), b = rough_cloud(distinct(make(5000, 216)), 217);
    CompareOptions options = over_hulls();
    options.check_layers = false;
    expect_equal(compare(a, b, options, {}), measure_with_cgal(a, b), 1e-9);
  }
}

TEST(CgalCommonMeasure, OfTheSantaCruzStrips) {
  ISOPACH_SHARED_OR_SKIP(folder, "santacruz");
  const Cloud a = read_cloud((folder / "blanca_strip8706_120m.las").string(), {}, {});
  const Cloud b = read_cloud((folder / "blanca_strip8707_120m.las").string(), {}, {});
  const Comparison c = compare(a, b, over_hulls(), {});
  const Parts expected = measure_with_cgal(a, b);
  // Centimetres make ties, and a tie broken the other way moves ρ in its seventh digit.
  expect_equal(c, expected, 1e-5);
  EXPECT_NEAR(c.domain_area, static_cast<double>(expected.area), 1e-9 * c.domain_area);
  EXPECT_NEAR(c.measures.volume.net, static_cast<double>(expected.above - expected.below),
              1e-5 * c.measures.volume.absolute);
}

}  // namespace
}  // namespace isopach::test
