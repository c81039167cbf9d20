// distance(a, b, options): distances between two scans as points and as surfaces in space, where `compare` measures
// along one direction over an area. See docs/use/distance.md.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "isopach/compare/comparison.hpp"
#include "isopach/distance/hausdorff.hpp"
#include "isopach/distance/m3c2.hpp"
#include "isopach/distance/mesh.hpp"
#include "isopach/distance/surface_figures.hpp"

namespace isopach {

/// What to measure.
struct DistanceMeasures {
  bool c2c = false;        ///< to the nearest point of the other scan
  bool c2s = false;        ///< to the closest point of the other scan's surface
  bool normal = false;     ///< along the normal of the other surface, at the facet under the point (after Schenk)
  bool vertical = false;   ///< along the direction
  bool surface = false;    ///< mean and rms over the area of one surface of the distance to the other (Metro)
  bool hausdorff = false;  ///< the largest such distance, between two bounds
  bool m3c2 = false;
};

struct DistanceOptions {
  ProjectOptions project;
  Pose pose;  ///< applied to B before anything else
  DistanceMeasures measures;
  MeshSource mesh = MeshSource::automatic;
  BorderRule border = BorderRule::trim;  ///< of Delaunay surfaces, overlay/border.hpp
  double max_edge = 0;                   ///< > 0: no triangle of them with a longer edge in x and y
  double tolerance = 0;                  ///< of the Hausdorff distance; 0: a millionth of the diagonal of both scans
  std::size_t samples = 10;              ///< of the surface measure: at least, per triangle on average
  M3c2Options m3c2;
  std::string unit;
  bool allow_crs = false;
};

/// Of the sizes |d| of many distances. Zeros where there is none.
struct Figures {
  std::size_t count = 0, missing = 0;  ///< missing: points without a distance
  double mean = 0, rms = 0, max = 0, median = 0, p95 = 0;
  double signed_mean = 0, signed_std = 0;  ///< of d itself, B − A, for distances that have a sign
};

template <class T>
struct BothWays {
  T a_to_b, b_to_a;
};

struct M3c2Result {
  M3c2Field field;
  Array<Point3> cores;  ///< input coordinates
  std::size_t measured = 0, with_lod = 0, significant = 0;
  Figures figures;
  double median_lod = 0;
};

struct Distances {
  DistanceOptions options;  ///< as in force: the tolerance that was used
  Frame frame;
  InputSummary a, b;
  std::size_t points_a = 0, points_b = 0;  ///< kept and measured
  std::size_t faces_a = 0, faces_b = 0;    ///< of the surfaces; 0 where no measure needs them
  bool own_faces_a = false, own_faces_b = false;
  double trimmed_a = 0, trimmed_b = 0;  ///< share of the hull's area that the border left out
  std::string unit = "unknown";
  std::optional<BothWays<Figures>> c2c, c2s, normal, vertical;
  std::optional<BothWays<SurfaceFigures>> surface;
  std::optional<BothWays<HausdorffBound>> hausdorff;
  std::optional<M3c2Result> m3c2;
  /// One value per point of the file, "c2c", "c2s", "normal", "vertical", as far as measured. NaN: dropped or missing.
  std::vector<Attribute> fields_a, fields_b;
  std::vector<std::string> warnings;
  Timing timing;
};

/// UsageError, naming the option, for parameters of m3c2 that are missing or not positive, a tolerance that is no
/// length, no samples. distance() does it first; callers that read files before it do it before that.
void check(const DistanceOptions& options);

/// Measures what `options.measures` says. `cores` are core points of m3c2 in input coordinates; without them the kept
/// points of A. Signed distances are B − A: positive where B lies above A (the other surface's normal is taken upwards,
/// or outwards for own faces). "normal": the line through the point along the normal of the facet that lies under or
/// over it, to its nearest crossing with the other surface; missing where there is no such facet or crossing. Results
/// are functions of the sets of points (but for own faces and DuplicatePolicy::first) and the same for any number of
/// threads. Errors: InputError as choose_frame, project, make_mesh, and where heights have another unit than x and y;
/// UsageError as check, and for a tolerance below rounding; not converged, see
/// directed_hausdorff. Oracles: tests/distance/distance_test.cpp.
[[nodiscard]] Distances distance(const CloudView& a, const CloudView& b, const std::optional<CloudView>& cores,
                                 const DistanceOptions& options, const Context& context);

}  // namespace isopach
