#include "isopach/tiles/parted_slivers.hpp"

#include <algorithm>
#include <array>
#include <unordered_map>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/slivers.hpp"

namespace isopach {
namespace {

double longest_edge2(const CellPart& part, std::size_t i) {
  double longest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Point2 &p = part.xy[part.triangles[i][k]], &q = part.xy[part.triangles[i][(k + 1) % 3]];
    longest = std::max(longest, (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y));
  }
  return longest;
}

/// A cell with a long edge.
struct LongCell {
  std::array<std::size_t, 3> nodes;  // numbers among all nodes of T
  Cell cell;                         // of a part; of the rest it is told by `triangle`
  Index triangle = no_index;
};

struct EdgeHash {
  std::size_t operator()(const std::array<std::size_t, 2>& e) const {
    return e[0] * 0x9e3779b97f4a7c15ULL ^ (e[1] + 0x7f4a7c15ULL) * 0xbf58476d1ce4e5b9ULL;
  }
};

class Finder {
 public:
  Finder(const PartedCells& cells, const RestOfCells& rest, const Array<unsigned char>& of_scans)
      : cells_(cells), view_(cells.rest()), rest_(rest), of_scans_(of_scans) {}

  /// By the rule of stages::border_slivers: of the rest, ascending, and the cells of parts.
  void find(std::size_t step, std::vector<Index>& of_rest, std::vector<Cell>& of_parts) const {
    std::vector<double> sample = sampled(step);
    if (sample.empty()) return;
    const double limit = stages::sliver_limit2(sample);
    // A rim is beside cells of the rest alone; those of parts are asked for where slivers lead there.
    std::vector<LongCell> all = long_cells(cells_.in_parts(), items(), limit);
    std::vector<std::size_t> slivers = reached(all);
    if (leads_to_parts(all, slivers)) {
      const std::vector<LongCell> more = long_cells(0, cells_.in_parts(), limit);
      all.insert(all.end(), more.begin(), more.end());
      slivers = reached(all);
    }
    for (const std::size_t i : slivers)
      all[i].triangle != no_index ? of_rest.push_back(all[i].triangle) : of_parts.push_back(all[i].cell);
    std::sort(of_rest.begin(), of_rest.end());
  }

 private:
  /// Those of the cells that are at the rim, or beside one that is reached.
  [[nodiscard]] std::vector<std::size_t> reached(const std::vector<LongCell>& all) const {
    std::unordered_map<std::array<std::size_t, 2>, std::array<std::size_t, 2>, EdgeHash> beside;
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [at, is_new] = beside.try_emplace(side(all[i], k), std::array{i, i});
        if (!is_new) at->second[1] = i;
      }
    std::vector<bool> seen(all.size(), false);
    std::vector<std::size_t> slivers;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (all[i].triangle != no_index && is_at_rim(all[i].triangle)) seen[i] = true, slivers.push_back(i);
    for (std::size_t next = 0; next < slivers.size(); ++next)
      for (std::size_t k = 0; k < 3; ++k)
        for (const std::size_t i : beside[side(all[slivers[next]], k)])
          if (!seen[i]) seen[i] = true, slivers.push_back(i);
    return slivers;
  }

  /// What is no cell of T among the rest stands for cells of parts.
  [[nodiscard]] bool leads_to_parts(const std::vector<LongCell>& all, const std::vector<std::size_t>& slivers) const {
    return std::any_of(slivers.begin(), slivers.end(), [&](std::size_t i) {
      const auto& sides = view_.t.triangles[all[i].triangle].n;
      return std::any_of(sides.begin(), sides.end(), [&](HalfEdge h) {
        return !view_.t.is_ghost(triangle_of(h)) && rest_.counted[triangle_of(h)] == 0;
      });
    });
  }

  [[nodiscard]] std::vector<double> sampled(std::size_t step) const {
    return gather_blocks<std::vector<double>>(items(), default_block, [&](std::size_t begin, std::size_t end) {
      std::vector<double> some;
      for_numbered(cells_, rest_, begin, end, [&](const auto& view, std::size_t i, const auto& n) {
        if (std::min({n[0], n[1], n[2]}) % step == 0 && is_of_scans(view, i)) some.push_back(edge2(view, i));
      });
      return some;
    });
  }

  [[nodiscard]] std::vector<LongCell> long_cells(std::size_t first, std::size_t last, double limit) const {
    return gather_blocks<std::vector<LongCell>>(last - first, default_block, [&](std::size_t begin, std::size_t end) {
      std::vector<LongCell> some;
      for_numbered(cells_, rest_, first + begin, first + end, [&](const auto& view, std::size_t i, const auto& n) {
        if (!is_of_scans(view, i) || !(edge2(view, i) > limit)) return;
        if constexpr (std::is_same_v<std::decay_t<decltype(view)>, CellPart>)
          some.push_back({n, view.cell(i)});
        else
          some.push_back({n, {}, static_cast<Index>(i)});
      });
      return some;
    });
  }

  static bool is_of_scans(const CellPart&, std::size_t) { return true; }
  [[nodiscard]] bool is_of_scans(const CellView&, std::size_t i) const { return of_scans_[i] != 0; }
  static double edge2(const CellPart& part, std::size_t i) { return longest_edge2(part, i); }
  static double edge2(const CellView& cells, std::size_t i) { return stages::longest_edge2(cells, i); }

  /// Cells of parts, and triangles of the rest; no pieces.
  [[nodiscard]] std::size_t items() const { return cells_.in_parts() + view_.t.real; }

  /// Beside what is no cell of the scans. What is no cell of T stands for final cells, which have no rim beside them.
  [[nodiscard]] bool is_at_rim(Index triangle) const {
    for (const HalfEdge h : view_.t.triangles[triangle].n) {
      const Index beyond = triangle_of(h);
      if (view_.t.is_ghost(beyond) || (rest_.counted[beyond] != 0 && of_scans_[beyond] == 0)) return true;
    }
    return false;
  }

  static std::array<std::size_t, 2> side(const LongCell& cell, std::size_t k) {
    const std::size_t a = cell.nodes[k], b = cell.nodes[(k + 1) % 3];
    return {std::min(a, b), std::max(a, b)};
  }

  const PartedCells& cells_;
  const CellView& view_;
  const RestOfCells& rest_;
  const Array<unsigned char>& of_scans_;
};

}  // namespace

void describe_slivers(const PartedCells& cells, const RestOfCells& rest, Comparison& c, const Context& context) {
  context.check();
  const Array<unsigned char> of_scans = stages::cells_of_scans(cells.rest(), c);
  std::vector<Index> of_rest;
  std::vector<Cell> of_parts;
  Finder(cells, rest, of_scans).find(stages::sliver_step(c.common), of_rest, of_parts);
  if (of_rest.empty() && of_parts.empty()) return;
  VolumeSums sums{SumScales(bounds_of(cells))};
  for (const Cell& cell : of_parts) sums.add(cell);
  stages::add_slivers(cells.rest(), of_rest, sums);
  stages::note_slivers(sums, c);
}

}  // namespace isopach
