// HeightField: a scan seen along the projection direction. Nodes in the plane in Hilbert order, one height each, ids
// back into the cloud, what was cleaned and why (docs/method/height-field.md).
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/base/types.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/geom/curve.hpp"
#include "isopach/geom/rigid.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// How the heights of points with the same (x, y) become one. "error" refuses such a scan.
enum class DuplicatePolicy { mean, min, max, median, first, error };

/// Projection direction: an axis, a given vector, or the normal of the plane fitted to both scans together.
struct Direction {
  enum class Kind { axis_x, axis_y, axis_z, vector, fit } kind = Kind::axis_z;
  Point3 vector{0, 0, 1};  ///< used by Kind::vector; any length but 0
};

struct ProjectOptions {
  Direction direction;  ///< default z
  DuplicatePolicy duplicates = DuplicatePolicy::mean;
  std::vector<int> classes;  ///< keep only these LAS classes; empty = all
  std::optional<Box2> crop;  ///< keep only points with (x, y) of the input inside; closed box
};

/// The frame both scans of a pair are seen in: field = rotation · (input − origin). One frame per pair.
/// `origin` is chosen so that the subtraction is exact in doubles (see choose_frame); rotation rows are u, v, w.
/// Right-handed: u × v = w. Directions x, y, z give (u, v, w) = (y, z, x), (z, x, y), (x, y, z); −z gives (x, −y, −z)
/// and so on; any other direction is its nearest axis turned by the smallest rotation.
/// to_input(to_field(p)) == p, bit for bit up to the sign of 0, for axis-aligned frames and kept points; otherwise
/// within 1e-15 of the size of the coordinates. Oracle: tests/field/frame_test.cpp.
struct Frame {
  Point3 origin{0, 0, 0};
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major; rows u, v, w; w = projection direction
  bool axis_aligned = true;                                   ///< rotation only permutes axes: no rounding
  CurveBox curve;                                             ///< the box both scans' Hilbert keys are counted in
  Box3 box;                                                   ///< of the kept points of both scans, in this frame

  [[nodiscard]] Point3 to_field(const Point3& p) const;
  [[nodiscard]] Point3 to_input(const Point3& p) const;
};

/// What happened to the points on the way. points = kept + dropped_*; nodes = kept − duplicates.
struct Cleaning {
  std::size_t points = 0, dropped_nonfinite = 0, dropped_class = 0, dropped_crop = 0;
  std::size_t duplicates = 0;       ///< points merged into a node that another point already made
  double duplicate_max_spread = 0;  ///< largest difference of height inside one merged node
};

struct HeightField {
  Array<Point2> xy;            ///< nodes, frame coordinates, Hilbert order, no two equal
  Array<double> z;             ///< height of each node along the direction
  Array<std::uint64_t> keys;   ///< of each node on the curve of the frame (curve_key); whoever knows that nobody asks
                               ///< for them any more may drop them
  Array<Index> node_of_point;  ///< for each point of the cloud its node, or no_index if dropped
  Cleaning cleaning;
};

/// Frame for a pair of clouds (the same for (a, b) and (b, a)). `pose` is applied to b first. A function of the two
/// sets of kept points, not of their order. Origin, per axis of the joint box: 0 if the box is nearer to 0 than 4 times
/// its side, else a multiple of a power of two near its centre, so that x − origin is exact for every x in the box.
/// Cost: O(n), 2 to 3 passes, no memory. Errors: InputError when a cloud has no point left, when the coordinates spread
/// over more than 1e60, or when a plane is to be fitted to points on one line; UsageError when the vector is no
/// direction.
[[nodiscard]] Frame choose_frame(const CloudView& a, const CloudView& b, const Pose& pose_b,
                                 const ProjectOptions& options, const Context& context);

/// What a look at all points of a scan tells, block by block for one that does not fit into memory.
struct ScanExtent {
  Cleaning cleaning;  ///< points and what is dropped of them
  Box3 kept;          ///< of the kept points, input coordinates (after the pose)
  Box3 finite;        ///< of all that are finite
  void add(const ScanExtent& other);
};
[[nodiscard]] ScanExtent extent_of(const CloudView& cloud, const Pose& pose, const ProjectOptions& options);

/// The same frame from the extents of both. Errors as above; UsageError for a direction that is no axis: it takes
/// another look at the points. `names`: of both scans, for messages.
[[nodiscard]] Frame choose_frame(const std::array<ScanExtent, 2>& extents, const std::array<std::string, 2>& names,
                                 const Direction& direction);

/// The kept points of a cloud, in the frame.
[[nodiscard]] Array<Point3> points_in_frame(const CloudView& cloud, const Pose& pose, const Frame& frame,
                                            const ProjectOptions& options);

/// By node, the largest difference of height of the points that it was merged from; empty if none was. The heights are
/// asked for again: a field keeps one for each node. Cost O(points).
[[nodiscard]] Array<double> merged_spread(const CloudView& cloud, const Pose& pose, const Frame& frame,
                                          const HeightField& field);

/// As project() of all that these points are the part of that lies in one square of the curve, which they keep the
/// order of. `duplicates`: the policy; error merges as first, and it is for the caller to look at what was merged.
/// `spread`, if given: merged_spread.
[[nodiscard]] HeightField project_part(std::span<const Point3> in_frame, const Frame& frame, DuplicatePolicy duplicates,
                                       Array<double>* spread, const Context& context);

/// Projects one cloud. The result depends on the set of points, not on their order (but for DuplicatePolicy::first).
/// Cost: O(n) (radix sort). Errors: InputError when the attribute "classification" is missing and classes are asked
/// for, when duplicates are forbidden and present, and when no point is left.
[[nodiscard]] HeightField project(const CloudView& cloud, const Pose& pose, const Frame& frame,
                                  const ProjectOptions& options, const Context& context);

/// Share of the occupied area in which the scan has several layers along the direction (0 for a true height field).
/// Works on the points, before merging would hide anything: squares of 24 to 96 points on average, in which the
/// heights, freed of their plane, fall into two groups (20 % of the points each, or more) at least 6 standard
/// deviations apart that are interleaved in the plane (a cliff is not). Squares with fewer than 12 points are not
/// judged and not counted; 0 if there are no others. Not seen: layers nearer than a quarter of the point spacing or
/// than the noise, layers with few points, and walls, whose heights are spread evenly. Objects of few points each look
/// like a layer. A function of the set of points. `field` is the projection of the cloud. Cost: O(n), two passes over
/// the nodes and O(1) work per judged point; where points were merged also 12 bytes a point. Oracle: the scenes of
/// tests/field/layers_test.cpp. See the docs page "height field".
[[nodiscard]] double layered_share(const HeightField& field, const CloudView& cloud, const Pose& pose,
                                   const Frame& frame, const Context& context);

/// The same of a scan that is looked at part by part. First the parts, in the order of the curve, tell how their nodes
/// lie on it; then all points are shown once more, in any order, of which some are judged.
class LayerCheck {
 public:
  /// Nodes of the next part, which lie behind those before on the curve.
  void add_nodes(std::span<const std::uint64_t> keys);
  /// What another LayerCheck was told of nodes that lie behind these.
  void add(const LayerCheck& behind);

  /// Once all nodes are known. `points`: kept ones of the scan.
  void begin(std::size_t points, const CurveBox& box);
  void add_points(std::span<const Point3> in_frame);
  /// As layered_share of the whole.
  [[nodiscard]] double share(const Context& context);

  struct State {  ///< what nodes tell, to be kept in a file
    std::array<std::uint64_t, 33> counts{};
    std::uint64_t first = 0, last = 0, nodes = 0;
  };
  [[nodiscard]] const State& state() const { return state_; }
  explicit LayerCheck(const State& state) : state_(state) {}
  LayerCheck() = default;

 private:
  struct Sampled {
    std::uint64_t key;
    Point3 at;
  };
  State state_;
  CurveBox box_;
  int level_ = 0;
  std::uint64_t mask_ = 0;
  Array<Sampled> sampled_;
};

/// The same of a cloud that is not projected yet. Errors: as project, but duplicates are never refused.
[[nodiscard]] double layered_share(const CloudView& cloud, const Pose& pose, const Frame& frame,
                                   const ProjectOptions& options, const Context& context);

}  // namespace isopach
