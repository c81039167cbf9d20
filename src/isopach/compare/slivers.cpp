#include "isopach/compare/slivers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"

namespace isopach::stages {
namespace {

constexpr double sliver_length = 5;
constexpr double sliver_warning_share = 0.01;

std::vector<Index> border_slivers(const CellView& cells) {
  const std::size_t n = cells.t.real;
  const Index step = sliver_step(n);
  const auto in_domain = [&](Index t) { return !cells.t.is_ghost(t) && cells.in_domain[t] != 0; };
  // Of cells by their first node, not by their number, which depends on how T was made.
  auto sample = gather_blocks<std::vector<double>>(n, default_block, [&](std::size_t begin, std::size_t end) {
    std::vector<double> some;
    for (std::size_t i = begin; i < end; ++i) {
      const auto& v = cells.t.triangles[i].v;
      if (std::min({v[0], v[1], v[2]}) % step == 0 && cells.in_domain[i] != 0) some.push_back(longest_edge2(cells, i));
    }
    return some;
  });
  if (sample.empty()) return {};
  const double limit = sliver_limit2(sample);
  // Cells at the rim, seen from what lies beyond it.
  const std::size_t all = cells.t.triangles.size();
  auto slivers = gather_blocks<std::vector<Index>>(all, default_block, [&](std::size_t begin, std::size_t end) {
    std::vector<Index> some;
    for (auto i = static_cast<Index>(begin); i < end; ++i) {
      if (in_domain(i)) continue;
      for (const HalfEdge h : cells.t.triangles[i].n)
        if (const Index t = triangle_of(h); in_domain(t) && longest_edge2(cells, t) > limit) some.push_back(t);
    }
    return some;
  });
  std::sort(slivers.begin(), slivers.end());
  slivers.erase(std::unique(slivers.begin(), slivers.end()), slivers.end());
  std::vector<bool> seen(n, false);
  for (const Index i : slivers) seen[i] = true;
  for (std::size_t next = 0; next < slivers.size(); ++next)
    for (const HalfEdge h : cells.t.triangles[slivers[next]].n) {
      const Index t = triangle_of(h);
      if (!in_domain(t) || seen[t] || longest_edge2(cells, t) <= limit) continue;
      seen[t] = true;
      slivers.push_back(t);
    }
  return slivers;
}

}  // namespace

Index sliver_step(std::size_t cells) {
  constexpr std::size_t enough = 20000;
  return static_cast<Index>(cells / enough + 1);
}

double sliver_limit2(std::vector<double>& longest2) { return median(longest2) * sliver_length * sliver_length; }

double longest_edge2(const CellView& cells, std::size_t i) {
  const std::array<Index, 3> v = cells.corners(i);
  double longest = 0;
  for (Index k = 0; k < 3; ++k) {
    const Point2 &p = cells.xy[v[k]], &q = cells.xy[v[next_side(k)]];
    longest = std::max(longest, (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y));
  }
  return longest;
}

Array<unsigned char> cells_of_scans(const CellView& cells, const Comparison& c) {
  Array<unsigned char> of_scans = c.cells.unclipped.empty() ? c.cells.in_domain : c.cells.unclipped;
  for (const CellPiece& piece : cells.pieces) of_scans[piece.cell] = 1;
  return of_scans;
}

void add_slivers(const CellView& cells, const std::vector<Index>& slivers, VolumeSums& sums) {
  for (const Index i : slivers)
    if (cells.in_domain[i] != 0) sums.add(cell_at(cells, i));
  for (const CellPiece& piece : cells.pieces)
    if (std::binary_search(slivers.begin(), slivers.end(), piece.cell)) sums.add(cell_of(piece));
}

void note_slivers(const VolumeSums& sums, Comparison& c) {
  c.sliver_area = sums.area.value() / c.measures.area;
  c.sliver_volume = c.measures.volume.absolute > 0 ? sums.volume().absolute / c.measures.volume.absolute : 0;
  if (c.sliver_volume > sliver_warning_share)
    c.warnings.push_back(
        fmt::format("long thin triangles along the border of the scans carry {:.1f} % of the absolute volume on {:.1f} "
                    "% of the area: "
                    "they bridge gaps between the outermost points, so look at the map before trusting that part{}",
                    100 * c.sliver_volume, 100 * c.sliver_area,
                    c.options.border == BorderRule::hull ? ", or leave them out with @border trim" : ""));
}

void describe_slivers(const CellView& cells, Comparison& c) {
  const Array<unsigned char> of_scans = cells_of_scans(cells, c);
  CellView unclipped = cells;
  unclipped.in_domain = of_scans;
  std::vector<Index> slivers = border_slivers(unclipped);
  if (slivers.empty()) return;
  std::sort(slivers.begin(), slivers.end());
  VolumeSums sums{SumScales(bounds_of(cells))};
  add_slivers(cells, slivers, sums);
  note_slivers(sums, c);
}

}  // namespace isopach::stages
