// JudgedScan: what a verdict on a pose has to know of a scan, whatever the pose: some of its points with normals on one
// side, where they were seen from, its own noise, and how much shape it has.
#pragma once
#include <cstdint>
#include <memory>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/distance/point_tree.hpp"
#include "isopach/field/height_field.hpp"
#include "isopach/match/verdict/viewing.hpp"

namespace isopach {

struct JudgedScan {
  Point3 origin{0, 0, 0};      ///< of the coordinates below, in those of the input
  Array<Point3> points;        ///< at most `judged_points`, about the origin, a function of the set of input points
  Array<Point3> normals;       ///< length 1, on the side of the eye; of the 12 nearest points
  Array<Point3> mean_normals;  ///< mean of the normals of these
  std::unique_ptr<PointTree> tree;
  Viewing viewing;
  Array<Point3> places;  ///< of the points in the viewing
  std::unique_ptr<PointTree> places_tree;
  Array<unsigned char> half;  ///< by point, 0 or 1 at random: the halves that noise and detail are told from
  Array<Index> queries;       ///< random points, drawn by the area that they stand for
  double spacing = 0;         ///< distance of the sixth neighbour, median, in space
  double place_spacing = 0;   ///< the same in the viewing
  double extent = 0;          ///< diagonal of the box that holds all but the outermost 1 % either side of each axis
  double noise = 0;           ///< s: 1.4826 medians of the distances of one half from the other
  double within_noise = 0;    ///< f: share of these distances below 3 s
  double detail = 0;          ///< q: how well the shape detail of the normals agrees between the halves, -1 to 1

  /// Whether there are points enough for any judgement.
  [[nodiscard]] bool usable() const { return queries.size() >= 30; }

  JudgedScan() = default;
  JudgedScan(JudgedScan&&) = default;  // the trees point into arrays, whose memory moves along
  JudgedScan& operator=(JudgedScan&&) = default;
};

inline constexpr std::size_t judged_points = 16000;  ///< of each scan
inline constexpr std::size_t judged_queries = 2500;  ///< at most, and at most half of the points
inline constexpr std::size_t normal_of = 12;         ///< points that a normal is fitted to, the point itself included

/// A number of 64 bits from coordinates and a seed: the same point gets the same, wherever it stands in its file.
[[nodiscard]] std::uint64_t point_key(const Point3& p, std::uint64_t seed);

/// The kept points of a cloud (classes, finite ones; a crop where `project` has one), thinned to `judged_points` at
/// random by context.seed, duplicates once.
///
/// Noise: the scan is split into random halves; the distances of points of one from the plane of the 8 nearest of the
/// other hold the noise and what the sampling misses of the curvature. Never below a hundredth of the spacing or the
/// rounding of the coordinates: data without noise. Detail: normals of each half by its own points alone, at the same
/// places; a linear function of the place, a smooth shape, is taken off both; the correlation of what is left. Random
/// points are drawn by the square of the distance of the 16th neighbour, at most its 95th percentile.
///
/// A scan of fewer than 60 points is not usable(). Cost O(n) for the choice, then 50 ms on one core.
/// Test: JudgedScan.* in tests/match/verdict_test.cpp, against a twin that looks at all pairs.
[[nodiscard]] JudgedScan judged_scan(const CloudView& cloud, const ProjectOptions& project, const Context& context);

}  // namespace isopach
