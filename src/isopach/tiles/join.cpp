#include "isopach/tiles/join.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/delaunay/first_corner.hpp"
#include "isopach/measure/domain.hpp"
#include "isopach/overlay/pair.hpp"
#include "isopach/tiles/flags.hpp"
#include "isopach/tiles/parted_changes.hpp"
#include "isopach/tiles/parted_slivers.hpp"

namespace isopach {
namespace {

/// Triangles by the side that they begin with, which no other has this way round.
class TriangleTable {
 public:
  struct Row {
    Index first, second;
    unsigned char known;
  };
  void add(const Corners& v, unsigned char known) { rows_.push_back({v[0], v[1], known}); }
  void close() { std::sort(rows_.begin(), rows_.end(), before); }
  [[nodiscard]] const Row* find(const Corners& v) const {
    const auto at = std::lower_bound(rows_.begin(), rows_.end(), Row{v[0], v[1], 0}, before);
    return at != rows_.end() && at->first == v[0] && at->second == v[1] ? &*at : nullptr;
  }

 private:
  static bool before(const Row& a, const Row& b) { return std::tie(a.first, a.second) < std::tie(b.first, b.second); }
  std::vector<Row> rows_;
};

/// Gives the memory of arrays back that are not asked for again.
template <class... T>
void release(Array<T>&... arrays) {
  (Array<T>().swap(arrays), ...);
}

/// A triangle of the nodes passed up: one of the whole that a tile has found, one of the whole that none could find, or
/// none, where tiles kept the nodes in between to themselves.
enum class Origin : unsigned char { tile, here, nowhere };

class Joiner {
 public:
  Joiner(TilesToJoin tiles, Comparison& c, const Context& context)
      : tiles_(std::move(tiles)), c_(c), context_(context), clock_(c.timing, context) {}

  std::optional<Displacement> run() {
    clock_.start("delaunay");
    pair_.frame = c_.frame;
    for_both([&](std::size_t k) { take_nodes(k); });
    triangulate(pair_, context_);
    for_both([&](std::size_t k) { tell_known(k); });

    stages::Common common = stages::locate(pair_, LocateMethod::order, clock_, context_);
    const stages::SmoothSurfaces none = stages::interpolate(pair_, Interpolation::linear, context_);

    clock_.start("border");
    stages::describe_meshes(pair_, c_);
    count_triangles();
    const stages::Borders borders =
        stages::find_borders(pair_, std::move(spreads_), Domain::everything(), c_, context_);

    if (tiles_.heights != nullptr)
      for_both([&](std::size_t k) { (*tiles_.heights)[k] = heights_of_other(k, borders); });
    count_compared(borders);

    clock_.start("detail");
    measure_detail();

    clock_.start("merge");
    common = stages::unite_meshes(pair_, std::move(common), LocateMethod::order, none[0].has_value(), context_);
    choose_cells(common);
    c_.cells = stages::make_cells(common, pair_, borders, Domain::everything(), c_, context_);
    c_.common = static_cast<Index>(cells_), c_.interface = static_cast<Index>(joining_);

    clock_.start("measure");
    CellView rest = c_.cells.view();
    rest.bounds = common.bounds;
    const PartedCells cells(std::move(tiles_.cells), rest, cells_ + rest.pieces.size());
    c_.measures = measure(cells, context_, c_.options.percentiles);
    stages::describe_domain(borders, c_);
    const RestOfCells of_rest{common.counted, number_of(common.nodes)};
    describe_slivers(cells, of_rest, c_, context_);
    describe_level(cells, c_, context_);
    describe_changes(cells, of_rest, c_, context_);
    clock_.stop();
    if (tiles_.look) tiles_.look(cells);
    return displacement(cells, of_rest);
  }

 private:
  [[nodiscard]] std::optional<Displacement> displacement(const PartedCells& cells, const RestOfCells& of_rest) const {
    using Found = std::vector<DisplacementCorner>;
    std::size_t nodes = 0;
    for (const Part& part : tiles_.parts) nodes += part.nodes;
    const std::size_t step = displacement_step(nodes);
    const auto is_looked_at = [&](const std::array<std::size_t, 3>& n) {
      return n[0] % step == 0 || n[1] % step == 0 || n[2] % step == 0;
    };
    const std::size_t whole = cells.in_parts() + cells.rest().t.real;
    return plain_displacement(gather_blocks<Found>(whole, default_block,
                                                   [&](std::size_t begin, std::size_t end) {
                                                     Found some;
                                                     for_numbered(cells, of_rest, begin, end,
                                                                  [&](const auto& view, std::size_t i, const auto& n) {
                                                                    if (is_looked_at(n) && counts(view, i))
                                                                      add_corners(corners_of(view, i), n, step, some);
                                                                  });
                                                     return some;
                                                   }),
                              pair_.frame);
  }
  static bool counts(const CellPart&, std::size_t) { return true; }
  static bool counts(const CellView& cells, std::size_t i) { return cells.in_domain[i] != 0; }
  static std::array<Corner, 3> corners_of(const CellPart& part, std::size_t i) {
    std::array<Corner, 3> at{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Index v = part.triangles[i][k];
      at[k] = {part.xy[v].x, part.xy[v].y, part.z1[v], part.z2[v]};
    }
    return at;
  }
  static std::array<Corner, 3> corners_of(const CellView& cells, std::size_t i) {
    const CommonCell cell{cells, static_cast<Index>(i), nullptr};
    return {cell.corner(0), cell.corner(1), cell.corner(2)};
  }

  /// All nodes of scan k that were passed up: tiles come in curve order, so do these.
  void take_nodes(std::size_t k) {
    HeightField& field = pair_.scan[k].field;
    Array<double>& spread = spreads_[k].of_node;
    const bool merged = std::any_of(tiles_.parts.begin(), tiles_.parts.end(),
                                    [&](const Part& part) { return !part.scan[k].spread.empty(); });
    spreads_[k].is_raster = tiles_.is_raster[k];
    std::size_t first_in_t = 0;
    for (std::size_t tile = 0; tile < tiles_.parts.size(); ++tile) {
      ScanPart& part = tiles_.parts[tile].scan[k];
      first_[k].push_back(static_cast<Index>(field.xy.size()));
      field.xy.insert(field.xy.end(), part.xy.begin(), part.xy.end());
      field.z.insert(field.z.end(), part.z.begin(), part.z.end());
      Array<unsigned char>& asked = pair_.scan[k].asked.folds;
      asked.insert(asked.end(), part.asked.begin(), part.asked.end());
      if (merged && part.spread.empty())
        spread.insert(spread.end(), part.xy.size(), 0);
      else
        spread.insert(spread.end(), part.spread.begin(), part.spread.end());
      tile_of_[k].insert(tile_of_[k].end(), part.xy.size(), static_cast<Index>(tile));
      for (const Index node : part.in_t) number_[k].push_back(first_in_t + node);
      first_in_t += tiles_.parts[tile].nodes;
      pair_.scan[k].asked.kept_elsewhere.add(part.border_area);
      release(part.xy, part.z, part.spread, part.in_t, part.asked);
    }
    first_[k].push_back(static_cast<Index>(field.xy.size()));
    field.keys.resize(field.xy.size());
    for_each_index(field.xy.size(), [&](std::size_t i) { field.keys[i] = curve_key(pair_.frame.curve, field.xy[i]); });
  }

  [[nodiscard]] Origin origin(const TriangleTable::Row* row, const std::array<Index, 3>& tiles,
                              const std::array<Point2, 3>& at) const {
    if (row != nullptr) return Origin::tile;
    const bool in_one = tiles[0] == tiles[1] && tiles[0] == tiles[2];
    return in_one && disc_inside(at[0], at[1], at[2], tiles_.parts[tiles[0]].square) ? Origin::nowhere : Origin::here;
  }

  /// What of the triangles of scan k is asked.
  void tell_known(std::size_t k) {
    Scan& scan = pair_.scan[k];
    TriangleTable table;
    for (std::size_t tile = 0; tile < tiles_.parts.size(); ++tile) {
      ScanPart& part = tiles_.parts[tile].scan[k];
      const Index first = first_[k][tile];
      for (std::size_t i = 0; i < part.certified.size(); ++i) {
        const Corners& v = part.certified[i];
        table.add({v[0] + first, v[1] + first, v[2] + first}, part.known[i]);
      }
      release(part.certified, part.known);
    }
    table.close();
    Asked& asked = scan.asked;
    for (Array<unsigned char>* flags : {&asked.border, &asked.detail, &asked.area}) flags->resize(scan.t.real);
    found_here_[k] = reduce_blocks<std::uint64_t>(
        scan.t.real, default_block,
        [&](std::size_t begin, std::size_t end) {
          std::uint64_t here = 0;
          for (std::size_t i = begin; i < end; ++i) {
            const Corners v = from_first_corner(scan.t.triangles[i].v);
            const TriangleTable::Row* row = table.find(v);
            const Origin from = origin(row, {tile_of_[k][v[0]], tile_of_[k][v[1]], tile_of_[k][v[2]]},
                                       {scan.field.xy[v[0]], scan.field.xy[v[1]], scan.field.xy[v[2]]});
            const unsigned known = row != nullptr ? row->known : 0;
            const auto ask = [&](unsigned bit) {
              return static_cast<unsigned char>(from != Origin::nowhere && (known & bit) == 0 ? 1 : 0);
            };
            asked.border[i] = ask(border_known), asked.area[i] = ask(area_known), asked.detail[i] = ask(detail_known);
            here += from == Origin::here ? 1 : 0;
          }
          return here;
        },
        [](std::uint64_t& total, std::uint64_t part) { total += part; });
  }

  [[nodiscard]] std::vector<Array<double>> heights_of_other(std::size_t k, const stages::Borders& borders) const {
    const Array<unsigned char> compared = stages::compared_nodes(pair_, borders, k);
    std::vector<Array<double>> heights(tiles_.parts.size());
    for (std::size_t i = 0; i < compared.size(); ++i)
      heights[tile_of_[k][i]].push_back(compared[i] != 0 ? pair_.seen[k].z[i]
                                                         : std::numeric_limits<double>::quiet_NaN());
    return heights;
  }

  void count_triangles() {
    std::array<std::uint64_t, 2> real = found_here_;
    for (const Part& part : tiles_.parts)
      for (std::size_t k = 0; k < 2; ++k) real[k] += part.scan[k].triangles;
    c_.t1 = static_cast<Index>(real[0]), c_.t2 = static_cast<Index>(real[1]);
    c_.visited_1_in_2 = c_.visited_2_in_1 = 0;
  }

  /// Points with a difference, which the smallest object that is told depends on.
  void count_compared(const stages::Borders& borders) {
    for (std::size_t k = 0; k < 2; ++k) {
      const Array<unsigned char> is_compared = stages::compared_nodes(pair_, borders, k);
      std::size_t& count = c_.compared_points[k];
      for (std::size_t tile = 0; tile < tiles_.parts.size(); ++tile) {
        ScanPart& part = tiles_.parts[tile].scan[k];
        Index node = first_[k][tile];
        count += part.compared;
        for (const Index points : part.points) count += is_compared[node++] != 0 ? points : 0;
        release(part.points);
      }
    }
  }

  void measure_detail() {
    const SumBounds bounds = bounds_of(pair_.frame);
    std::array<DetailOfScan, 2> of;
    for (std::size_t k = 0; k < 2; ++k) {
      const OverlayMesh own = pair_.mesh(k), other = pair_.mesh(1 - k);
      of[k].area = kept_area(own, bounds, pair_.scan[k].asked.area);
      of[k].as_coarser =
          detail_sums(own, other, {false, Domain::everything(), bounds, pair_.scan[k].asked.detail}, context_);
      for (const Part& part : tiles_.parts) {
        of[k].area.add(part.scan[k].detail.area);
        of[k].as_coarser.add(part.scan[k].detail.as_coarser);
        of[k].nodes += part.scan[k].detail.nodes;
      }
    }
    c_.detail = detail_of(of[0], of[1]);
    stages::check_detail(Domain::everything(), c_);
  }

  /// Number of each node of T on the curve, among all.
  [[nodiscard]] std::vector<std::size_t> number_of(const UnitedNodes& nodes) const {
    std::vector<std::size_t> number(nodes.of_1.size());
    for_each_index(number.size(), [&](std::size_t i) {
      number[i] = nodes.of_1[i] != no_index ? number_[0][nodes.of_1[i]] : number_[1][nodes.of_2[i]];
    });
    return number;
  }

  /// The cells of T that no tile could finish.
  void choose_cells(stages::Common& common) {
    const UnitedNodes& g = common.nodes;
    std::array<Array<Index>, 2> in_t;
    for (std::size_t k = 0; k < 2; ++k) {
      in_t[k].assign(tile_of_[k].size(), no_index);
      const Array<Index>& of = k == 0 ? g.of_1 : g.of_2;
      for (std::size_t i = 0; i < of.size(); ++i)
        if (of[i] != no_index) in_t[k][of[i]] = static_cast<Index>(i);
    }
    TriangleTable open;
    for (std::size_t tile = 0; tile < tiles_.parts.size(); ++tile) {
      Part& part = tiles_.parts[tile];
      const Index of_a = first_[0][tile + 1] - first_[0][tile];
      for (const Corners& v : part.open) {
        Corners corners{};
        for (std::size_t c = 0; c < 3; ++c)
          corners[c] = v[c] < of_a ? in_t[0][first_[0][tile] + v[c]] : in_t[1][first_[1][tile] + v[c] - of_a];
        open.add(from_first_corner(corners), 0);
      }
      release(part.open);
      cells_ += part.cells, joining_ += part.joining;
    }
    open.close();
    common.counted.resize(common.t.real);
    const auto tile = [&](Index node) {
      return g.of_1[node] != no_index ? tile_of_[0][g.of_1[node]] : tile_of_[1][g.of_2[node]];
    };
    for (std::size_t i = 0; i < common.t.real; ++i) {
      const Corners v = from_first_corner(common.t.triangles[i].v);
      const Origin from =
          origin(open.find(v), {tile(v[0]), tile(v[1]), tile(v[2])}, {g.xy[v[0]], g.xy[v[1]], g.xy[v[2]]});
      common.counted[i] = from != Origin::nowhere ? 1 : 0;
      if (from != Origin::here) continue;
      ++cells_, joining_ += g.joins(v) ? 1 : 0;
    }
  }

  TilesToJoin tiles_;
  Comparison& c_;
  const Context& context_;
  stages::Clock clock_;
  Pair pair_;
  stages::MergedSpreads spreads_;
  std::array<std::vector<Index>, 2> first_;         // by tile: its first node; and their number
  std::array<std::vector<Index>, 2> tile_of_;       // by node
  std::array<std::vector<std::size_t>, 2> number_;  // by node: on the curve, among all nodes of T
  std::array<std::uint64_t, 2> found_here_{};       // triangles of the whole that no tile found
  std::uint64_t cells_ = 0, joining_ = 0;
};

}  // namespace

std::optional<Displacement> join_tiles(TilesToJoin tiles, Comparison& c, const Context& context) {
  std::optional<Displacement> found;
  run_with_threads(context, [&] { found = Joiner(std::move(tiles), c, context).run(); });
  return found;
}

}  // namespace isopach
