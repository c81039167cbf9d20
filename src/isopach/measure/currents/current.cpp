#include "isopach/measure/currents/current.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {

namespace {

constexpr double least_height = 1e-6;  // of a triangle in the plane, in its longest side

/// Nodes on one line become such triangles by rounding. In the plane they are nothing, in space walls.
bool is_line(const Triangulation& t, std::span<const Point2> xy, Index triangle) {
  const auto& v = t.triangles[triangle].v;
  const Point2 &a = xy[v[0]], &b = xy[v[1]], &c = xy[v[2]];
  const auto squared = [](const Point2& p, const Point2& q) {
    return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y);
  };
  const double twice_area = std::fabs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
  return twice_area < least_height * std::max({squared(a, b), squared(b, c), squared(c, a)});
}

struct Facet {
  Point3 centroid, normal;
  std::array<double, 3> sides;  // their lengths
};

Facet facet_of(const std::array<Point3, 3>& at) {
  std::array<Point3, 3> side{};
  Facet facet{};
  Point3 sum{0, 0, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    const Point3 &p = at[k], &q = at[(k + 1) % 3];
    side[k] = {q.x - p.x, q.y - p.y, q.z - p.z};
    facet.sides[k] = std::sqrt(side[k].x * side[k].x + side[k].y * side[k].y + side[k].z * side[k].z);
    sum = {sum.x + p.x, sum.y + p.y, sum.z + p.z};
  }
  const Point3 &e = side[0], &f = side[1];
  facet.centroid = {sum.x / 3, sum.y / 3, sum.z / 3};
  facet.normal = {0.5 * (e.y * f.z - e.z * f.y), 0.5 * (e.z * f.x - e.x * f.z), 0.5 * (e.x * f.y - e.y * f.x)};
  return facet;
}

// What the domain holds of a triangle. False if that is nothing.
bool cut_facet(const std::array<Point3, 3>& at, const Domain& domain, Domain::Scratch& scratch, Facet& facet) {
  ConvexCell cell;
  for (const Point3& p : at) cell.add({p.x, p.y, p.z, p.z});
  const Regions::Answer answer = domain.split(cell, scratch);
  if (answer != Regions::Answer::some) return answer == Regions::Answer::all;
  double area = 0;
  Point3 sum{0, 0, 0};
  for (const ConvexCell& piece : scratch.pieces)
    for_triangles(piece, [&](double part, const Corner& a, const Corner& b, const Corner& c) {
      area += part;
      const double third = part / 3;
      sum.x += third * (a.x + b.x + c.x), sum.y += third * (a.y + b.y + c.y), sum.z += third * (a.z1 + b.z1 + c.z1);
    });
  if (!(area > 0)) return false;
  facet.centroid = {sum.x / area, sum.y / area, sum.z / area};
  const double share = area / facet.normal.z;  // that is the area of the triangle in the plane
  facet.normal = {share * facet.normal.x, share * facet.normal.y, area};
  return true;
}

}  // namespace

SurfaceCurrent surface_current(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                               std::span<const unsigned char> kept, const Domain& domain) {
  const bool whole = domain.is_everything();
  Array<Index> ids;
  for (Index i = 0; i < t.real; ++i)
    if ((kept.empty() || kept[i] != 0) && !is_line(t, xy, i)) ids.push_back(i);
  SurfaceCurrent s;
  s.centroids.resize(ids.size());
  s.normals.resize(ids.size());
  Array<unsigned char> left(whole ? 0 : ids.size());
  const Sum edges = reduce_blocks<Sum>(
      ids.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Sum part;
        Domain::Scratch scratch;
        for (std::size_t i = begin; i < end; ++i) {
          std::array<Point3, 3> at;
          for (std::size_t k = 0; k < 3; ++k) {
            const Index node = t.triangles[ids[i]].v[k];
            at[k] = {xy[node].x, xy[node].y, z[node]};
          }
          Facet facet = facet_of(at);
          if (!whole) {
            left[i] = cut_facet(at, domain, scratch, facet) ? 1 : 0;
            if (left[i] == 0) continue;
          }
          for (const double length : facet.sides) part.add(length);
          s.centroids[i] = facet.centroid;
          s.normals[i] = facet.normal;
        }
        return part;
      },
      [](Sum& total, const Sum& part) { total.add(part); });
  if (!whole) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < left.size(); ++i)
      if (left[i] != 0) s.centroids[n] = s.centroids[i], s.normals[n] = s.normals[i], ++n;
    s.centroids.resize(n), s.normals.resize(n);
  }
  if (!s.centroids.empty()) s.mean_edge = edges.value() / (3.0 * static_cast<double>(s.centroids.size()));
  return s;
}

double default_sigma(const SurfaceCurrent& a, const SurfaceCurrent& b) {
  return 5 * std::max(a.mean_edge, b.mean_edge);
}

}  // namespace isopach
