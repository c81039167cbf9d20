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

std::size_t count_outside(const Locations& where) {
  return reduce_blocks<std::size_t>(
      where.size(), default_block,
      [&](std::size_t begin, std::size_t end) {
        std::size_t count = 0;
        for (std::size_t i = begin; i < end; ++i) count += where.kind[i] == Location::Kind::outside ? 1 : 0;
        return count;
      },
      [](std::size_t& total, std::size_t count) { total += count; });
}

}  // namespace

UnionShape shape_of(const MeshToMerge& m1, const MeshToMerge& m2, const UnitedNodes& g) {
  const std::size_t n1 = m1.xy.size(), n2 = m2.xy.size();
  const MeshToMerge& smaller = is_first_extended(g, n1, n2) ? m2 : m1;
  return {g.xy.size(), g.xy.size() - std::max(n1, n2), count_outside(*smaller.in_other), all_runs(g).runs};
}

bool is_first_extended(const UnitedNodes& g, std::size_t n1, std::size_t n2) {
  if (n1 != n2) return n1 > n2;
  std::size_t u = 0;
  while (u + 1 < g.xy.size() && colour(g, u) == 0) ++u;
  return g.xy.empty() || colour(g, u) >= 0;
}

// Costs in units of what triangulating from scratch takes for a node. Nodes outside see much of the rim of the mesh,
// and tear up its thin triangles one after the other: the more, the denser the mesh is.
UnionMethod cheapest(const UnionShape& shape) {
  const auto nodes = static_cast<double>(shape.nodes), runs = static_cast<double>(shape.runs);
  const auto inserted = static_cast<double>(shape.inserted), outside = static_cast<double>(shape.outside);
  const double merging = 0.37 * nodes + 4 * runs;
  const double denser = (nodes - inserted) / std::max(inserted, 1.0);
  const double insertion = 0.12 * nodes + 1.2 * inserted + 2 * denser * outside;
  if (std::min(merging, insertion) >= nodes) return UnionMethod::scratch;
  return merging < insertion ? UnionMethod::merging : UnionMethod::insertion;
}

Triangulation triangulate_union(MeshToMerge m1, MeshToMerge m2, const UnitedNodes& g, const CurveBox& box,
                                const Context& context) {
  context.check();
  const bool first = is_first_extended(g, m1.xy.size(), m2.xy.size());
  MeshToMerge &larger = first ? m1 : m2, &smaller = first ? m2 : m1;
  UnionMethod method = larger.triangulation.real == 0 ? UnionMethod::scratch : cheapest(shape_of(m1, m2, g));
  if (method == UnionMethod::merging && smaller.triangulation.real == 0) method = UnionMethod::insertion;
  if (method == UnionMethod::merging) return merge(std::move(m1), std::move(m2), g, box, context);
  smaller.triangulation = {};  // what nobody asks for any more, before more is taken
  std::optional<Triangulation> t;
  if (method == UnionMethod::insertion)
    t = insert({larger.triangulation, first ? g.of_1 : g.of_2}, {first ? g.of_2 : g.of_1, *smaller.in_other}, g.xy,
               context);
  larger.triangulation = {};
  return t ? std::move(*t) : triangulate(g.xy, box, context);
}

}  // namespace isopach
