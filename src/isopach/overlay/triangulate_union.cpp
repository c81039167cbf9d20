#include "isopach/overlay/triangulate_union.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/overlay/insert.hpp"

namespace isopach {

namespace {

// Colour of the nodes of one set alone; 0 for a shared node.
int colour(const UnitedNodes& g, std::size_t u) {
  return (g.of_1[u] != no_index ? 1 : 0) - (g.of_2[u] != no_index ? 1 : 0);
}

// Runs of a stretch of nodes, and what is needed to join stretches.
struct Stretch {
  int first = 0, last = 0;
  std::size_t runs = 0;
};

Stretch stretch_of(const UnitedNodes& g, std::size_t begin, std::size_t end) {
  Stretch s;
  for (std::size_t u = begin; u < end; ++u) {
    const int c = colour(g, u);
    s.runs += static_cast<std::size_t>(c != 0) & static_cast<std::size_t>(c != s.last);
    s.last = c != 0 ? c : s.last;
    s.first = s.first != 0 ? s.first : c;
  }
  return s;
}

void append(Stretch& s, const Stretch& next) {
  if (next.runs == 0) return;
  s.runs += next.runs - (s.last == next.first ? 1 : 0);
  s.last = next.last;
  s.first = s.first != 0 ? s.first : next.first;
}

Stretch all_runs(const UnitedNodes& g) {
  return reduce_blocks<Stretch>(
      g.xy.size(), default_block, [&](std::size_t begin, std::size_t end) { return stretch_of(g, begin, end); },
      append);
}

}  // namespace

UnionShape shape_of(const UnitedNodes& g, std::size_t n1, std::size_t n2) {
  return {g.xy.size(), g.xy.size() - std::max(n1, n2), all_runs(g).runs};
}

bool is_first_extended(const UnitedNodes& g, std::size_t n1, std::size_t n2) {
  if (n1 != n2) return n1 > n2;
  std::size_t u = 0;
  while (u + 1 < g.xy.size() && colour(g, u) == 0) ++u;
  return g.xy.empty() || colour(g, u) >= 0;
}

// Costs in units of what triangulating from scratch takes for a node.
UnionMethod cheapest(const UnionShape& shape) {
  const auto nodes = static_cast<double>(shape.nodes);
  const double merging = 0.37 * nodes + 4 * static_cast<double>(shape.runs);
  const double insertion = 0.12 * nodes + 1.2 * static_cast<double>(shape.inserted);
  return merging < insertion ? UnionMethod::merging : UnionMethod::insertion;
}

Triangulation triangulate_union(MeshToMerge m1, MeshToMerge m2, const UnitedNodes& g, const CurveBox& box,
                                const Context& context) {
  context.check();
  const std::size_t n1 = m1.xy.size(), n2 = m2.xy.size();
  const bool first = is_first_extended(g, n1, n2);
  MeshToMerge &larger = first ? m1 : m2, &smaller = first ? m2 : m1;
  if (larger.triangulation.real == 0) return triangulate(g.xy, box, context);
  if (smaller.triangulation.real > 0 && cheapest(shape_of(g, n1, n2)) == UnionMethod::merging)
    return merge(std::move(m1), std::move(m2), g, box, context);
  smaller.triangulation = {};
  std::optional<Triangulation> t = insert({larger.triangulation, first ? g.of_1 : g.of_2},
                                          {first ? g.of_2 : g.of_1, *smaller.in_other}, g.xy, context);
  larger.triangulation = {};
  return t ? std::move(*t) : triangulate(g.xy, box, context);
}

}  // namespace isopach
