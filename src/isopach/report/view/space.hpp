// The view of points in space: parts of a model, coloured by a distance or by what they belong to, moved by poses.
// viewer/src/space.ts shows it. Pages stay complete without.
#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "isopach/base/array.hpp"
#include "isopach/base/context.hpp"
#include "isopach/base/types.hpp"
#include "isopach/geom/rigid.hpp"
#include "isopach/geom/vec.hpp"
#include "isopach/report/draw/pen.hpp"

namespace isopach {

/// What points belong to: a name beside a colour.
struct SpacePart {
  std::string name;
  std::string colour;  ///< as in CSS, "#0072b2"
};

/// A moment of an animation.
struct SpaceFrame {
  std::string label;
  Pose motion;  ///< of points whose blend is 1, input coordinates
};

/// What is to be looked at. Spans are kept by reference; empty ones: there is none.
struct SpaceScene {
  std::string title, unit;
  std::span<const Point3> points;               ///< input coordinates; those that are not finite are left out
  std::span<const std::array<Index, 3>> faces;  ///< shown where all points are
  std::span<const double> values;               ///< by point; NaN: none
  std::span<const double> levels;               ///< of detection, by point
  std::span<const unsigned char> part_of;       ///< by point; empty: all belong to the first
  std::span<const double> blend;                ///< by point: 0 stays, 1 follows the frames' motion
  std::vector<SpacePart> parts;
  std::vector<SpaceFrame> frames;
  double second = 0.1;     ///< from a frame to the next
  Pose upright;            ///< to the axes of the view: x to the right, y up, z to the viewer; a turn
  double azimuth = 0;      ///< degrees that the first look comes from the right
  double elevation = 0;    ///< … and from above
  std::string value_name;  ///< "distance along the normal"
  bool has_sign = false;   ///< of the values
  double limit = 0;        ///< of the colours
  bool flip = false;       ///< of the palette
};

/// Some of the points, in an order of their places that does not depend on theirs in the file, for both picture and
/// view: of each cube of a grid that one nearest to its middle, and of larger cubes the one with the largest |value|.
struct SpaceSample {
  std::vector<Index> chosen;
  std::vector<Point3> normals;  ///< of chosen: unit, to the viewer's side
  double spacing = 0;           ///< usual distance from a chosen point to those beside it
  bool is_whole = false;        ///< all points are there
};
/// At most about `most`. Cost: O(n log n). Tests: tests/report/space_test.cpp.
[[nodiscard]] SpaceSample sample_space(const SpaceScene& scene, std::size_t most, const Context& context);
inline constexpr std::size_t default_space_points = 100'000;

/// 95 % of |values| are within it, rounded up to two digits; 0 where all are 0 or missing.
[[nodiscard]] double space_limit(std::span<const double> values);

/// The scene as it is first seen, without the view.
[[nodiscard]] Image space_picture(const SpaceScene& scene, const SpaceSample& sample, int width, int height);

/// The data and the script, for the end of a page (HtmlPage::add_view). Empty where there is no point.
[[nodiscard]] std::string space_view(const SpaceScene& scene, const SpaceSample& sample);

}  // namespace isopach
