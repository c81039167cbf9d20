// An object with relief, scanned alone and before a background, by a generator that shares nothing with simulate/.
#pragma once
#include <cmath>
#include <functional>

#include "isopach/cloud/cloud.hpp"
#include "isopach/geom/rigid.hpp"
#include "tests/support/random.hpp"

namespace isopach::test {

/// A bent tongue of 64 by 40 with four marks of different size: no motion takes it onto itself.
inline double held_object(double x, double y) {
  struct Mark {
    double x, y, width, height;
  };
  constexpr Mark marks[] = {{-18, 6, 6, 5}, {10, -8, 5, -3.5}, {20, 9, 7, 4}, {-5, -12, 4.5, 2.5}};
  double z = 0.006 * x * x - 0.004 * x * y + 1.2 * std::sin(x / 9 + 0.4) * std::cos(y / 7);
  for (const Mark& m : marks) {
    const double u = (x - m.x) / m.width, v = (y - m.y) / m.width;
    z += m.height * std::exp(-0.5 * (u * u + v * v));
  }
  return z;
}

inline constexpr double held_half_x = 32, held_half_y = 20;

using Surface = std::function<double(double, double)>;

class HeldObjectScanner {
 public:
  explicit HeldObjectScanner(std::uint64_t seed) : random_(seed) {}

  /// Random points over a rectangle, noise along z.
  Cloud alone(std::size_t count, double noise, const Surface& surface = held_object, double half_x = held_half_x,
              double half_y = held_half_y) {
    Cloud cloud;
    cloud.unit = cloud.vertical_unit = "mm";
    for (std::size_t i = 0; i < count; ++i) add(cloud, surface, half_x, half_y, noise);
    return cloud;
  }

  /// The object, of which the share `hidden` is covered, with `count` points on all of it, before a wavy background of
  /// half its density.
  Cloud held(std::size_t count, double noise, double hidden, const Surface& surface = held_object) {
    Cloud cloud = alone(count, noise, surface);
    std::erase_if(cloud.points, [&](const Point3& p) { return p.x > held_half_x * (1 - 2 * hidden); });
    const auto behind = [](double x, double y) { return 3 * std::sin(x / 11) * std::cos(y / 13 + 1) - 14; };
    Cloud wide = alone(2 * count, noise, behind, 2 * held_half_x, 2 * held_half_y);
    for (const Point3& p : wide.points)
      if (std::fabs(p.x) > held_half_x || std::fabs(p.y) > held_half_y) cloud.points.push_back(p);
    return cloud;
  }

 private:
  void add(Cloud& cloud, const Surface& surface, double half_x, double half_y, double noise) {
    const double x = random_.uniform(-half_x, half_x), y = random_.uniform(-half_y, half_y);
    cloud.points.push_back({x, y, surface(x, y) + noise * random_.bell()});
  }

  Random random_;
};

/// A turn about x, then z, and a shift.
inline Pose some_pose(double about_x, double about_z, const Point3& shift) {
  const double cx = std::cos(about_x), sx = std::sin(about_x), cz = std::cos(about_z), sz = std::sin(about_z);
  Pose p;
  p.m = {cz, -sz * cx, sz * sx, shift.x, sz, cz * cx, -cz * sx, shift.y, 0, sx, cx, shift.z, 0, 0, 0, 1};
  return p;
}

inline Cloud posed(Cloud cloud, const Pose& pose) {
  for (Point3& p : cloud.points) p = pose.apply(p);
  return cloud;
}

}  // namespace isopach::test
