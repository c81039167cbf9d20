#include "isopach/delaunay/triangulation.hpp"

namespace isopach {

Array<Index> hull_nodes(const Triangulation& t, std::span<const Point2> xy) {
  Array<Index> hull;
  if (t.ghosts() == 0) {
    if (t.nodes == 1) hull.push_back(0);
    return hull;
  }
  // Ghost of the hull edge a→b is (b, a, none); its side 2 leads to the ghost of the next edge.
  Index first = t.real;
  for (Index g = t.real; g < t.triangles.size(); ++g)
    if (lexicographic_less(xy[t.triangles[g].v[1]], xy[t.triangles[first].v[1]])) first = g;
  hull.reserve(t.ghosts());
  Index g = first;
  do {
    hull.push_back(t.triangles[g].v[1]);
    g = triangle_of(t.triangles[g].n[2]);
  } while (g != first);
  return hull;
}

}  // namespace isopach
