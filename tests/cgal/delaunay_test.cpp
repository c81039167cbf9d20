// CGAL as oracle of the triangulation, edge by edge. Its ties are broken by another rule, so an edge that the other
// diagonal of a cocircular quadrilateral may replace is left out on both sides.
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "isopach/delaunay/triangulate.hpp"
#include "isopach/geom/predicates.hpp"
#include "tests/support/mesh.hpp"
#include "tests/support/points.hpp"

namespace isopach::test {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Delaunay = CGAL::Delaunay_triangulation_2<Kernel>;
using Segment = std::array<Point2, 2>;
using Segments = std::vector<Segment>;

Point2 ours(const Kernel::Point_2& p) { return {p.x(), p.y()}; }

Segments sorted(Segments edges) {
  for (Segment& e : edges)
    if (lexicographic_less(e[1], e[0])) std::swap(e[0], e[1]);
  std::sort(edges.begin(), edges.end(), [](const Segment& a, const Segment& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), lexicographic_less);
  });
  return edges;
}

struct EdgeSets {
  Segments strict;  ///< no tie: in every Delaunay triangulation of the points
  std::size_t all = 0;
};

EdgeSets edges_of(const Delaunay& dt) {
  EdgeSets sets;
  for (auto e = dt.finite_edges_begin(); e != dt.finite_edges_end(); ++e) {
    ++sets.all;
    const auto face = e->first, other = face->neighbor(e->second);
    const Kernel::Point_2 &p = face->vertex(dt.cw(e->second))->point(), &q = face->vertex(dt.ccw(e->second))->point();
    if (dt.dimension() == 2 && !dt.is_infinite(face) && !dt.is_infinite(other)) {
      const auto& opposite = other->vertex(dt.mirror_index(face, e->second))->point();
      if (CGAL::side_of_oriented_circle(face->vertex(0)->point(), face->vertex(1)->point(), face->vertex(2)->point(),
                                        opposite) == CGAL::ON_ORIENTED_BOUNDARY)
        continue;
    }
    sets.strict.push_back({ours(p), ours(q)});
  }
  sets.strict = sorted(sets.strict);
  return sets;
}

EdgeSets edges_of(const SortedTriangulation& s) {
  EdgeSets sets;
  const Triangulation& t = s.triangulation;
  for (Index i = 0; i < t.triangles.size(); ++i)
    for (Index k = 0; k < 3; ++k) {
      const HalfEdge h = half_edge(i, k), twin = t.twin(h);
      if (twin < h || t.origin(h) == no_index || t.target(h) == no_index) continue;
      ++sets.all;
      const Index other = triangle_of(twin);
      if (!t.is_ghost(i) && !t.is_ghost(other)) {
        const auto& v = t.triangles[i].v;
        const Index d = t.triangles[other].v[previous_side(side_of(twin))];
        if (in_circle(s.xy[v[0]], s.xy[v[1]], s.xy[v[2]], s.xy[d]) == 0) continue;
      }
      sets.strict.push_back({s.xy[t.origin(h)], s.xy[t.target(h)]});
    }
  sets.strict = sorted(sets.strict);
  return sets;
}

void expect_equal_to_cgal(const Points& points) {
  Delaunay dt;
  std::vector<Kernel::Point_2> input;
  for (const Point2& p : points) input.emplace_back(p.x, p.y);
  dt.insert(input.begin(), input.end());
  const SortedTriangulation s = triangulate_unsorted(points, {});
  ASSERT_EQ(dt.number_of_vertices(), s.xy.size());
  EXPECT_EQ(dt.dimension() == 2 ? dt.number_of_faces() : 0, s.triangulation.real);
  const EdgeSets expected = edges_of(dt), found = edges_of(s);
  EXPECT_EQ(found.all, expected.all);
  EXPECT_EQ(found.strict, expected.strict);
}

class CgalFamilies : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(All, CgalFamilies, testing::ValuesIn(families()),
                         [](const auto& family) { return family.param.name; });

TEST_P(CgalFamilies, HasTheSameEdges) {
  for (const std::size_t n : {2, 3, 10, 100, 1000, 20000}) {
    SCOPED_TRACE(n);
    expect_equal_to_cgal(GetParam().make(n, 201));
  }
}

TEST(Cgal, HasTheSameEdgesForManyUniformPoints) { expect_equal_to_cgal(uniform(200000, 202)); }

}  // namespace
}  // namespace isopach::test
