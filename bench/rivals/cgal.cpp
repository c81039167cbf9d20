// CGAL: Delaunay_triangulation_2 over the kernel with exact predicates and inexact constructions.
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/hilbert_sort.h>
#include <CGAL/version.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "bench/rivals/rival.hpp"

namespace isopach::bench::rival {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Plain = CGAL::Delaunay_triangulation_2<Kernel>;

struct Input {
  std::vector<Kernel::Point_2> points;
};
struct Mesh {
  Plain dt;
};

namespace {

struct Heights {
  double z1 = 0, z2 = 0;
  bool both = false;
};
using Vertex = CGAL::Triangulation_vertex_base_with_info_2<Heights, Kernel>;
using Surface = CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex>>;
using Node = std::pair<Kernel::Point_2, Heights>;

Surface surface(std::span<const Point3> points) {
  std::vector<Node> nodes;
  nodes.reserve(points.size());
  for (const Point3& p : points) nodes.emplace_back(Kernel::Point_2(p.x, p.y), Heights{p.z, p.z, false});
  Surface dt;
  dt.insert(nodes.begin(), nodes.end());
  return dt;
}

double cross(const Kernel::Point_2& o, const Kernel::Point_2& a, const Kernel::Point_2& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

/// Height of `other` at every node of `own`; `own_is_1` says which of the two heights is the node's own.
void add_nodes(const Surface& own, const Surface& other, bool own_is_1, std::vector<Node>& nodes) {
  Surface::Face_handle hint;
  for (auto v = own.finite_vertices_begin(); v != own.finite_vertices_end(); ++v) {
    const Kernel::Point_2& q = v->point();
    const auto face = hint = other.locate(q, hint);
    Heights h{v->info().z1, v->info().z1, !other.is_infinite(face)};
    if (h.both) {
      const auto &a = face->vertex(0)->point(), &b = face->vertex(1)->point(), &c = face->vertex(2)->point();
      const double wa = cross(q, b, c), wb = cross(q, c, a), wc = cross(q, a, b);
      const double z =
          (wa * face->vertex(0)->info().z1 + wb * face->vertex(1)->info().z1 + wc * face->vertex(2)->info().z1) /
          (wa + wb + wc);
      (own_is_1 ? h.z2 : h.z1) = z;
    }
    nodes.emplace_back(q, h);
  }
}

/// Integral of max(d, 0) over a triangle of the given area, d linear.
double positive_part(double area, std::array<double, 3> d) {
  std::sort(d.begin(), d.end());
  const double mean = area * (d[0] + d[1] + d[2]) / 3;
  if (d[0] >= 0) return mean;
  if (d[2] <= 0) return 0;
  if (d[1] <= 0) return area * d[2] * d[2] * d[2] / (3 * (d[2] - d[0]) * (d[2] - d[1]));
  return mean - area * d[0] * d[0] * d[0] / (3 * (d[1] - d[0]) * (d[2] - d[0]));
}

Volume sum_of(const Surface& common) {
  Volume total;
  for (auto f = common.finite_faces_begin(); f != common.finite_faces_end(); ++f) {
    std::array<double, 3> d{}, minus{};
    bool known = true;
    for (int k = 0; k < 3; ++k) {
      const Heights& h = f->vertex(k)->info();
      known = known && h.both;
      d[static_cast<std::size_t>(k)] = h.z2 - h.z1;
      minus[static_cast<std::size_t>(k)] = h.z1 - h.z2;
    }
    if (!known) continue;
    const double area = 0.5 * cross(f->vertex(0)->point(), f->vertex(1)->point(), f->vertex(2)->point());
    total.area += area;
    total.above += positive_part(area, d);
    total.below += positive_part(area, minus);
  }
  return total;
}

}  // namespace

bool available() { return true; }
std::string name() { return "CGAL " CGAL_VERSION_STR; }

std::shared_ptr<Input> input(std::span<const Point2> points) {
  auto made = std::make_shared<Input>();
  made->points.reserve(points.size());
  for (const Point2& p : points) made->points.emplace_back(p.x, p.y);
  return made;
}

std::shared_ptr<Input> hilbert_sorted(std::span<const Point2> points) {
  auto made = input(points);
  CGAL::hilbert_sort(made->points.begin(), made->points.end());
  return made;
}

std::shared_ptr<Mesh> triangulate(const Input& points) {
  auto mesh = std::make_shared<Mesh>();
  mesh->dt.insert(points.points.begin(), points.points.end());
  return mesh;
}

std::shared_ptr<Mesh> copy(const Mesh& mesh) { return std::make_shared<Mesh>(mesh); }

std::size_t edges(const Mesh& mesh) {
  return static_cast<std::size_t>(std::distance(mesh.dt.finite_edges_begin(), mesh.dt.finite_edges_end()));
}

std::size_t locate(const Mesh& mesh, const Input& points) {
  std::size_t inside = 0;
  Plain::Face_handle hint;
  for (const Kernel::Point_2& q : points.points) {
    hint = mesh.dt.locate(q, hint);
    inside += mesh.dt.is_infinite(hint) ? 0 : 1;
  }
  return inside;
}

void insert(Mesh& mesh, const Input& points) {
  Plain::Face_handle hint;
  for (const Kernel::Point_2& q : points.points) hint = mesh.dt.insert(q, hint)->face();
}

Volume compare(std::span<const Point3> a, std::span<const Point3> b) {
  const Surface t1 = surface(a), t2 = surface(b);
  std::vector<Node> nodes;
  nodes.reserve(a.size() + b.size());
  add_nodes(t1, t2, true, nodes);
  add_nodes(t2, t1, false, nodes);
  Surface common;
  common.insert(nodes.begin(), nodes.end());
  return sum_of(common);
}

}  // namespace isopach::bench::rival
