#include "isopach/measure/current.hpp"

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

}  // namespace

SurfaceCurrent surface_current(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                               std::span<const unsigned char> kept) {
  Array<Index> ids;
  for (Index i = 0; i < t.real; ++i)
    if ((kept.empty() || kept[i] != 0) && !is_line(t, xy, i)) ids.push_back(i);
  SurfaceCurrent s;
  s.centroids.resize(ids.size());
  s.normals.resize(ids.size());
  const Sum edges = reduce_blocks<Sum>(
      ids.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        Sum part;
        for (std::size_t i = begin; i < end; ++i) {
          const auto& v = t.triangles[ids[i]].v;
          std::array<Point3, 3> side{};
          Point3 sum{0, 0, 0};
          for (std::size_t k = 0; k < 3; ++k) {
            const Index p = v[k], q = v[(k + 1) % 3];
            side[k] = {xy[q].x - xy[p].x, xy[q].y - xy[p].y, z[q] - z[p]};
            part.add(std::sqrt(side[k].x * side[k].x + side[k].y * side[k].y + side[k].z * side[k].z));
            sum = {sum.x + xy[p].x, sum.y + xy[p].y, sum.z + z[p]};
          }
          const Point3 &e = side[0], &f = side[1];
          s.centroids[i] = {sum.x / 3, sum.y / 3, sum.z / 3};
          s.normals[i] = {0.5 * (e.y * f.z - e.z * f.y), 0.5 * (e.z * f.x - e.x * f.z), 0.5 * (e.x * f.y - e.y * f.x)};
        }
        return part;
      },
      [](Sum& total, const Sum& part) { total.add(part); });
  if (!ids.empty()) s.mean_edge = edges.value() / (3.0 * static_cast<double>(ids.size()));
  return s;
}

double default_sigma(const SurfaceCurrent& a, const SurfaceCurrent& b) {
  return 5 * std::max(a.mean_edge, b.mean_edge);
}

}  // namespace isopach
