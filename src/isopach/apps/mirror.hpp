// mirror: a face upright before its symmetry plane, its mirror image, and the reflection that a matching of the two
// speaks of.
#pragma once
#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "isopach/cloud/cloud_view.hpp"
#include "isopach/compare/options.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/matching.hpp"

namespace isopach {

inline constexpr double degrees_per_radian = 180 / std::numbers::pi;

/// The plane normal · p = offset, and how far a motion of the mirror image is from the reflection about it.
struct Reflection {
  Point3 normal{1, 0, 0};
  double offset = 0;
  double twist = 0;  ///< degrees about the normal
  double glide = 0;  ///< along the plane, at the origin
};

/// Of `pose` after x ↦ −x, an improper rotation with a shift: the plane that holds the middles of all points and their
/// images. The normal is the eigenvector of the symmetric part of its matrix with the least eigenvalue (−1).
[[nodiscard]] Reflection reflection_of(const Pose& pose);

/// Standard deviations of that plane: its normal turns by half of what the mirror image turns by and its offset shifts
/// by half. `m` takes the residuals of both sides of the face for independent, but they are the same with the sign
/// exchanged: variances are doubled. Degrees; length.
void describe_sigma(const Matching& m, double& sigma_angle, double& sigma_offset);

/// Coordinates before a plane: p ↦ rotation · (p − origin); the plane is x = 0.
struct Upright {
  Point3 origin{0, 0, 0};
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< rows: axes x, y, z

  [[nodiscard]] Point3 axis(std::size_t k) const { return {rotation[3 * k], rotation[3 * k + 1], rotation[3 * k + 2]}; }
  [[nodiscard]] Point3 apply(const Point3& p) const {
    const Point3 v{p.x - origin.x, p.y - origin.y, p.z - origin.z};
    return {dot(axis(0), v), dot(axis(1), v), dot(axis(2), v)};
  }
  /// Before a plane found in these coordinates: x along its normal, to the side of `towards`; z the direction (0, 0, 1)
  /// as far as it lies in the plane. Throws OverlapError where the plane lies across that direction.
  [[nodiscard]] Upright after(const Reflection& found, const Point3& towards) const;
  /// The plane turned about z by `roll` and about y by `turn`, degrees, then shifted along its normal; the axes as in
  /// `after`.
  [[nodiscard]] Upright turned_and_shifted(double roll, double turn, double shift) const;
  /// The same plane and axes; y and z are 0 in the middle of the box of the points.
  [[nodiscard]] Upright recentred(const Array<Point3>& points) const;
};

/// x along `across` made upright to z, which stays; the origin in the middle of the box of the points.
/// Throws UsageError naming --across where it is along z.
[[nodiscard]] Upright upright_through_middle(const Array<Point3>& points, const Point3& across);

/// A direction of the input in the axes of a frame.
[[nodiscard]] Point3 in_view(const Point3& v, const Frame& frame);

/// --across in the axes of a frame; its first axis where it is not given.
[[nodiscard]] Point3 across_in_view(const std::optional<Point3>& across, const Frame& frame);

/// Points as a height field along z, in their own coordinates: nodes in curve order, whatever that of the points.
[[nodiscard]] HeightField field_of(const Array<Point3>& points, DuplicatePolicy duplicates, CurveBox& curve,
                                   const Context& context);
/// Means of `run` nodes each that follow each other on the curve, so that they are neighbours.
[[nodiscard]] Array<Point3> means_of_neighbours(const HeightField& field, std::size_t run, const Context& context);

[[nodiscard]] Cloud placed(const Array<Point3>& points, const Upright& place);
[[nodiscard]] Cloud mirrored(const CloudView& cloud);  ///< x ↦ −x, exactly
/// Diagonal of the box in x and y.
[[nodiscard]] double size_of(const CloudView& cloud);

/// Unit of lengths in space, as in a comparison. Throws InputError where heights have another unit than x and y, and
/// as a comparison does for degrees and pseudo-Mercator.
[[nodiscard]] std::string unit_in_space(const CloudView& description, const CompareOptions& options,
                                        std::vector<std::string>& warnings);

}  // namespace isopach
