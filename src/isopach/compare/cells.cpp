// make_cells: the cells of the measure, and which of them lie in the domain.
#include <algorithm>
#include <optional>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/compare/stages.hpp"

namespace isopach::stages {
namespace {

// Where one surface is known: on its nodes and inside its hull.
bool inside(Location::Kind kind) { return kind != Location::Kind::outside && kind != Location::Kind::none; }

/// What of a cell counts for which sum, by the nodes of both scans in both footprints.
class CellRules {
 public:
  CellRules(const Common& common, std::span<const Point2> xy, const Pair& pair, const Borders& borders,
            const CompareOptions& options)
      : g_(common.nodes),
        xy_(xy),
        over_hull_(options.domain == DomainKind::hull),
        anything_goes_(over_hull_ && options.border == BorderRule::hull && !(options.max_edge > 0) &&
                       !(options.alpha > 0)),
        in_{FootprintOfNodes(borders.in[0], g_.of_1, g_.of_2), FootprintOfNodes(borders.in[1], g_.of_2, g_.of_1)},
        known_in_both_(xy.size()) {
    if (borders.single)
      single_.emplace(std::array{FootprintOfNodes((*borders.single)[0], g_.of_1, g_.of_2),
                                 FootprintOfNodes((*borders.single)[1], g_.of_2, g_.of_1)});
    const auto knows = [&](std::size_t scan, Index node) { return inside(pair.seen[scan].at.kind[node]); };
    for_each_index(xy.size(), [&](std::size_t i) {
      const Index i1 = g_.of_1[i], i2 = g_.of_2[i];
      known_in_both_[i] = (i1 == no_index ? knows(1, i2) : i2 != no_index || knows(0, i1)) ? 1 : 0;
    });
  }

  using Nodes = std::array<Index, 3>;
  [[nodiscard]] bool over_hull() const { return over_hull_; }
  [[nodiscard]] bool in_hulls(const Nodes& v) const {
    return over_hull_ || (known_in_both_[v[0]] != 0 && known_in_both_[v[1]] != 0 && known_in_both_[v[2]] != 0);
  }
  /// As Cells::scanned.
  [[nodiscard]] int scanned(const Nodes& v) const {
    if (anything_goes_) return 3;
    return (in_[0].holds(v, xy_) ? 1 : 0) + (in_[1].holds(v, xy_) ? 2 : 0);
  }
  /// In the footprint of a scan, and not without its folds.
  [[nodiscard]] bool folded(const Nodes& v) const {
    if (!single_) return false;
    return (in_[0].holds(v, xy_) && !(*single_)[0].holds(v, xy_)) ||
           (in_[1].holds(v, xy_) && !(*single_)[1].holds(v, xy_));
  }

 private:
  const UnitedNodes& g_;
  std::span<const Point2> xy_;
  bool over_hull_, anything_goes_;
  std::array<FootprintOfNodes, 2> in_;
  std::optional<std::array<FootprintOfNodes, 2>> single_;
  Array<unsigned char> known_in_both_;
};

/// Sums over the cells that are no part of the domain for one reason or another.
struct LeftOut {
  struct Part {
    Sum area, above, below;
    void add(const Cell& cell) {
      const Parts parts = split_volume(cell);
      area.add(cell.area), above.add(parts.above), below.add(parts.below);
    }
    void add(const Part& p) { area.add(p.area), above.add(p.above), below.add(p.below); }
  };
  Index interface = 0;
  Sum trimmed_area, trimmed_volume;
  Part folded;

  void trim(const Cell& cell) {
    const Parts parts = split_volume(cell);
    trimmed_area.add(cell.area);
    trimmed_volume.add(parts.above + parts.below);
  }
  void add(const LeftOut& part) {
    interface += part.interface;
    trimmed_area.add(part.trimmed_area);
    trimmed_volume.add(part.trimmed_volume);
    folded.add(part.folded);
  }
};

/// Sets in_domain and scanned of the cells [begin, end).
LeftOut judge_cells(Cells& cells, const Common& common, const CellRules& rules, bool folds_left_out,
                    const Domain& domain, std::size_t begin, std::size_t end) {
  LeftOut part;
  Domain::Scratch scratch;
  const CellView view = cells.view();
  const auto for_inside = [&](std::size_t i, auto&& f) {  // the cell, or what of it lies in the domain
    if (domain.is_everything()) return f(cell_at(view, i));
    domain.for_pieces(convex(view, i), scratch, [&](const ConvexCell& piece) {
      for_triangles(piece, [&](double area, const Corner& p, const Corner& q, const Corner& r) {
        f(Cell{area, {p.d(), q.d(), r.d()}});
      });
    });
  };
  for (std::size_t i = begin; i < end; ++i) {
    const auto& v = cells.triangulation.triangles[i].v;
    const bool in_hulls = rules.in_hulls(v);
    const int by = rules.scanned(v);
    cells.scanned[i] = static_cast<unsigned char>(by);
    const bool sampled = in_hulls && (rules.over_hull() ? by != 0 : by == 3), in_fold = sampled && rules.folded(v);
    cells.in_domain[i] = sampled && !(in_fold && folds_left_out) ? 1 : 0;
    if (in_hulls && !sampled) for_inside(i, [&](const Cell& cell) { part.trim(cell); });
    if (in_fold) for_inside(i, [&](const Cell& cell) { part.folded.add(cell); });
    part.interface += common.nodes.joins(v) ? 1 : 0;
  }
  return part;
}

}  // namespace

Cells make_cells(Common& common, const Pair& pair, const Borders& borders, const Domain& domain, Comparison& c) {
  Cells cells;
  const UnitedNodes& g = common.nodes;
  const std::size_t n = g.xy.size();
  const Scan &a = pair.scan[0], &b = pair.scan[1];
  cells.z1.resize(n);
  cells.z2.resize(n);
  for_each_index(n, [&](std::size_t i) {
    const Index i1 = g.of_1[i], i2 = g.of_2[i];
    cells.z1[i] = i1 != no_index ? a.field.z[i1] : pair.seen[1].z[i2];
    cells.z2[i] = i2 != no_index ? b.field.z[i2] : pair.seen[0].z[i1];
  });
  cells.triangulation = std::move(common.t);
  cells.xy = std::move(common.nodes.xy);
  cells.in_domain.resize(cells.triangulation.real);
  cells.scanned.resize(cells.triangulation.real);
  const CellRules rules(common, cells.xy, pair, borders, c.options);
  const LeftOut found = reduce_blocks<LeftOut>(
      cells.triangulation.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        return judge_cells(cells, common, rules, borders.left_out, domain, begin, end);
      },
      [](LeftOut& total, const LeftOut& part) { total.add(part); });
  c.common = cells.triangulation.real;
  c.interface = found.interface;
  c.trimmed_area = found.trimmed_area.value();
  c.trimmed_volume = found.trimmed_volume.value();
  c.folds.area = found.folded.area.value();
  Volume& in_folds = c.folds.volume;
  in_folds.above = found.folded.above.value(), in_folds.below = found.folded.below.value();
  in_folds.net = in_folds.above - in_folds.below, in_folds.absolute = in_folds.above + in_folds.below;
  return cells;
}

}  // namespace isopach::stages
