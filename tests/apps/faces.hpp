// Faces whose symmetry plane is known: the simulated face, symmetric in x, with what is added to it, sampled at random
// places with noise, then turned and shifted.
#pragma once
#include <cmath>
#include <functional>

#include "isopach/apps/asymmetry.hpp"
#include "isopach/apps/mirror.hpp"
#include "isopach/base/random.hpp"
#include "isopach/simulate/bump.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/match/poses.hpp"

namespace isopach::test {

struct FaceScan {
  std::size_t points = 7000;
  double noise = 0.05;  // mm
  std::uint64_t seed = 1;
  std::function<double(double x, double y)> added = [](double, double) { return 0.0; };
  std::function<bool(double x, double y)> seen = [](double, double) { return true; };
  Pose pose;
};

/// An oval of 176 mm by 236 mm, as that of the scene.
inline Outline face_oval() {
  Outline oval;
  for (int i = 0; i < 48; ++i) {
    const double angle = 2 * std::numbers::pi * i / 48;
    oval.push_back({88 * std::cos(angle), 118 * std::sin(angle) - 2});
  }
  return oval;
}

inline Cloud face_scan(const FaceScan& scan) {
  const auto surface = scene_surface("face", "", 1);
  const Array<Point2> nodes = irregular_nodes(face_oval(), scan.points, {scan.seed, 0});
  const RandomStream random(scan.seed, 7);
  Cloud cloud;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto [x, y] = nodes[i];
    if (scan.seen(x, y))
      cloud.points.push_back({x, y, surface(x, y) + scan.added(x, y) + scan.noise * random.normal(i)});
  }
  cloud.path = "face.ply";
  cloud.unit = cloud.vertical_unit = "mm";
  return posed(std::move(cloud), scan.pose);
}

/// A swelling of the cheek on the positive side, of the scene's size at height 6.
inline Bump cheek(double height) { return {{45, -31}, height, 30, 26, {0.6, 0.8}, 0, 0}; }

/// How far a plane is from the one of x = 0 moved by `pose`: degrees, and distance of its point from that plane.
struct PlaneError {
  double degrees, distance;
};
inline PlaneError plane_error(const SymmetryPlane& found, const Pose& pose) {
  const Point3 n{pose.m[0], pose.m[4], pose.m[8]}, o = pose.apply({0, 0, 0});
  const Point3& f = found.normal;
  const Point3 cross{n.y * f.z - n.z * f.y, n.z * f.x - n.x * f.z, n.x * f.y - n.y * f.x};
  const double angle = std::atan2(std::sqrt(dot(cross, cross)), std::fabs(dot(n, f)));
  const Point3 v{found.point.x - o.x, found.point.y - o.y, found.point.z - o.z};
  return {angle * 180 / std::numbers::pi, std::fabs(dot(n, v))};
}

/// Turned about y and z (and nodding a little), shifted: as a person sits before a scanner.
inline Pose sitting(double turn = 6, double roll = 8) {
  return chained(turn_and_shift({0, 1, 0}, turn, {0, 0, 0}, {12, -30, 400}),
                 chained(turn_and_shift({1, 0, 0}, -4, {0, 0, 0}, {0, 0, 0}),
                         turn_and_shift({0, 0, 1}, roll, {0, 0, 0}, {0, 0, 0})));
}

}  // namespace isopach::test
