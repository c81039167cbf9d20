#include "isopach/tiles/solve.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/delaunay/first_corner.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/measure/domain.hpp"
#include "isopach/overlay/border.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/folds.hpp"
#include "isopach/overlay/interpolate.hpp"
#include "isopach/overlay/localise.hpp"
#include "isopach/overlay/pair.hpp"
#include "isopach/overlay/rim.hpp"
#include "isopach/tiles/beyond.hpp"
#include "isopach/tiles/flags.hpp"

namespace isopach {
namespace {

using Kind = Location::Kind;

/// What is known of one scan from its own triangulation.
struct OwnKnowledge {
  Flags certified, border, settled;  // by real triangle: each holds the next
  Flags frontier;                    // by node: on a triangle that is not certified
  Flags unsettled;                   // by node: on one that is not settled
  Flags asked;                       // by node: may be covered
  Flags around;                      // by node: needed to find again what is not known of the others
};

class OwnFinder {
 public:
  OwnFinder(const Scan& scan, const TileScan& input, const OpenBox& square, const CompareOptions& options,
            const Context& context)
      : t_(scan.t), field_(scan.field), input_(input), square_(square), options_(options), context_(context) {}

  [[nodiscard]] OwnKnowledge find() const {
    OwnKnowledge k;
    k.certified = certified_triangles(t_, field_.xy, square_);
    k.frontier = nodes_beside(t_, k.certified);
    const bool trims = options_.border == BorderRule::trim;
    const Flags near = trims ? with_neighbours(t_, k.frontier) : Flags(t_.nodes, 0);
    const Flags plain = plainly_kept(t_, field_.xy, trims, {options_.max_edge, options_.alpha}, context_);
    k.border = kept_where(t_, k.certified, [&](std::size_t i, const Corners& v) {
      return plain[i] != 0 && (near[v[0]] | near[v[1]] | near[v[2]]) == 0;
    });
    const Flags beside = nodes_beside(t_, k.border);
    if (!options_.check_layers || input_.is_raster) {
      k.asked = Flags(t_.nodes, 0);
      k.settled = k.border;
      k.around = trims ? with_neighbours(t_, with_neighbours(t_, beside)) : beside;
    } else {
      k.asked = may_be_covered(with_neighbours(t_, with_neighbours(t_, beside)));
      const Flags near_asked = with_neighbours(t_, k.asked);
      k.settled = kept_where(t_, k.border, [&](std::size_t, const Corners& v) {
        return (near_asked[v[0]] | near_asked[v[1]] | near_asked[v[2]]) == 0;
      });
      k.around = with_neighbours(t_, with_neighbours(t_, near_asked));
    }
    k.unsettled = nodes_beside(t_, k.settled);
    return k;
  }

 private:
  /// `unknown`: nodes about which it cannot be said here.
  [[nodiscard]] Flags may_be_covered(Flags unknown) const {
    Flags asked(t_.nodes);
    for (std::size_t i = 0; i < asked.size(); ++i) asked[i] = unknown[i] == 0 ? 1 : 0;
    const Flags cover = nodes_covered(t_, field_.xy, field_.z, input_.spread, {asked}, context_);
    for (std::size_t i = 0; i < asked.size(); ++i) unknown[i] = unknown[i] != 0 || cover[i] != 0 ? 1 : 0;
    return unknown;
  }

  const Triangulation& t_;
  const HeightField& field_;
  const TileScan& input_;
  const OpenBox& square_;
  const CompareOptions& options_;
  const Context& context_;
};

/// f(triangle) for the triangles of t that a located point touches, ghosts included; none for one that is outside.
template <class F>
void for_touching(const Triangulation& t, const Array<HalfEdge>& leaving, const Location& at, F&& f) {
  if (at.kind == Kind::triangle) f(at.id);
  if (at.kind == Kind::edge) f(triangle_of(at.id)), f(triangle_of(t.twin(at.id)));
  if (at.kind != Kind::node || leaving[at.id] == no_index) return;
  HalfEdge h = leaving[at.id];
  do {
    f(triangle_of(h));
    h = t.next_leaving(h);
  } while (h != leaving[at.id]);
}

class TileSolver {
 public:
  TileSolver(TileInput input, const CompareOptions& options, const Context& context)
      : input_(std::move(input)), options_(options), context_(context) {
    pair_.frame = input_.frame;
    for (std::size_t k = 0; k < 2; ++k) pair_.scan[k].field = std::move(input_.scan[k].field);
  }

  SolvedTile run() {
    triangulate(pair_, context_);
    for_both([&](std::size_t k) {
      own_[k] = OwnFinder(pair_.scan[k], input_.scan[k], input_.square, options_, context_).find();
      leaving_[k] = leaving_nodes(pair_.scan[k].t);
    });
    for_both([&](std::size_t k) { see(k); });
    unite();
    judge_cells();
    for_both([&](std::size_t k) { judge_detail(k); });
    SolvedTile solved;
    fill(solved.part);
    fill(solved.cells);
    return solved;
  }

 private:
  [[nodiscard]] const Triangulation& mesh(std::size_t k) const { return pair_.scan[k].t; }
  [[nodiscard]] std::span<const Point2> places(std::size_t k) const { return pair_.scan[k].field.xy; }

  /// The nodes of scan k in the other one.
  void see(std::size_t k) {
    const Triangulation& other = mesh(1 - k);
    Seen& seen = pair_.seen[k];
    seen.at = localise_in_order(places(k), other, places(1 - k), context_);
    seen.z = interpolate(seen.at, places(k), other, places(1 - k), pair_.scan[1 - k].field.z, context_);
    known_[k].resize(places(k).size());
    for_each_index(places(k).size(), [&](std::size_t i) {
      bool is_known = own_[k].unsettled[i] == 0 && touches_real(seen.at[i], other);
      for_touching(other, leaving_[1 - k], seen.at[i],
                   [&](Index t) { is_known = is_known && !other.is_ghost(t) && own_[1 - k].settled[t] != 0; });
      known_[k][i] = is_known ? 1 : 0;
    });
    beyond_[k] = sides_beyond(input_.scan[1 - k].hull, places(k));
    wanted_[k] = own_[k].frontier;
  }
  static bool touches_real(const Location& at, const Triangulation& t) {
    return t.real > 0 && (at.kind == Kind::triangle || at.kind == Kind::edge || at.kind == Kind::node);
  }

  void unite() {
    const HeightField &a = pair_.scan[0].field, &b = pair_.scan[1].field;
    nodes_ = isopach::unite(CurveNodes{a.xy, a.keys}, CurveNodes{b.xy, b.keys});
    t_ = triangulate(nodes_.xy, pair_.frame.curve, context_);
    certified_ = certified_triangles(t_, nodes_.xy, input_.square);
  }

  [[nodiscard]] const Array<Index>& of(std::size_t k) const { return k == 0 ? nodes_.of_1 : nodes_.of_2; }
  [[nodiscard]] bool is_known(Index node) const {
    for (std::size_t k = 0; k < 2; ++k)
      if (const Index i = of(k)[node]; i != no_index && known_[k][i] == 0) return false;
    return true;
  }

  /// Which cells are final, and by which nodes the others are found again.
  void judge_cells() {
    Flags known = kept_where(t_, certified_, [&](std::size_t, const Corners& v) {
      return is_known(v[0]) && is_known(v[1]) && is_known(v[2]);
    });
    for (const RimCrossing& c : crossings(t_, nodes_.xy, unsettled_sides(), context_)) known[c.cell] = 0;
    // A final cell has no neighbour that may turn out to lie outside: no border is beside it.
    final_ = known;
    for_each_index(t_.real, [&](std::size_t i) {
      for (const HalfEdge h : t_.triangles[i].n)
        if (t_.is_ghost(triangle_of(h)) || known[triangle_of(h)] == 0) final_[i] = 0;
    });
    dropped_ = cells_to_drop();
    for (std::size_t i = 0; i < t_.triangles.size(); ++i) {
      if (i < t_.real && (final_[i] != 0 || dropped_[i] != 0)) continue;
      for (const Index v : t_.triangles[i].v)
        if (v != no_index) want(v);
    }
  }
  /// Cells beyond the hull of a scan, as their neighbours are: no sum knows of them, and no border is beside them.
  [[nodiscard]] Flags cells_to_drop() const {
    const Flags beyond = kept_where(
        t_, certified_, [&](std::size_t, const Corners& v) { return beyond_one_side(0, v) || beyond_one_side(1, v); });
    return kept_where(t_, beyond, [&](std::size_t i, const Corners&) {
      const auto& sides = t_.triangles[i].n;
      return std::all_of(sides.begin(), sides.end(),
                         [&](HalfEdge h) { return !t_.is_ghost(triangle_of(h)) && beyond[triangle_of(h)] != 0; });
    });
  }
  /// Whether three nodes of scan k lie beyond one side of the hull of the other.
  [[nodiscard]] bool beyond_one_side(std::size_t k, const Corners& v) const {
    std::uint64_t shared = ~std::uint64_t{0};
    for (const Index node : v) {
      const Index i = of(k)[node];
      shared &= i != no_index ? beyond_[k][i] : 0;
    }
    return shared != 0;
  }
  void want(Index node) {
    for (std::size_t k = 0; k < 2; ++k)
      if (const Index i = of(k)[node]; i != no_index) wanted_[k][i] = 1;
  }

  /// Where what is settled of a scan ends, as sides between nodes of T.
  [[nodiscard]] std::vector<BorderSide> unsettled_sides() const {
    std::vector<BorderSide> sides;
    for (std::size_t k = 0; k < 2; ++k) {
      const Triangulation& t = mesh(k);
      Array<Index> in_t(t.nodes, no_index);
      for (std::size_t i = 0; i < of(k).size(); ++i)
        if (of(k)[i] != no_index) in_t[of(k)[i]] = static_cast<Index>(i);
      for (Index i = 0; i < t.real; ++i) {
        if (own_[k].settled[i] == 0) continue;
        for (Index s = 0; s < 3; ++s) {
          const Index beyond = triangle_of(t.triangles[i].n[s]);
          if (t.is_ghost(beyond) || own_[k].settled[beyond] == 0)
            sides.push_back({in_t[t.triangles[i].v[s]], in_t[t.triangles[i].v[next_side(s)]], 1});
        }
      }
    }
    return sides;
  }

  /// Which triangles of scan k count in ρ_dV as they stand, if it is the coarser one, and by which nodes the others are
  /// found again.
  void judge_detail(std::size_t k) {
    const Triangulation& t = mesh(k);
    const Locations& fine = pair_.seen[1 - k].at;
    counts_[k] = kept_where(t, own_[k].settled, [&](std::size_t, const Corners& v) {
      return known_[k][v[0]] != 0 && known_[k][v[1]] != 0 && known_[k][v[2]] != 0;
    });
    // Those with a corner beyond the other scan count nowhere.
    const Flags nowhere = kept_where(t, own_[k].certified, [&](std::size_t, const Corners& v) {
      return (beyond_[k][v[0]] | beyond_[k][v[1]] | beyond_[k][v[2]]) != 0;
    });
    for (std::size_t q = 0; q < fine.size(); ++q) {  // a node without its area, or whose shares are not known
      bool is_clear = own_[1 - k].unsettled[q] == 0;
      for_touching(t, leaving_[k], fine[q],
                   [&](Index i) { is_clear = is_clear && !t.is_ghost(i) && own_[k].settled[i] != 0; });
      if (is_clear) continue;
      for_touching(t, leaving_[k], fine[q], [&](Index i) {
        if (!t.is_ghost(i)) counts_[k][i] = 0;
      });
    }
    const Flags settled = kept_where(
        t, own_[k].certified, [&](std::size_t i, const Corners&) { return counts_[k][i] != 0 || nowhere[i] != 0; });
    open_fine_[1 - k] = Flags(fine.size(), 0);
    for (std::size_t q = 0; q < fine.size(); ++q) {
      if (beyond_[1 - k][q] != 0) continue;
      bool all = touches_real(fine[q], t);
      for_touching(t, leaving_[k], fine[q], [&](Index i) { all = all && !t.is_ghost(i) && settled[i] != 0; });
      if (!all) open_fine_[1 - k][q] = 1;
    }
    open_coarse_[k] = nodes_beside(t, settled);
  }

  /// Nodes of scan k to pass up.
  [[nodiscard]] Flags passed_up(std::size_t k) const {
    const Triangulation& own = mesh(k);
    Flags up = own_[k].around;
    const auto add = [&](const Flags& more) {
      for (std::size_t i = 0; i < up.size(); ++i) up[i] = up[i] != 0 || more[i] != 0 ? 1 : 0;
    };
    add(wanted_[k]);
    add(with_neighbours(own, open_fine_[k]));
    add(with_neighbours(own, open_coarse_[k]));
    // The triangles that wanted nodes of the other scan lie in.
    const Locations& seen = pair_.seen[1 - k].at;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (wanted_[1 - k][i] == 0 && open_fine_[1 - k][i] == 0 && open_coarse_[1 - k][i] == 0) continue;
      const Location at = seen[i];
      if (at.kind == Kind::node) up[at.id] = 1;
      if (at.kind != Kind::triangle && at.kind != Kind::edge) continue;
      for_touching(own, leaving_[k], at, [&](Index t) {
        for (const Index v : own.triangles[t].v)
          if (v != no_index) up[v] = 1;
      });
    }
    return up;
  }

  void fill(Part& part) const {
    part.square = input_.square;
    part.nodes = nodes_.xy.size();
    std::array<Array<Index>, 2> id;
    for (std::size_t k = 0; k < 2; ++k) id[k] = fill(part.scan[k], k);
    const auto offset = static_cast<Index>(part.scan[0].xy.size());
    for (std::size_t i = 0; i < t_.real; ++i) {
      if (certified_[i] == 0) continue;
      ++part.cells;
      const Corners v = from_first_corner(t_.triangles[i].v);
      part.joining += nodes_.joins(v) ? 1 : 0;
      if (final_[i] != 0 || dropped_[i] != 0) continue;
      Corners open{};
      for (std::size_t c = 0; c < 3; ++c) {
        const Index a = nodes_.of_1[v[c]], b = nodes_.of_2[v[c]];
        open[c] = a != no_index ? id[0][a] : offset + id[1][b];
      }
      part.open.push_back(open);
    }
  }

  /// Gives the number of each node among those passed up.
  Array<Index> fill(ScanPart& part, std::size_t k) const {
    const Scan& scan = pair_.scan[k];
    const Flags up = passed_up(k);
    const bool knows_points = !input_.scan[k].points.empty();
    Array<Index> id(up.size(), no_index), in_t(up.size(), no_index);
    for (std::size_t i = 0; i < of(k).size(); ++i)
      if (of(k)[i] != no_index) in_t[of(k)[i]] = static_cast<Index>(i);
    for (std::size_t i = 0; i < up.size(); ++i) {
      if (up[i] == 0) continue;
      id[i] = static_cast<Index>(part.xy.size());
      part.xy.push_back(scan.field.xy[i]), part.z.push_back(scan.field.z[i]), part.in_t.push_back(in_t[i]);
      part.asked.push_back(own_[k].asked[i]);
      if (!input_.scan[k].spread.empty()) part.spread.push_back(input_.scan[k].spread[i]);
      if (knows_points) part.points.push_back(known_[k][i] != 0 ? 0 : input_.scan[k].points[i]);
    }
    if (knows_points)
      for (std::size_t i = 0; i < up.size(); ++i) part.compared += known_[k][i] != 0 ? input_.scan[k].points[i] : 0;
    const SumBounds bounds = bounds_of(input_.frame);
    part.border_area = kept_area(all_of(k), bounds, own_[k].border);
    part.detail.nodes = part.nodes = scan.field.xy.size();
    part.detail.area = kept_area(all_of(k), bounds, own_[k].settled);
    part.detail.as_coarser =
        detail_sums(all_of(k), all_of(1 - k), {false, Domain::everything(), bounds, counts_[k]}, context_);
    part.cleaning = scan.field.cleaning;
    part.layers.add_nodes(scan.field.keys);
    for (std::size_t i = 0; i < scan.t.real; ++i) {
      if (own_[k].certified[i] == 0) continue;
      ++part.triangles;
      const Corners v = from_first_corner(scan.t.triangles[i].v);
      if (up[v[0]] == 0 || up[v[1]] == 0 || up[v[2]] == 0) continue;
      part.certified.push_back({id[v[0]], id[v[1]], id[v[2]]});
      part.known.push_back(static_cast<unsigned char>((own_[k].border[i] != 0 ? border_known : 0) |
                                                      (own_[k].settled[i] != 0 ? area_known : 0) |
                                                      (counts_[k][i] != 0 ? detail_known : 0)));
    }
    return id;
  }
  [[nodiscard]] OverlayMesh all_of(std::size_t k) const { return pair_.mesh(k); }

  /// At a node of scan k; of one that is in both scans it is the height of the other's node.
  [[nodiscard]] double height_of_other(std::size_t k, Index node) const {
    return known_[k][node] != 0 ? pair_.seen[k].z[node] : std::numeric_limits<double>::quiet_NaN();
  }

  void fill(FinalCells& cells) {
    const std::size_t n = nodes_.xy.size();
    cells.z1.resize(n), cells.z2.resize(n);
    for_each_index(n, [&](std::size_t i) {
      const Index a = nodes_.of_1[i], b = nodes_.of_2[i];
      cells.z1[i] = b != no_index ? height_of_other(1, b) : pair_.scan[0].field.z[a];
      cells.z2[i] = a != no_index ? height_of_other(0, a) : pair_.scan[1].field.z[b];
    });
    if (options_.changes.asked) {
      cells.points.resize(n);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < 2; ++k)
          cells.points[i][k] = of(k)[i] != no_index ? input_.scan[k].points[of(k)[i]] : 0;
    }
    cells.xy = std::move(nodes_.xy);
    for (std::size_t i = 0; i < t_.real; ++i)
      if (final_[i] != 0) cells.triangles.push_back(from_first_corner(t_.triangles[i].v));
  }

  TileInput input_;
  const CompareOptions& options_;
  const Context& context_;
  Pair pair_;
  std::array<OwnKnowledge, 2> own_;
  std::array<Array<HalfEdge>, 2> leaving_;
  std::array<Flags, 2> known_;                  // by node: its height in the other scan, and that it lies inside both
  std::array<Flags, 2> wanted_;                 // by node: corners of cells that are not final
  std::array<Flags, 2> counts_;                 // by real triangle: its part in ρ_dV is final
  std::array<Flags, 2> open_fine_;              // by node: in a triangle of the other scan whose part is not
  std::array<Flags, 2> open_coarse_;            // by node: on such a triangle of its own scan
  std::array<Array<std::uint64_t>, 2> beyond_;  // by node: as sides_beyond of the other scan's hull
  UnitedNodes nodes_;
  Triangulation t_;
  Flags certified_, final_, dropped_;  // by real triangle of T
};

}  // namespace

void check_tiled(const CompareOptions& o) {
  const auto refuse = [](const char* option, const char* why) {
    throw UsageError(std::string("@") + option + ": a comparison by tiles cannot have it: " + why);
  };
  if (o.surface != Surface::common) refuse("surface", "take common");
  if (o.measure == MeasureKind::currents) refuse("measure", "take V or dV");
  if (o.interpolation != Interpolation::linear) refuse("interpolation", "take linear");
  if (o.domain != DomainKind::overlap) refuse("domain", "take overlap");
  if (o.weight.kind != WeightSource::Kind::none) refuse("weight", "leave it out");
  if (o.noise_floor) refuse("noise-floor", "leave it out");
  if (o.uncertainty.model != UncertaintyModel::none) refuse("uncertainty-model", "leave it out");
  if (o.uncertainty.sigma1.kind != SigmaSource::Kind::none)
    refuse("sigma1", "give the level of detection itself by @lod, or leave the sigmas out");
  if (!o.area.include.empty()) refuse("include", "leave it out");
  if (!o.area.exclude.empty()) refuse("exclude", "leave it out");
  if (!o.area.budget.empty()) refuse("budget", "leave it out");
  if (o.area.mask) refuse("mask", "leave it out");
}

SolvedTile solve_tile(TileInput input, const CompareOptions& options, const Context& context) {
  return TileSolver(std::move(input), options, context).run();
}

}  // namespace isopach
