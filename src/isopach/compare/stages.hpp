// The small print of the page: what is noted, checked and refused between its stages.
#pragma once
#include <chrono>
#include <optional>
#include <string>

#include "isopach/compare/comparison.hpp"
#include "isopach/compare/meshes.hpp"
#include "isopach/measure/clip.hpp"
#include "isopach/overlay/border.hpp"
#include "isopach/overlay/common.hpp"
#include "isopach/overlay/location.hpp"
#include "isopach/overlay/overlay.hpp"

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
void check_units(const Cloud& a, const Cloud& b, const CompareOptions& options, Comparison& c);

/// What the file says of itself and how many points it has.
[[nodiscard]] InputSummary summarise_file(const Cloud& cloud, const char* role);

void describe_inputs(const Cloud& cloud_a, const Cloud& cloud_b, const HeightField& a, const HeightField& b,
                     Comparison& c, const Context& context);

/// Counts of triangles and visits, areas of the hulls. Throws OverlapError where a scan covers no area that is asked
/// for.
void describe_meshes(const Triangulation& t1, const Triangulation& t2, const HeightField& a, const HeightField& b,
                     const Locations& a_in_2, const Locations& b_in_1, Comparison& c);

/// Of every node the largest difference of height of the points it was made of; empty where no points were merged,
/// where the user says which of them counts (min, max, first), and where folds are not asked for.
struct MergedSpreads {
  Array<double> a, b;
  bool raster_a = false,
       raster_b = false;  ///< rasters seen along z: one height a cell, so there is no fold to look for
};
[[nodiscard]] MergedSpreads merged_spreads(const Cloud& cloud_a, const Cloud& cloud_b, const HeightField& a,
                                           const HeightField& b, const Comparison& c);

/// The nodes of both scans against the footprints of both.
struct Borders {
  Array<unsigned char> kept_1, kept_2;      ///< one flag per real triangle: what is measured; empty if all are
  Margins in_1, in_2;                       ///< by the border alone
  double kept_area = 0, removed_area = 0;   ///< of the two footprints, added up, by the border alone
  Array<unsigned char> folded_1, folded_2;  ///< one flag per real triangle; empty if none is
  struct WithoutFolds {
    Margins in_1, in_2;
  };
  std::optional<WithoutFolds> single;  ///< if there are folds
  bool left_out = false;               ///< … and they are no part of the scans

  /// What is measured.
  [[nodiscard]] const Margins& measured_1() const { return left_out ? single->in_1 : in_1; }
  [[nodiscard]] const Margins& measured_2() const { return left_out ? single->in_2 : in_2; }
};
/// Flags with those of the folds added, so that they are of the border alone again.
[[nodiscard]] Array<unsigned char> with_folds(Array<unsigned char> kept, const Array<unsigned char>& folded);
/// What each scan supports of its hull, by options.border and options.max_edge, and without its folds where these are
/// to be left out. Sets c.folds.share_a and share_b.
[[nodiscard]] Borders find_borders(const Triangulation& t1, const Triangulation& t2, const HeightField& a,
                                   const HeightField& b, const Locations& a_in_2, const Locations& b_in_1,
                                   const MergedSpreads& spreads, Comparison& c, const Context& context);
/// Both scans as they are, with what the borders keep of them and what of that is folded.
[[nodiscard]] ScanMeshes meshes_of(const Comparison& c, const HeightField& a, const HeightField& b,
                                   const Triangulation& t1, const Triangulation& t2, const Borders& borders);

/// What the borders keep of each scan alone: one flag per real triangle; empty if all are.
void find_footprints(const Triangulation& t1, const Triangulation& t2, const HeightField& a, const HeightField& b,
                     const CompareOptions& options, Array<unsigned char>& kept_1, Array<unsigned char>& kept_2,
                     const Context& context);

/// sign −1: other surface − own height (A); +1: own height − other surface (B). NaN where there is none, and at the
/// nodes of `left_out`, one flag per node; empty if there are none.
[[nodiscard]] PointFields point_fields(const Cloud& cloud, const Pose& pose, const Frame& frame,
                                       const HeightField& field, const Margin& in_other, const Array<double>& other,
                                       int sign, const Array<unsigned char>& left_out);
/// The nodes of A and of B that lie in folds of their own scan alone, where folds are left out; empty if there are
/// none.
struct NodesLeftOut {
  Array<unsigned char> a, b;
};
[[nodiscard]] NodesLeftOut nodes_in_folds(const Borders& borders);

/// The common triangulation and its nodes.
struct Common {
  UnitedNodes nodes;
  Triangulation t;
};
/// By linear merging; T1 and T2 are used up.
[[nodiscard]] Common merge_common(Triangulation t1, Triangulation t2, const HeightField& a, const HeightField& b,
                                  const Locations& a_in_2, const Locations& b_in_1, const Frame& frame,
                                  const Context& context);

/// From scratch: needs no locations.
[[nodiscard]] Common triangulate_common(const HeightField& a, const HeightField& b, const Frame& frame,
                                        const Context& context);

/// T with both heights at its nodes, and which of its triangles lie in the domain. Sets c.trimmed_area and
/// c.trimmed_volume to what the borders took from it, in units of area and volume, and c.folds. Of the locations only
/// the kinds are read, of the fields the heights. With a clip what was trimmed counts inside it alone; it does not cut
/// here.
[[nodiscard]] Cells make_cells(Common common, HeightField a, HeightField b, const Locations& a_in_2,
                               const Locations& b_in_1, const Borders& borders, const Array<double>& f2_at_a,
                               const Array<double>& f1_at_b, const Clip* clip, Comparison& c);

/// Measures over the exact overlay of what the borders keep of both meshes, as options.surface asks for: all of them
/// into c.measures, or the sums into c.overlay.
void measure_overlay(const Overlay& overlay, const AreaOfInterest& area, Comparison& c, const Context& context);

/// ρ_dV into c.detail, inside the clip, if there is one. Throws OverlapError where there is none and options.measure
/// asks for it.
void measure_detail(const OverlayMesh& m1, const OverlayMesh& m2, const Clip* clip, Comparison& c,
                    const Context& context);

/// Area, coverage, shares trimmed and of long border triangles; throws OverlapError below options.min_coverage.
void describe_domain(const CellView& cells, const Borders& borders, Comparison& c);

}  // namespace isopach::stages
