#include "isopach/delaunay/ghosts.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace isopach {

namespace {

void exchange(Array<Triangle>& t, Index i, Index j) {
  const auto moved = [&](HalfEdge h) {
    if (triangle_of(h) == i) return half_edge(j, side_of(h));
    if (triangle_of(h) == j) return half_edge(i, side_of(h));
    return h;
  };
  std::swap(t[i], t[j]);
  for (const Index s : {i, j})
    for (auto& h : t[s].n) h = moved(h);
  for (const Index s : {i, j})
    for (Index k = 0; k < 3; ++k) t[triangle_of(t[s].n[k])].n[side_of(t[s].n[k])] = half_edge(s, k);
}

}  // namespace

Index gather_ghosts(Array<Triangle>& t, Index ghost) {
  std::vector<Index> ring;
  for (Index g = ghost;;) {
    ring.push_back(g);
    g = triangle_of(t[g].n[2]);
    if (g == ghost) break;
  }
  const auto real = static_cast<Index>(t.size() - ring.size());
  std::sort(ring.begin(), ring.end());
  auto free = static_cast<Index>(t.size());
  for (const Index g : ring) {
    if (g >= real) break;
    do --free;
    while (t[free].v[2] == no_index);
    exchange(t, g, free);
  }
  return real;
}

}  // namespace isopach
