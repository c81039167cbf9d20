// Landmarks: a few thousand places spread over a scan, each with a normal and a description of the relief round it that
// no rigid motion changes. What the coarse start recognises.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/geom/vec.hpp"

namespace isopach {

/// A spin image [Johnson1999]: how the neighbours lie by their distance from the normal (rings) and by
/// their height over the tangent plane (floors); each ring sums to 1, or is 0 where it has hardly a neighbour.
struct SpinImage {
  static constexpr std::size_t rings = 6, floors = 8;
  std::array<float, rings * floors> cells{};
};

struct Landmarks {
  double side = 0;                ///< of the cubes that each give one landmark
  std::vector<Point3> places;     ///< means of the points of a cube
  std::vector<Point3> normals;    ///< length 1, of one side of the surface; (0, 0, 0) where there is none
  std::vector<double> heights;    ///< RMS of the neighbours from the tangent plane
  std::vector<SpinImage> images;  ///< filled by describe()
};

/// Radius of what is described, in cubes.
inline constexpr double support_sides = 6;

/// Side of the cubes that gives the larger of two scans about `target` landmarks.
[[nodiscard]] double landmark_side(std::span<const Point3> a, std::span<const Point3> b, std::size_t target);

/// Means of the points by cubes, normals by least squares over the support, turned to one side of the surface along the
/// tree of most parallel neighbours ([Hoppe1992], section 3.3). `points` in a fixed order give fixed bits.
[[nodiscard]] Landmarks landmarks(std::span<const Point3> points, double side, const Context& context);

/// Images of both scans in one scale of heights.
void describe(Landmarks& a, Landmarks& b, const Context& context);

/// Sum of squared differences over the rings that both have, as a mean of a ring; `flipped`: b seen from its other
/// side.
[[nodiscard]] float image_distance(const SpinImage& a, const SpinImage& b);
/// The image as the opposite normal would make it.
[[nodiscard]] SpinImage flipped(const SpinImage& image);

}  // namespace isopach
