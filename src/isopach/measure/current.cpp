#include "isopach/measure/current.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {

SurfaceCurrent surface_current(const Triangulation& t, std::span<const Point2> xy, std::span<const double> z,
                               std::span<const unsigned char> kept) {
  Array<Index> ids;
  for (Index i = 0; i < t.real; ++i)
    if (kept.empty() || kept[i] != 0) ids.push_back(i);
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
