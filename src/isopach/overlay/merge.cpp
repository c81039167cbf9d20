#include "isopach/overlay/merge.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/overlay/seam.hpp"

namespace isopach {

namespace {

seam::Mesh prepare(MeshToMerge& m, std::span<const Index> own) {
  seam::Mesh mesh;
  mesh.triangles = std::move(m.triangulation.triangles);
  mesh.real = m.triangulation.real;
  mesh.xy = m.xy;
  mesh.in_other = m.in_other;
  mesh.own = own;
  mesh.united.resize(m.xy.size());
  for_each_index(own.size(), [&](std::size_t u) {
    if (own[u] != no_index) mesh.united[own[u]] = static_cast<Index>(u);
  });
  return mesh;
}

// Every triangle of T may be an interface triangle (and every task leaves some records unused), and have a proxy.
std::size_t most_interface_records(std::size_t nodes) { return 2 * nodes + nodes / 16 + 4096; }
std::size_t most_records(std::size_t nodes) { return most_interface_records(nodes) + 2 * nodes; }

void check_size(std::size_t nodes) {
  if (most_records(nodes) > static_cast<std::size_t>(no_index / 4))
    throw UsageError(std::to_string(nodes) + " nodes are more than this build can merge (" +
                     std::to_string(no_index / 4 / 5) + "): build with -DISOPACH_INDEX_BITS=64 or thin the scans");
}

}  // namespace

Triangulation merge(MeshToMerge m1, MeshToMerge m2, const UnitedNodes& g, const CurveBox& box, const Context& context) {
  context.check();
  if (m1.triangulation.real == 0 || m2.triangulation.real == 0) return triangulate(g.xy, box, context);
  const std::size_t n = g.xy.size();
  // The meshes are called 0 and 1 by what they are, not by which was named first: 0 owns the first pure node.
  std::size_t pure = 0;
  while (pure < n && g.of_1[pure] != no_index && g.of_2[pure] != no_index) ++pure;
  if (pure == n) return std::move(m1.triangulation);  // one set: one triangulation
  check_size(n);
  std::span<const Index> own_1 = g.of_1, own_2 = g.of_2;
  if (g.of_1[pure] == no_index) {
    std::swap(m1, m2);
    std::swap(own_1, own_2);
  }
  seam::Seam s;
  s.any_shared = m1.xy.size() + m2.xy.size() > n;
  s.mesh[0] = prepare(m1, own_1);
  s.mesh[1] = prepare(m2, own_2);
  s.records.resize(most_records(n));
  s.first_proxy = s.proxies = static_cast<Index>(most_interface_records(n));
  seam::trace_contours(s);
  context.check();
  return seam::sew(s, static_cast<Index>(n));
}

Array<Index> interface_triangles(const Triangulation& t, const UnitedNodes& g) {
  return gather_blocks<Array<Index>>(t.real, std::size_t{1} << 15, [&](std::size_t begin, std::size_t end) {
    Array<Index> part;
    for (auto i = static_cast<Index>(begin); i < end; ++i)
      if (g.joins(t.triangles[i].v)) part.push_back(i);
    return part;
  });
}

}  // namespace isopach
