// The small print of the page: what is noted, checked and refused between its stages.
#pragma once
#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "isopach/compare/comparison.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/overlay/border.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/location.hpp"
#include "isopach/overlay/overlay.hpp"
#include "isopach/overlay/pair.hpp"
#include "isopach/overlay/rim.hpp"
#include "isopach/overlay/smooth.hpp"

namespace isopach::stages {

class AreaOfInterest;  // domain.hpp

/// Wall-clock seconds of each stage, and its announcement.
class Clock {
 public:
  Clock(Timing& timing, const Context& context) : timing_(timing), context_(context) {}
  void start(const std::string& stage);
  void stop();

 private:
  using Time = std::chrono::steady_clock;
  Timing& timing_;
  const Context& context_;
  std::string stage_;
  Time::time_point since_;
};

/// Refuses options that contradict one another, and a longest edge that is no length.
void check_options(const CompareOptions& options);

/// Refuses degrees, pseudo-Mercator and differing CRS or units unless options.allow_crs; sets the unit of the result.
void check_units(const CloudView& a, const CloudView& b, const CompareOptions& options, Comparison& c);

/// What the file says of itself and how many points it has.
[[nodiscard]] InputSummary summarise_file(const CloudView& cloud, const char* role);

void describe_inputs(const CloudView& cloud_a, const CloudView& cloud_b, const Pair& pair, Comparison& c,
                     const Context& context);

/// Where a scan has several layers on much of its area.
void warn_of_layers(Comparison& c);

/// Counts of triangles and visits, areas of the hulls. Throws OverlapError where a scan covers no area that is asked
/// for.
void describe_meshes(const Pair& pair, Comparison& c);

/// The common triangulation and its nodes.
struct Common {
  UnitedNodes nodes;
  Triangulation t;
  SumBounds bounds{};              ///< of the cells, once they are made
  Array<unsigned char> counted{};  ///< by real triangle, of a part of T (tiles/): whether it is measured; empty: all
};
/// The nodes of each scan in the other, by `method`. By interface T is made on the way, and returned; otherwise nothing
/// is.
[[nodiscard]] Common locate(Pair& pair, LocateMethod method, Clock& clock, const Context& context);
/// T and its nodes, if `so_far` does not hold them, of T1 and T2, which are used up unless `keep_meshes`: by the tree
/// they are merged (theorem 2), by order that or something cheaper is done (triangulate_union).
[[nodiscard]] Common unite_meshes(Pair& pair, Common so_far, LocateMethod method, bool keep_meshes,
                                  const Context& context);

/// Both scans as smooth surfaces, where options.interpolation asks for them. They refer to the pair.
using SmoothSurfaces = std::array<std::optional<SmoothSurface>, 2>;
/// The height of each surface at the nodes of the other.
[[nodiscard]] SmoothSurfaces interpolate(Pair& pair, Interpolation interpolation, const Context& context);

/// Of every node the largest difference of height of the points it was made of; empty where no points were merged,
/// where the user says which of them counts (min, max, first), and where folds are not asked for.
struct MergedSpread {
  Array<double> of_node;
  bool is_raster = false;  ///< a raster seen along z: one height a cell, so there is no fold to look for
};
using MergedSpreads = std::array<MergedSpread, 2>;
/// Whether a raster that is posed is still one height a cell, seen in this frame.
[[nodiscard]] bool keeps_raster(const Frame& frame, const Pose& pose);
/// Whether spreads are asked for.
[[nodiscard]] bool asks_spreads(const CompareOptions& options);
[[nodiscard]] MergedSpreads merged_spreads(const CloudView& cloud_a, const CloudView& cloud_b, const Pair& pair,
                                           const CompareOptions& options);

/// The nodes of both scans against the footprints of both.
struct Borders {
  std::array<Margins, 2> in;                     ///< by the border alone
  double kept_area = 0, removed_area = 0;        ///< of the two footprints, added up, by the border alone
  std::optional<std::array<Margins, 2>> single;  ///< without folds, if there are any
  bool left_out = false;                         ///< … and they are no part of the scans
  std::array<std::vector<BorderSide>, 2> sides;  ///< that cells of T are cut along; empty over the hull

  /// What is measured.
  [[nodiscard]] const Margins& measured(std::size_t scan) const { return left_out ? (*single)[scan] : in[scan]; }
};
/// Flags with those of the folds added, so that they are of the border alone again.
[[nodiscard]] Array<unsigned char> with_folds(Array<unsigned char> kept, const Array<unsigned char>& folded);
/// What each scan supports of its hull, by options.border and options.max_edge, and without its folds where these are
/// to be left out: kept and folded of both scans. Sets c.folds.share_a and share_b.
/// Areas are those inside the domain.
[[nodiscard]] Borders find_borders(Pair& pair, const MergedSpreads& spreads, const Domain& domain, Comparison& c,
                                   const Context& context);
/// A copy of both scans, with all that the border keeps of them.
[[nodiscard]] Pair as_sampled(const Pair& pair);

/// What the border keeps of each scan alone.
void find_footprints(Pair& pair, const CompareOptions& options, const Context& context);

/// By node of scan k: whether its points have a difference: inside what is measured of the other scan, and not in folds
/// of its own scan alone, where folds are left out.
[[nodiscard]] Array<unsigned char> compared_nodes(const Pair& pair, const Borders& borders, std::size_t k);

/// Of A: other surface − own height, of B: own height − other surface, into c.fields_a and c.fields_b, if
/// options.keep_points asks for them. NaN where there is none, and at nodes that lie in folds of their own scan alone,
/// where folds are left out. Counts the others into c.compared_points.
void describe_points(const CloudView& cloud_a, const CloudView& cloud_b, const Pair& pair, const Borders& borders,
                     Comparison& c);

/// T with both heights at its nodes, and which of its triangles lie in the domain; `common` keeps the ids of its nodes
/// alone, and bounds of the cells. Cells that a border runs through are cut along it: their pieces are those of the
/// intersection of both footprints. Sets c.trimmed_area and c.trimmed_volume to what the borders took from the
/// intersection of the hulls, in units of area and volume, and c.folds. What was trimmed counts inside `domain` alone;
/// it does not cut here.
[[nodiscard]] Cells make_cells(Common& common, const Pair& pair, const Borders& borders, const Domain& domain,
                               Comparison& c, const Context& context);

/// c.cells with the bounds of all that they may be a part of, so that sums over parts go together.
[[nodiscard]] CellView bounded_cells(const Comparison& c);

/// Measures over the exact overlay of what the borders keep of both meshes, as options.surface asks for: all of them
/// into c.measures, or the sums into c.overlay.
void measure_overlay(const OverlayCells& cells, const AreaOfInterest& area, Comparison& c, const Context& context);

/// ρ_dV into c.detail, inside the domain. Throws OverlapError where there is none and options.measure
/// asks for it.
void measure_detail(const Pair& pair, const Domain& domain, Comparison& c, const Context& context);
/// Throws that OverlapError.
void check_detail(const Domain& domain, const Comparison& c);

/// Area, coverage, shares trimmed; throws OverlapError below options.min_coverage.
void describe_domain(const Borders& borders, Comparison& c);

}  // namespace isopach::stages
