// Comparison: everything one comparison found. Reports are written from it; nothing is computed after it.
#pragma once
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "isopach/compare/options.hpp"
#include "isopach/delaunay/triangulation.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/measure/changes/changes.hpp"
#include "isopach/measure/currents/currents.hpp"
#include "isopach/measure/measures.hpp"
#include "isopach/measure/uncertainty/noise_floor.hpp"
#include "isopach/measure/uncertainty/uncertainty.hpp"
#include "isopach/measure/volume/detail.hpp"
#include "isopach/overlay/overlay.hpp"

namespace isopach {

/// What the report says of one input.
struct InputSummary {
  std::string role, path, format, unit = "unknown", vertical_unit = "unknown", crs;
  std::size_t points = 0, nodes = 0;
  Cleaning cleaning;
  std::size_t nodata = 0;    ///< cells or points the file itself marks as no data (not among points)
  Box3 bounds;               ///< of the finite points, input coordinates (after the pose for B)
  double layered_share = 0;  ///< share of the area with several layers
};

/// The cells of the measure: the common triangulation T with d at its nodes.
struct Cells {
  Array<Point2> xy;                ///< nodes of T, frame coordinates
  Array<double> z1, z2;            ///< f̂1 and f̂2 at each node (clamped to the hull boundary outside it)
  Triangulation triangulation;     ///< T
  Array<unsigned char> in_domain;  ///< one flag per real triangle of T
  Array<unsigned char> scanned;    ///< per real triangle: 1 where A is sampled (its footprint, not its hull), + 2 where
                                   ///< B is, by its corners; + 4 where a border runs through it and the domain has not
                                   ///< all of it: scanned_parts tells what of it; empty: not known
  std::vector<std::array<Point2, 3>> scanned_parts;  ///< of these triangles: where at least one scan is sampled
  std::vector<CellPiece> pieces;   ///< of triangles that the domain holds a part of; their flag is not set
  Array<unsigned char> unclipped;  ///< the flags before polygons and mask cut; empty if nothing did
  Array<double> lod;               ///< level of detection at each node; empty if there is none

  [[nodiscard]] double d(Index node) const { return z2[node] - z1[node]; }
  [[nodiscard]] CellView view() const { return {triangulation, xy, z1, z2, in_domain, pieces}; }
};

/// Of every input point: d under it, against the other surface. NaN where dropped or outside the other surface.
struct PointFields {
  Array<double> dz_signed;  ///< B: own height − other surface; A: other surface − own height (so both mean B − A)
  Array<double> lod;        ///< level of detection at every input point, NaN as above; empty if there is none
  std::string lod_name;     ///< name of that field in files: "lod95" at a confidence of 0.95, "lod" where it was given
};

/// Both scans as currents: those of their triangles that the border keeps, over the overlap what of each lies over the
/// other scan.
struct CurrentsComparison {
  Currents sums;
  std::size_t triangles_a = 0, triangles_b = 0;
  [[nodiscard]] double distance() const { return std::sqrt(sums.rho); }  ///< unit²
  /// √(ρ / (‖A‖² + ‖B‖²)): 0 for the same current, 1 for two that have nothing in common, √2 for opposite ones.
  [[nodiscard]] double relative() const {
    const double norms = sums.norm_a2 + sums.norm_b2;
    return norms > 0 ? std::sqrt(sums.rho / norms) : 0;
  }
};

/// What the scans have of folds, overlay/folds.hpp.
struct FoldSummary {
  double share_a = 0, share_b = 0;  ///< of the area of each scan
  double area = 0;                  ///< of the cells over a fold of either scan: left out of the domain, or kept in it
  double share = 0;                 ///< area ÷ (domain with it)
  Volume volume;                    ///< of these cells
};

struct Timing {
  std::vector<std::pair<std::string, double>> stages;  ///< seconds, in running order
  double total = 0;
};

/// Volumes of one polygon, over its part of the domain.
struct BudgetRow {
  std::string name, file;
  bool restricts = false;    ///< of --include
  double polygon_area = 0;   ///< of the polygon itself
  double area = 0;           ///< of its part of the domain
  double coverage = 0;       ///< area / polygon_area
  double mean = 0, rho = 0;  ///< net and gross ÷ area; 0 without area
  Volume volume;
};

struct Comparison {
  CompareOptions options;
  Frame frame;
  InputSummary a, b;
  std::string unit = "unknown";  ///< of lengths in the result ("unknown" is never taken for metres)
  double domain_area = 0, area_union = 0, coverage = 0;
  Measures measures;                ///< over options.surface; over T for `both`
  std::optional<Measures> overlay;  ///< `both` alone: the sums over the exact overlay (see sum_up)
  Uncertainty uncertainty;
  std::optional<NoiseFloor> noise_floor;            ///< if options.noise_floor: of the common triangulation
  std::optional<Changes> changes;                   ///< if options.changes: over T
  std::vector<BudgetRow> budget;                    ///< options.area: over the surface of `measures`
  std::optional<WeightedMeasures> weighted;         ///< if options.weight; over the surface of `measures`
  std::optional<DetailMeasure> detail;              ///< ρ_dV; nothing where no triangle of the coarser scan counts
  std::optional<CurrentsComparison> currents;       ///< if options.measure is currents
  Index t1 = 0, t2 = 0, common = 0, interface = 0;  ///< numbers of triangles; interface: those with nodes of both scans
  std::uint64_t visited_1_in_2 = 0, visited_2_in_1 = 0;
  double trimmed_area = 0,
         trimmed_volume = 0;  ///< what options.border and max_edge left out: shares of the area and of the absolute
                              ///< volume that the hulls alone would give
  double sliver_area = 0,
         sliver_volume = 0;  ///< of long thin triangles along the border, shares of domain and of absolute volume
  FoldSummary folds;         ///< zeros where there are none, and where options.check_layers is not set
  Cells cells;
  OverlaySurface overlay_surface;  ///< options.keep_overlay: the cells of the exact overlay, frame coordinates
  Array<double> overlay_lod;       ///< level of detection at its vertices; empty if there is none
  PointFields fields_a, fields_b;  ///< empty unless options.keep_points
  std::array<std::size_t, 2> compared_points{};  ///< of A, of B: those at which there is a difference
  std::vector<std::string> warnings;
  Timing timing;
};

}  // namespace isopach
