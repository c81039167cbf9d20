// CompareOptions: every option of a comparison with its default, unit and reason. Names are those of the command line.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/field/height_field.hpp"
#include "isopach/geom/polygons.hpp"
#include "isopach/geom/rigid.hpp"
#include "isopach/measure/changes/changes.hpp"
#include "isopach/measure/currents/currents.hpp"
#include "isopach/measure/uncertainty/uncertainty.hpp"
#include "isopach/measure/volume/weight.hpp"

namespace isopach {

/// Which cells the integral runs over: the triangles of T, the exact overlay of T1 and T2, or T with the overlay
/// beside.
enum class Surface { common, overlay, both };
/// What is told first: ρ_V, ρ_dV for scans of different detail (detail.hpp), or the distance as currents
/// (currents.hpp).
enum class MeasureKind { V, dV, currents };
enum class Interpolation { linear, cubic };  ///< of each scan between its nodes, see interpolate.hpp, smooth.hpp
enum class DomainKind { overlap, hull };
enum class BorderRule { trim, hull };
/// Places where a scan has several layers along the direction, see overlay/folds.hpp: no part of it, or measured as
/// they are triangulated.
enum class FoldRule { leave_out, keep };
enum class LocateMethod { tree, interface, order };  ///< the same answers, see localise*.hpp

/// What bounds the part of the plane that is measured, see domain.hpp; read by io/polygons.hpp. Default: nothing.
struct AreaOptions {
  std::vector<PolygonSet> include;  ///< their union is measured, and each polygon is a row of the budget
  std::vector<PolygonSet> exclude;  ///< their union is not
  std::vector<PolygonSet> budget;   ///< rows of the budget; what is measured stays as it is
  std::optional<Mask> mask;         ///< what lies outside is not measured
};

struct CompareOptions {
  ProjectOptions project;  ///< direction, duplicates, classes, crop
  Pose pose;               ///< applied to B before anything else; default identity
  Surface surface = Surface::common;
  MeasureKind measure = MeasureKind::V;  ///< V and dV are computed always, currents only if asked for
  CurrentsOptions currents;              ///< sigma in the unit of the scans, 0: five mean edges of the coarser scan
  Interpolation interpolation = Interpolation::linear;
  DomainKind domain = DomainKind::overlap;  ///< overlap: no value is extrapolated
  /// trim: only what the sampling supports, overlay/border.hpp; hull: the paper's.
  BorderRule border = BorderRule::trim;
  FoldRule folds = FoldRule::leave_out;  ///< asked only where check_layers is set
  bool keep_overlay = false;             ///< keep the cells of the overlay as a mesh, to be written; `common` has none
  bool keep_points = true;               ///< keep the difference at every input point, Comparison::fields_a, fields_b
  double max_edge = 0;                   ///< > 0: triangles of T1, T2 with a longer edge are no part of a scan; 0: none
  double alpha = 0;  ///< > 0: triangles of T1, T2 with a larger circumradius are no part of a scan; 0: none
  AreaOptions area;  ///< polygons and mask
  LocateMethod locate = LocateMethod::order;  ///< the fastest; tree is the algorithm as published
  WeightSource weight;                        ///< weighted measures beside the plain ones; default: none
  UncertaintyOptions uncertainty;             ///< default: nothing is said of it
  ChangeOptions changes;                      ///< connected regions of change as objects; default: none
  std::vector<double> percentiles;            ///< of |d|, beside percentile_levels: each between 0 and 100, by area
  bool noise_floor = false;  ///< estimate what an unchanged surface would show; takes longer than all the rest
  double min_coverage = 0;   ///< share; below it the run ends with exit 4. Default: any overlap will do
  std::string unit;          ///< overrides the unit of both inputs; empty = as in the files
  bool allow_crs = false;    ///< accept degrees, pseudo-Mercator, or two different CRS
  bool check_layers = true;  ///< look for several layers along the direction, and for folds
};

}  // namespace isopach
