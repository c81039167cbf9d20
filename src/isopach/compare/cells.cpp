// make_cells: the cells of the measure, and which of them lie in the domain.
#include <algorithm>
#include <optional>

#include "isopach/base/parallel.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/measure/volume/totals.hpp"
#include "isopach/overlay/rim.hpp"

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
        pair_(pair),
        in_{FootprintOfNodes(borders.in[0], g_.of_1, g_.of_2), FootprintOfNodes(borders.in[1], g_.of_2, g_.of_1)},
        at_node_(xy.size()) {
    if (borders.single)
      single_.emplace(std::array{FootprintOfNodes((*borders.single)[0], g_.of_1, g_.of_2),
                                 FootprintOfNodes((*borders.single)[1], g_.of_2, g_.of_1)});
    for_each_index(xy.size(), [&](std::size_t i) { at_node_[i] = flags_at(static_cast<Index>(i)); });
  }

  using Nodes = std::array<Index, 3>;
  [[nodiscard]] bool over_hull() const { return over_hull_; }
  [[nodiscard]] bool in_hulls(const Nodes& v) const { return over_hull_ || (of_all(v) & known_in_both) != 0; }
  /// A triangle of the interface, as UnitedNodes::joins.
  [[nodiscard]] bool joins(const Nodes& v) const { return (of_all(v) & (of_scan[0] | of_scan[1])) == 0; }
  [[nodiscard]] bool finds_folds() const { return single_.has_value(); }
  /// As Cells::scanned.
  [[nodiscard]] int scanned(const Nodes& v) const {
    if (anything_goes_) return 3;
    return (holds(0, v) ? 1 : 0) + (holds(1, v) ? 2 : 0);
  }
  /// A cell that borders run through.
  [[nodiscard]] RimCell rim_cell(const Nodes& v, std::span<const RimCrossing> across) const {
    RimCell cell{v, across};
    for (std::size_t scan = 0; scan < 2; ++scan) {
      const FootprintOfNodes& alone = single_ ? (*single_)[scan] : in_[scan];
      const auto bits = [&](bool hull, bool footprint, bool single) {
        return static_cast<unsigned char>(
            ((hull ? in_hull : 0) | (footprint ? in_footprint : 0) | (single ? in_single : 0)) << (extents * scan));
      };
      bool hull = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const bool known = in_hull_of(scan, v[k]);
        hull = hull && known;
        cell.outside[k] |= bits(!known, in_[scan].side(v[k]) == Side::outside, alone.side(v[k]) == Side::outside);
      }
      cell.in |= bits(hull, holds(scan, v), alone.holds(v, xy_));
    }
    return cell;
  }
  /// In the footprint of a scan, and not without its folds.
  [[nodiscard]] bool folded(const Nodes& v) const {
    if (!single_) return false;
    return (holds(0, v) && !(*single_)[0].holds(v, xy_)) || (holds(1, v) && !(*single_)[1].holds(v, xy_));
  }

 private:
  // What is asked of every cell, is found once for every node.
  static constexpr unsigned known_in_both = 1;
  static constexpr std::array<unsigned, 2> of_scan{2, 4}, inside_of{8, 16}, outside_of{32, 64};

  [[nodiscard]] unsigned char flags_at(Index node) const {
    unsigned flags = in_hull_of(0, node) && in_hull_of(1, node) ? known_in_both : 0;
    flags |= (g_.of_1[node] != no_index ? of_scan[0] : 0) | (g_.of_2[node] != no_index ? of_scan[1] : 0);
    for (std::size_t scan = 0; scan < 2; ++scan) {
      const Side side = in_[scan].side(node);
      flags |= (side == Side::inside ? inside_of[scan] : 0) | (side == Side::outside ? outside_of[scan] : 0);
    }
    return static_cast<unsigned char>(flags);
  }
  [[nodiscard]] unsigned of_all(const Nodes& v) const { return at_node_[v[0]] & at_node_[v[1]] & at_node_[v[2]]; }
  [[nodiscard]] unsigned of_any(const Nodes& v) const { return at_node_[v[0]] | at_node_[v[1]] | at_node_[v[2]]; }
  /// FootprintOfNodes::holds, which is asked where a corner lies on the rim alone.
  [[nodiscard]] bool holds(std::size_t scan, const Nodes& v) const {
    if ((of_all(v) & inside_of[scan]) != 0) return true;
    return (of_any(v) & outside_of[scan]) == 0 && in_[scan].holds(v, xy_);
  }
  [[nodiscard]] bool in_hull_of(std::size_t scan, Index node) const {
    const auto& own = scan == 0 ? g_.of_1 : g_.of_2;
    const auto& other = scan == 0 ? g_.of_2 : g_.of_1;
    return own[node] != no_index || inside(pair_.seen[1 - scan].at.kind[other[node]]);
  }

  const UnitedNodes& g_;
  std::span<const Point2> xy_;
  bool over_hull_, anything_goes_;
  const Pair& pair_;
  std::array<FootprintOfNodes, 2> in_;
  std::optional<std::array<FootprintOfNodes, 2>> single_;
  Array<unsigned char> at_node_;
};

/// What is found block by block: sums over what is no part of the domain for one reason or another, and the pieces of
/// cells that borders run through.
struct Found {
  Index interface = 0;
  VolumeSums trimmed, folded, single_in_folded;  ///< the folds are the second less the third
  std::vector<CellPiece> pieces;
  std::vector<std::array<Point2, 3>> scanned_parts;

  Found() = default;
  explicit Found(const SumScales& scales) : trimmed(scales), folded(scales), single_in_folded(scales) {}

  void add(const Found& part) {
    interface += part.interface;
    trimmed.add(part.trimmed), folded.add(part.folded), single_in_folded.add(part.single_in_folded);
    pieces.insert(pieces.end(), part.pieces.begin(), part.pieces.end());
    scanned_parts.insert(scanned_parts.end(), part.scanned_parts.begin(), part.scanned_parts.end());
  }
};

/// Sets in_domain and scanned of a block of cells.
class BlockOfCells {
 public:
  BlockOfCells(Cells& cells, const CellRules& rules, bool folds_left_out, const Domain& domain,
               std::span<const BorderSide> sides, const SumScales& scales)
      : found(scales),
        cells_(cells),
        view_(cells.view()),
        rules_(rules),
        folds_left_out_(folds_left_out),
        domain_(domain),
        sides_(sides),
        cutter_(cells.xy, cells.z1, cells.z2, sides) {}

  void judge(Index i, std::span<const RimCrossing> across) {
    const Nodes v = view_.corners(i);
    const int by = rules_.scanned(v);
    cells_.scanned[i] = static_cast<unsigned char>(by);
    if (!across.empty()) return cut(i, across);
    const bool in_hulls = rules_.in_hulls(v);
    const bool sampled = in_hulls && (rules_.over_hull() ? by != 0 : by == 3), in_fold = sampled && rules_.folded(v);
    cells_.in_domain[i] = sampled && !(in_fold && folds_left_out_) ? 1 : 0;
    if (in_hulls && !sampled) add_inside(found.trimmed, convex(view_, i));
    if (in_fold) add_inside(found.folded, convex(view_, i));
  }

  /// A cell that counts nowhere here.
  void leave_out(Index i) {
    cells_.in_domain[i] = 0;
    cells_.scanned[i] = 0;
  }

  Found found;

 private:
  using Pieces = std::vector<CellPiece>;
  using Nodes = std::array<Index, 3>;

  /// What of the cell lies in both footprints, once with the folds and once without, is measured by the rule for folds;
  /// the folds are the one less the other. With them no border of a fold cuts: it is a border of no scan.
  void cut(Index i, std::span<const RimCrossing> across) {
    of_scans_.clear();
    for (const RimCrossing& c : across)
      if ((sides_[c.side].of & ~of_both(in_single)) != 0) of_scans_.push_back(c);
    Pieces sampled, single;
    of_one_.clear();
    const bool whole = add_pieces(i, of_scans_, in_footprint, sampled, &found.trimmed);
    const bool whole_single = rules_.finds_folds() ? add_pieces(i, across, in_single, single, nullptr) : whole;
    if (rules_.finds_folds()) {
      for (const CellPiece& piece : sampled) add_inside(found.folded, convex(piece));
      for (const CellPiece& piece : single) add_inside(found.single_in_folded, convex(piece));
    }
    const bool without_folds = folds_left_out_ && rules_.finds_folds();
    cells_.in_domain[i] = (without_folds ? whole_single : whole) ? 1 : 0;
    const Pieces& measured = without_folds ? single : sampled;
    if (cells_.in_domain[i] != 0) return;
    found.pieces.insert(found.pieces.end(), measured.begin(), measured.end());
    note_scanned(i, sampled);
  }

  /// A cell that a border cuts may bridge a bay: its corners do not tell what of it was scanned.
  void note_scanned(Index i, const Pieces& of_both) {
    cells_.scanned[i] |= by_parts;
    found.scanned_parts.insert(found.scanned_parts.end(), of_one_.begin(), of_one_.end());
    for (const CellPiece& piece : of_both) found.scanned_parts.push_back(corners_of(piece));
  }
  static std::array<Point2, 3> corners_of(const CellPiece& p) {
    return {Point2{p.at[0].x, p.at[0].y}, Point2{p.at[1].x, p.at[1].y}, Point2{p.at[2].x, p.at[2].y}};
  }

  static constexpr unsigned char by_parts = 4;
  static unsigned of_both(unsigned extent) { return extent | extent << extents; }

  /// The parts of the cell in an extent of both scans; whether these are all of it. What lies in both hulls and not in
  /// the extent is added to `trimmed`.
  bool add_pieces(Index i, std::span<const RimCrossing> across, Extent extent, Pieces& added, VolumeSums* trimmed) {
    const RimCell cell = rules_.rim_cell(view_.corners(i), across);
    bool whole = true;
    const auto is_in = [](const RimPiece& p, unsigned of) { return (p.in & of_both(of)) == of_both(of); };
    const auto is_in_one = [](const RimPiece& p) { return (p.in & of_both(in_footprint)) != 0; };
    for (const RimPiece& piece : cutter_(cell)) {
      whole = whole && is_in(piece, extent);
      for (std::size_t k = 2; k < piece.corners.size(); ++k) {
        const CellPiece part = triangle_of(i, piece.corners[0], piece.corners[k - 1], piece.corners[k]);
        if (!(cell_of(part).area > 0)) continue;
        if (is_in(piece, extent))
          added.push_back(part);
        else if (trimmed != nullptr && is_in(piece, in_hull))
          add_inside(*trimmed, convex(part));
        if (extent == in_footprint && !is_in(piece, extent) && is_in_one(piece)) of_one_.push_back(corners_of(part));
      }
    }
    return whole;
  }

  static CellPiece triangle_of(Index cell, const RimCorner& a, const RimCorner& b, const RimCorner& c) {
    CellPiece piece{cell, {a, b, c}};
    for (std::size_t scan = 0; scan < 2; ++scan) piece.border[scan] = {a.border[scan], b.border[scan], c.border[scan]};
    return piece;
  }

  /// What of the cell the polygons and the mask leave.
  void add_inside(VolumeSums& part, const ConvexCell& cell) {
    domain_.for_pieces(cell, scratch_, [&](const ConvexCell& piece) {
      for_triangles(piece, [&](double area, const Corner& p, const Corner& q, const Corner& r) {
        part.add(Cell{area, {p.d(), q.d(), r.d()}});
      });
    });
  }

  Cells& cells_;
  CellView view_;
  const CellRules& rules_;
  bool folds_left_out_;
  const Domain& domain_;
  std::span<const BorderSide> sides_;
  RimCutter cutter_;
  std::vector<RimCrossing> of_scans_;
  std::vector<std::array<Point2, 3>> of_one_;  ///< parts of a cell in the footprint of one scan alone
  Domain::Scratch scratch_;
};

/// The borders of both scans, of nodes of T.
std::vector<BorderSide> sides_in_t(const Borders& borders, const UnitedNodes& g) {
  std::vector<BorderSide> sides;
  for (std::size_t scan = 0; scan < 2; ++scan) {
    if (borders.sides[scan].empty()) continue;
    const Array<Index>& of_scan = scan == 0 ? g.of_1 : g.of_2;
    Array<Index> in_t(borders.in[scan].own.side.size(), no_index);
    for_each_index(of_scan.size(), [&](std::size_t i) {
      if (of_scan[i] != no_index) in_t[of_scan[i]] = static_cast<Index>(i);
    });
    for (const BorderSide& s : borders.sides[scan])
      sides.push_back({in_t[s.from], in_t[s.to], static_cast<unsigned char>(s.of << (extents * scan))});
  }
  return sides;
}

/// A surface that is not linear may overshoot its nodes: then bounds are those of the cells.
CellView with_bounds(CellView cells, const Frame& frame, const CompareOptions& options) {
  if (options.interpolation == Interpolation::linear && !frame.box.empty()) cells.bounds = bounds_of(frame);
  return cells;
}

}  // namespace

CellView bounded_cells(const Comparison& c) { return with_bounds(c.cells.view(), c.frame, c.options); }

Cells make_cells(Common& common, const Pair& pair, const Borders& borders, const Domain& domain, Comparison& c,
                 const Context& context) {
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
  const std::vector<BorderSide> sides = sides_in_t(borders, common.nodes);
  const std::vector<RimCrossing> all_across = crossings(cells.triangulation, cells.xy, sides, context);
  common.bounds = bounds_of(with_bounds(cells.view(), pair.frame, c.options));
  const SumScales scales(common.bounds);
  Found found = reduce_blocks<Found>(
      cells.triangulation.real, default_block,
      [&](std::size_t begin, std::size_t end) {
        BlockOfCells block(cells, rules, borders.left_out, domain, sides, scales);
        const auto before = [](const RimCrossing& crossing, std::size_t cell) { return crossing.cell < cell; };
        auto next = std::lower_bound(all_across.begin(), all_across.end(), begin, before);
        for (std::size_t i = begin; i < end; ++i) {
          const auto first = next;
          while (next != all_across.end() && next->cell == i) ++next;
          if (!common.counted.empty() && common.counted[i] == 0) {
            block.leave_out(static_cast<Index>(i));
            continue;
          }
          block.judge(static_cast<Index>(i), {first, next});
          block.found.interface += rules.joins(cells.triangulation.triangles[i].v) ? 1 : 0;
        }
        return std::move(block.found);
      },
      [](Found& total, const Found& part) { total.add(part); });
  cells.pieces = std::move(found.pieces);
  cells.scanned_parts = std::move(found.scanned_parts);
  c.common = cells.triangulation.real;
  c.interface = found.interface;
  c.trimmed_area = found.trimmed.area.value();
  c.trimmed_volume = found.trimmed.volume().absolute;
  found.folded.subtract(found.single_in_folded);
  c.folds.area = found.folded.area.value();
  c.folds.volume = found.folded.volume();
  return cells;
}

}  // namespace isopach::stages
