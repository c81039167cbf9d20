#include "isopach/tiles/parted_changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/base/memory.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/changes.hpp"
#include "isopach/measure/changes/change_nodes.hpp"
#include "isopach/measure/uncertainty/detection.hpp"

namespace isopach {
namespace {

/// Numbers of the corners of a cell among all nodes of T, as the cell has them.
using Numbers = std::array<std::size_t, 3>;

/// The cells that objects are made of, as a mesh of their own.
class ChangedCells {
 public:
  ChangedCells(const PartedCells& cells, const RestOfCells& rest, double level, const Context& context)
      : cells_(cells), rest_(rest), level_(level), context_(context) {
    require_memory();
    collect();
    take_nodes();
    join_sides();
  }

  [[nodiscard]] CellView view() const { return {t_, xy_, z1_, z2_, in_domain_, pieces_, bounds_of(cells_)}; }
  /// By node: of how many points of either scan it was made.
  [[nodiscard]] const std::vector<std::array<Index, 2>>& points() const { return points_; }
  /// Of all nodes of T.
  [[nodiscard]] double reach() const { return reach_; }

 private:
  template <class View>
  [[nodiscard]] bool exceeds(const View& view, const std::array<Index, 3>& v) const {
    return std::any_of(v.begin(), v.end(), [&](Index node) { return std::fabs(view.d(node)) > level_; });
  }
  [[nodiscard]] bool is_changed(const CellPart& part, std::size_t i) const { return exceeds(part, part.triangles[i]); }

  /// Before any memory is taken.
  void require_memory() const {
    context_.check();
    const std::size_t count = reduce_blocks<std::size_t>(
        cells_.in_parts(), default_block,
        [&](std::size_t begin, std::size_t end) {
          std::size_t some = 0;
          cells_.visit(begin, end, [&](const auto& view, std::size_t from, std::size_t to) {
            if constexpr (std::is_same_v<std::decay_t<decltype(view)>, CellPart>)
              for (std::size_t i = from; i < to; ++i) some += is_changed(view, i) ? 1 : 0;
          });
          return some;
        },
        [](std::size_t& total, std::size_t some) { total += some; });
    constexpr double bytes_a_cell = 400;  // the mesh, its sides while they are joined, objects and outlines
    const std::size_t all = count + cells_.rest().t.real;
    const auto needed = static_cast<std::uint64_t>(bytes_a_cell * static_cast<double>(all));
    if (needed <= usable_memory() && all < std::numeric_limits<Index>::max() / 4) return;
    throw InputError(fmt::format(
        "@changes: {} cells may differ by more than {}, and to join them to objects takes about {}, of which "
        "{} can be used: raise the level (@change-height, @lod), or leave @changes out",
        all, level_, bytes_in_words(needed), bytes_in_words(usable_memory())));
  }

  /// Cells of parts that change, cells of the rest that do or are cut.
  void collect() {
    numbers_ =
        gather_blocks<std::vector<Numbers>>(cells_.in_parts(), default_block, [&](std::size_t begin, std::size_t end) {
          std::vector<Numbers> some;
          for_numbered(cells_, rest_, begin, end, [&](const auto& view, std::size_t i, const auto& numbers) {
            if constexpr (std::is_same_v<std::decay_t<decltype(view)>, CellPart>)
              if (is_changed(view, i)) some.push_back(numbers);
          });
          return some;
        });
    in_domain_.assign(numbers_.size(), 1);
    const CellView& view = cells_.rest();
    std::vector<unsigned char> is_cut(view.t.real, 0);
    for (const CellPiece& piece : view.pieces) is_cut[piece.cell] = 1;
    std::vector<Index> place(view.t.real, no_index);
    for (std::size_t i = 0; i < view.t.real; ++i) {
      const std::array<Index, 3> v = view.corners(i);
      const bool is_whole = view.in_domain[i] != 0;
      if (is_cut[i] == 0 && !(is_whole && exceeds(view, v))) continue;
      place[i] = static_cast<Index>(numbers_.size());
      of_rest_.push_back(static_cast<Index>(i));
      numbers_.push_back({rest_.number[v[0]], rest_.number[v[1]], rest_.number[v[2]]});
      in_domain_.push_back(is_whole ? 1 : 0);
    }
    for (const CellPiece& piece : view.pieces) pieces_.push_back({place[piece.cell], piece.at});
  }

  /// Nodes keep their order on the curve.
  void take_nodes() {
    for (const Numbers& cell : numbers_) nodes_.insert(nodes_.end(), cell.begin(), cell.end());
    std::sort(nodes_.begin(), nodes_.end());
    nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
    xy_.resize(nodes_.size()), z1_.resize(nodes_.size()), z2_.resize(nodes_.size());
    points_.resize(nodes_.size());
    cells_.for_parts([&](const CellPart& part) { take_nodes_of(part); });
    // Heights at corners of cells that are not final are known to the rest alone, as those of final ones are to parts.
    const CellView& view = cells_.rest();
    for (const Index i : of_rest_)
      for (const Index v : view.t.triangles[i].v) {
        const Index node = find(rest_.number[v]);
        z1_[node] = view.z1[v], z2_[node] = view.z2[v];
      }
  }
  void take_nodes_of(const CellPart& part) {
    context_.check();
    reach_ = std::max(reach_, reach_of(part.xy));
    const auto end = std::lower_bound(nodes_.begin(), nodes_.end(), part.first_node + part.xy.size());
    for (auto at = std::lower_bound(nodes_.begin(), nodes_.end(), part.first_node); at != end; ++at) {
      const std::size_t node = static_cast<std::size_t>(at - nodes_.begin()), of_part = *at - part.first_node;
      xy_[node] = part.xy[of_part], z1_[node] = part.z1[of_part], z2_[node] = part.z2[of_part];
      points_[node] = part.points[of_part];
    }
  }
  [[nodiscard]] Index find(std::size_t number) const {
    const auto at = std::lower_bound(nodes_.begin(), nodes_.end(), number);
    return at != nodes_.end() && *at == number ? static_cast<Index>(at - nodes_.begin()) : no_index;
  }

  /// Whatever has no cell of the mesh beside it has a ghost there, one for all.
  void join_sides() {
    struct Side {
      std::array<Index, 2> ends;
      HalfEdge half_edge;
    };
    t_.real = static_cast<Index>(numbers_.size()), t_.nodes = static_cast<Index>(nodes_.size());
    t_.triangles.resize(numbers_.size() + 1);
    const HalfEdge beyond = half_edge(t_.real, 0);
    t_.triangles.back() = {{no_index, no_index, no_index}, {beyond, beyond, beyond}};
    std::vector<Side> sides;
    sides.reserve(3 * numbers_.size());
    for (Index i = 0; i < t_.real; ++i) {
      Triangle& t = t_.triangles[i];
      for (Index k = 0; k < 3; ++k) t.v[k] = find(numbers_[i][k]), t.n[k] = beyond;
      for (Index k = 0; k < 3; ++k)
        sides.push_back({{std::min(t.v[k], t.v[next_side(k)]), std::max(t.v[k], t.v[next_side(k)])}, half_edge(i, k)});
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.ends < b.ends; });
    for (std::size_t i = 1; i < sides.size(); ++i) {
      if (sides[i - 1].ends != sides[i].ends) continue;
      const HalfEdge a = sides[i - 1].half_edge, b = sides[i].half_edge;
      t_.triangles[triangle_of(a)].n[side_of(a)] = b, t_.triangles[triangle_of(b)].n[side_of(b)] = a;
    }
  }

  const PartedCells& cells_;
  const RestOfCells& rest_;
  double level_;
  const Context& context_;
  std::vector<Numbers> numbers_;    // by cell
  std::vector<Index> of_rest_;      // triangles of the rest among them
  std::vector<std::size_t> nodes_;  // by node of the mesh: its number among all of T
  Triangulation t_;
  std::vector<Point2> xy_;
  std::vector<double> z1_, z2_;
  std::vector<unsigned char> in_domain_;
  std::vector<CellPiece> pieces_;
  std::vector<std::array<Index, 2>> points_;
  double reach_ = 0;
};

}  // namespace

void describe_level(const PartedCells& cells, Comparison& c, const Context& context) {
  const UncertaintyOptions& o = c.options.uncertainty;
  if (!(o.lod > 0)) return;
  c.uncertainty.deviations = normal_deviations(o.confidence);
  c.uncertainty.lod = o.lod;
  c.uncertainty.lod_is_given = true;
  c.uncertainty.detected = detect(cells, o.lod, context);
}

void describe_changes(const PartedCells& cells, const RestOfCells& rest, Comparison& c, const Context& context) {
  if (!c.options.changes.asked) return;
  const ChangeLevel level = stages::change_level(c);
  const ChangedCells changed(cells, rest, level.at(0), context);
  const CellView view = changed.view();
  FoundChanges found =
      find_changes(view, level, c.options.changes, stages::least_change_area(c), changed.reach(), context);
  const Array<Index> object_of = object_of_nodes(view, level, found);
  for (std::size_t node = 0; node < object_of.size(); ++node) {
    if (object_of[node] == no_index) continue;
    for (std::size_t k = 0; k < 2; ++k) found.changes.list[object_of[node]].points[k] += changed.points()[node][k];
  }
  c.changes = std::move(found.changes);
}

}  // namespace isopach
