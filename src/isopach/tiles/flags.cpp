#include "isopach/tiles/flags.hpp"

namespace isopach {
namespace {

/// Several tasks may flag one node at a time, all with the same.
void flag(unsigned char& at) { write_shared(at, static_cast<unsigned char>(1)); }

}  // namespace

Flags certified_triangles(const Triangulation& t, std::span<const Point2> xy, const OpenBox& square) {
  Flags certified(t.real);
  for_each_index(t.real, [&](std::size_t i) {
    const auto& v = t.triangles[i].v;
    certified[i] = disc_inside(xy[v[0]], xy[v[1]], xy[v[2]], square) ? 1 : 0;
  });
  return certified;
}

Flags nodes_beside(const Triangulation& t, const Flags& of_triangles) {
  if (t.triangles.empty()) return Flags(t.nodes, 1);
  Flags nodes(t.nodes, 0);
  for_each_index(t.triangles.size(), [&](std::size_t i) {
    if (i < t.real && of_triangles[i] != 0) return;
    for (const Index v : t.triangles[i].v)
      if (v != no_index) flag(nodes[v]);
  });
  return nodes;
}

Flags with_neighbours(const Triangulation& t, const Flags& of_nodes) {
  Flags nodes = of_nodes;
  for_each_index(t.triangles.size(), [&](std::size_t i) {
    const auto& v = t.triangles[i].v;
    const auto is_flagged = [&](Index node) { return node != no_index && of_nodes[node] != 0; };
    if (!is_flagged(v[0]) && !is_flagged(v[1]) && !is_flagged(v[2])) return;
    for (const Index node : v)
      if (node != no_index) flag(nodes[node]);
  });
  return nodes;
}

Array<HalfEdge> leaving_nodes(const Triangulation& t) {
  Array<HalfEdge> leaving(t.nodes, no_index);
  for_each_index(t.real, [&](std::size_t i) {
    for (Index k = 0; k < 3; ++k) write_shared(leaving[t.triangles[i].v[k]], half_edge(static_cast<Index>(i), k));
  });
  return leaving;
}

}  // namespace isopach
