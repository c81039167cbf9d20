#include "isopach/apps/self_turns.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "isopach/base/linear.hpp"
#include "isopach/base/random.hpp"

namespace isopach {
namespace {

constexpr double alike = 0.75;  // of two moments, the smaller over the larger: sampling and hidden parts shift them
constexpr int turns_about_axis = 12;
constexpr int any_turns = 400;
constexpr std::uint64_t turn_stream = 9500;

Motion about(const Eigen::Matrix3d& r, const Eigen::Vector3d& centre) {
  Motion m;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j) m.rotation[static_cast<std::size_t>(3 * i + j)] = r(i, j);
  const Eigen::Vector3d shift = centre - r * centre;
  m.shift = {shift[0], shift[1], shift[2]};
  return m;
}

/// Uniform over all turns [Shoemake1992].
Eigen::Matrix3d any_turn(const RandomStream& random, std::uint64_t k) {
  const double u = random.uniform(3 * k), a = 2 * std::numbers::pi * random.uniform(3 * k + 1),
               b = 2 * std::numbers::pi * random.uniform(3 * k + 2);
  const double r = std::sqrt(1 - u), s = std::sqrt(u);
  return Eigen::Quaterniond(s * std::cos(b), r * std::sin(a), r * std::cos(a), s * std::sin(b)).toRotationMatrix();
}

}  // namespace

std::vector<Motion> self_turns(const OrientedCloud& object, const Context& context) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  double area = 0;
  const auto at = [&](std::size_t i) {
    const Point3& p = object.points[i];
    return Eigen::Vector3d(p.x, p.y, p.z);
  };
  for (std::size_t i = 0; i < object.points.size(); ++i) middle += object.areas[i] * at(i), area += object.areas[i];
  middle /= area;
  for (std::size_t i = 0; i < object.points.size(); ++i) {
    const Eigen::Vector3d d = at(i) - middle;
    moments += object.areas[i] * d * d.transpose();
  }
  const Spectrum<3> axes = spectrum(moments);
  const auto& size = axes.values;
  const bool low = size[0] > alike * size[1], high = size[1] > alike * size[2];
  std::vector<Motion> turns;
  const auto add = [&](const Eigen::Matrix3d& r) { turns.push_back(about(r, middle)); };
  if (low && high) {
    const RandomStream random(context.seed, turn_stream);
    for (std::uint64_t k = 0; k < any_turns; ++k) add(any_turn(random, k));
    return turns;
  }
  const auto turn = [&](Eigen::Index axis, double angle) {
    return Eigen::AngleAxisd(angle, axes.vectors.col(axis)).toRotationMatrix();
  };
  if (!low && !high) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) add(turn(axis, std::numbers::pi));
    return turns;
  }
  const Eigen::Index axis = low ? 2 : 0;
  for (int k = 0; k < turns_about_axis; ++k) {
    const Eigen::Matrix3d r = turn(axis, 2 * std::numbers::pi * k / turns_about_axis);
    if (k > 0) add(r);
    add(r * turn(1, std::numbers::pi));
  }
  return turns;
}

}  // namespace isopach
