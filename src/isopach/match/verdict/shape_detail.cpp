#include "isopach/match/verdict/shape_detail.hpp"

#include <cmath>

#include "isopach/base/linear.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t fewest_pairs = 8;
constexpr double nothing_left = 1e-20;  // of the squares of normals: rounding

Eigen::Vector3d vector(const Point3& p) { return {p.x, p.y, p.z}; }

}  // namespace

Point3 mean_of(std::span<const Point3> vectors, std::span<const Index> chosen) {
  Point3 sum{0, 0, 0};
  for (const Index k : chosen) sum = sum + vectors[k];
  return chosen.empty() ? sum : (1 / static_cast<double>(chosen.size())) * sum;
}

LocalPlane plane_of(std::span<const Point3> points, std::span<const Index> chosen) {
  LocalPlane plane;
  if (chosen.empty()) return plane;
  plane.centre = mean_of(points, chosen);
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (const Index k : chosen) {
    const Point3 d = points[k] - plane.centre;
    xx += d.x * d.x, xy += d.x * d.y, xz += d.x * d.z;
    yy += d.y * d.y, yz += d.y * d.z, zz += d.z * d.z;
  }
  Eigen::Matrix3d moments;
  moments << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  // Half of the digits are far finer than any noise.
  const Eigen::Vector3d normal = rough_spectrum(moments).vectors.col(0);
  plane.normal = {normal(0), normal(1), normal(2)};
  return plane;
}

double ShapeDetail::correlation() const {
  if (samples_.size() < fewest_pairs) return 0;
  const auto n = static_cast<double>(samples_.size());
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Sample& s : samples_) middle += vector(s.place);
  middle /= n;
  double radius2 = 0;
  for (const Sample& s : samples_) radius2 += (vector(s.place) - middle).squaredNorm();
  const double scale = radius2 > 0 ? 1 / std::sqrt(radius2 / n) : 0;
  const auto row = [&](const Sample& s) {
    Eigen::Vector4d r;
    r << 1, scale * (vector(s.place) - middle);
    return r;
  };
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 6> right = Eigen::Matrix<double, 4, 6>::Zero();
  Eigen::Matrix<double, 1, 6> both;
  for (const Sample& s : samples_) {
    const Eigen::Vector4d r = row(s);
    both << vector(s.first).transpose(), vector(s.second).transpose();
    normal += r * r.transpose();
    right += r * both;
  }
  // Places on a plane leave the matrix singular: the least of all solutions then.
  const Eigen::Matrix<double, 4, 6> fit = least_norm(normal, right);
  double aa = 0, bb = 0, ab = 0;
  for (const Sample& s : samples_) {
    const Eigen::Matrix<double, 1, 6> smooth = row(s).transpose() * fit;
    const Eigen::Vector3d a = vector(s.first) - smooth.head<3>().transpose();
    const Eigen::Vector3d b = vector(s.second) - smooth.tail<3>().transpose();
    aa += a.squaredNorm(), bb += b.squaredNorm(), ab += a.dot(b);
  }
  if (aa <= nothing_left * n || bb <= nothing_left * n) return 0;
  return ab / std::sqrt(aa * bb);
}

}  // namespace isopach
