#include "isopach/match/pairs/least_squares.hpp"

#include <fmt/format.h>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t link_block = 1024;

/// Plain sums within a block, compensated from block to block.
template <std::size_t N, class Add>
std::array<double, N> sums(std::span<const Link> links, Add&& add) {
  using Totals = std::array<Sum, N>;
  const Totals totals = reduce_blocks<Totals>(
      links.size(), link_block,
      [&](std::size_t begin, std::size_t end) {
        std::array<double, N> part{};
        for (std::size_t i = begin; i < end; ++i) add(links[i], part);
        Totals result;
        for (std::size_t k = 0; k < N; ++k) result[k].add(part[k]);
        return result;
      },
      [](Totals& total, const Totals& part) {
        for (std::size_t k = 0; k < N; ++k) total[k].add(part[k]);
      });
  std::array<double, N> result{};
  for (std::size_t k = 0; k < N; ++k) result[k] = totals[k].value();
  return result;
}

using Vector7 = Eigen::Matrix<double, 7, 1>;

std::vector<int> free_motions(const Freedom& f) {
  const std::array<bool, 7> free{f.turn_x, f.turn_y, f.turn_z, f.shift_x, f.shift_y, f.shift_z, f.scale};
  std::vector<int> result;
  for (int i = 0; i < 7; ++i)
    if (free[static_cast<std::size_t>(i)]) result.push_back(i);
  return result;
}

Twist to_twist(const Vector7& x, double radius) {
  return {x[0] / radius, x[1] / radius, x[2] / radius, x[3], x[4], x[5], x[6] / radius};
}

/// Solves the part of m x = g that belongs to the free motions, along the eigenvectors above `floor`.
Vector7 solve(const Matrix7& m, const Vector7& g, const Freedom& freedom, double floor) {
  const std::vector<int> free = free_motions(freedom);
  const Eigen::MatrixXd part = m(free, free);
  const Eigen::VectorXd right = g(free);
  const Spectrum<Eigen::Dynamic> axes = spectrum(part);
  Vector7 x = Vector7::Zero();
  for (Eigen::Index k = 0; k < axes.values.size(); ++k) {
    if (!(axes.values[k] > floor)) continue;
    const Eigen::VectorXd v = axes.vectors.col(k);
    const Eigen::VectorXd along = (v.dot(right) / axes.values[k]) * v;
    for (std::size_t i = 0; i < free.size(); ++i) x[free[i]] += along[static_cast<Eigen::Index>(i)];
  }
  return x;
}

std::string motion_words(const Eigen::Matrix<double, 6, 1>& v, const std::array<std::string, 3>& axes) {
  std::string words;
  for (Eigen::Index i = 0; i < 6; ++i) {
    if (std::fabs(v[i]) < 0.4) continue;
    if (!words.empty()) words += " with ";
    words += fmt::format("{} {}", i < 3 ? "turn about" : "shift along", axes[static_cast<std::size_t>(i % 3)]);
  }
  return words;
}

}  // namespace

namespace {

/// What the precisions make of the links: normal matrix, gradient and error, instead of those of (3).
void add_planes(std::span<const Link> links, PairInformation& in) {
  const Point3 centre = in.centre;
  const double scale = 1 / in.radius;
  const auto total = sums<36>(links, [&](const Link& l, auto& s) {
    const Point3 a = scale * (l.moving - centre), d = l.moving - l.fixed;
    const Symmetric3 p = precision(l);
    // Columns of J: what a turn about each axis, a shift along it, and the scale do to the point.
    const Point3 columns[7] = {{0, -a.z, a.y}, {a.z, 0, -a.x}, {-a.y, a.x, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, a};
    const Point3 drawn = p * d;
    std::size_t k = 0;
    for (std::size_t i = 0; i < 7; ++i) {
      const Point3 weighted = l.weight * (p * columns[i]);
      for (std::size_t j = i; j < 7; ++j) s[k++] += dot(weighted, columns[j]);
      s[28 + i] += l.weight * dot(columns[i], drawn);
    }
    s[35] += l.weight * dot(d, drawn);
  });
  std::size_t k = 0;
  for (std::size_t i = 0; i < 7; ++i) {
    for (std::size_t j = i; j < 7; ++j) in.planes[7 * i + j] = in.planes[7 * j + i] = total[k++] / in.weight;
    in.gradient[i] = total[28 + i] / in.weight;
  }
  in.error = total[35] / in.weight;
}

}  // namespace

PairInformation pair_information(std::span<const Link> links, PairKind kind) {
  PairInformation in;
  const auto mean = sums<4>(links, [](const Link& l, auto& s) {
    s[0] += l.weight;
    s[1] += l.weight * l.moving.x, s[2] += l.weight * l.moving.y, s[3] += l.weight * l.moving.z;
  });
  in.weight = mean[0];
  if (!(in.weight > 0)) return in;
  in.centre = {mean[1] / in.weight, mean[2] / in.weight, mean[3] / in.weight};
  const Point3 centre = in.centre;
  const double radius2 =
      sums<1>(links, [&](const Link& l, auto& s) { s[0] += l.weight * squared_length(l.moving - centre); })[0];
  if (radius2 > 0) in.radius = std::sqrt(radius2 / in.weight);
  const double scale = 1 / in.radius;
  const auto total = sums<36>(links, [&](const Link& l, auto& s) {
    const Point3 arm = scale * (l.moving - centre), turn = cross(arm, l.normal), d = l.moving - l.fixed;
    const double row[7] = {turn.x, turn.y, turn.z, l.normal.x, l.normal.y, l.normal.z, dot(arm, l.normal)};
    const double r = dot(d, l.normal);
    std::size_t k = 0;
    for (std::size_t i = 0; i < 7; ++i) {
      const double w = l.weight * row[i];
      for (std::size_t j = i; j < 7; ++j) s[k++] += w * row[j];
      s[28 + i] += w * r;
    }
    s[35] += l.weight * (kind == PairKind::point ? squared_length(d) : r * r);
  });
  std::size_t k = 0;
  for (std::size_t i = 0; i < 7; ++i) {
    for (std::size_t j = i; j < 7; ++j) in.normal[7 * i + j] = in.normal[7 * j + i] = total[k++] / in.weight;
    in.gradient[i] = total[28 + i] / in.weight;
  }
  in.error = total[35] / in.weight;
  if (kind == PairKind::planes) add_planes(links, in);
  return in;
}

Twist plane_step(const PairInformation& in, const Freedom& freedom, double floor) {
  const Matrix7 m = Eigen::Map<const Matrix7>(in.normal.data());
  const Vector7 g = -Eigen::Map<const Vector7>(in.gradient.data());
  return to_twist(solve(m, g, freedom, floor), in.radius);
}

Twist planes_step(const PairInformation& in, const Freedom& freedom, double floor) {
  const std::vector<int> free = free_motions(freedom);
  const Matrix7 holding = Eigen::Map<const Matrix7>(in.normal.data()),
                all = Eigen::Map<const Matrix7>(in.planes.data());
  const Spectrum<Eigen::Dynamic> axes = spectrum(Eigen::MatrixXd(holding(free, free)));
  Eigen::Index weak = 0;  // eigenvalues ascend
  while (weak < axes.values.size() && !(axes.values[weak] > floor)) ++weak;
  if (weak == axes.values.size()) return {};
  Basis7 held = Basis7::Zero(7, axes.values.size() - weak);
  for (std::size_t i = 0; i < free.size(); ++i)
    for (Eigen::Index k = 0; k < held.cols(); ++k)
      held(free[i], k) = axes.vectors(static_cast<Eigen::Index>(i), weak + k);
  const Vector7 g = -Eigen::Map<const Vector7>(in.gradient.data());
  return to_twist(from_basis(held, Ldlt(within(held, all)).solve(along_basis(held, g))), in.radius);
}

Motion point_step(std::span<const Link> links, const PairInformation& in, bool scale) {
  const Point3 c = in.centre;
  const auto s = sums<13>(links, [&](const Link& l, auto& t) {
    const Point3 p = l.moving - c, q = l.fixed - c;
    const double a[3] = {p.x, p.y, p.z}, b[3] = {q.x, q.y, q.z};
    for (std::size_t i = 0; i < 3; ++i) {
      t[i] += l.weight * b[i];
      for (std::size_t j = 0; j < 3; ++j) t[3 + 3 * i + j] += l.weight * b[i] * a[j];
    }
    t[12] += l.weight * squared_length(p);
  });
  // The mean of p − c is 0, so the cross-covariance needs no correction for the mean of q.
  Eigen::Matrix3d cross_covariance;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j) cross_covariance(i, j) = s[static_cast<std::size_t>(3 + 3 * i + j)];
  const SingularValues svd = singular_values(cross_covariance);
  Eigen::Vector3d sign(1, 1, svd.u.determinant() * svd.v.determinant() < 0 ? -1 : 1);
  const Eigen::Matrix3d r = svd.u * sign.asDiagonal() * svd.v.transpose();
  Motion motion;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j) motion.rotation[static_cast<std::size_t>(3 * i + j)] = r(i, j);
  if (scale && s[12] > 0) motion.scale = svd.values.dot(sign) / s[12];
  const Point3 turned = motion.apply(c);
  motion.shift = {c.x + s[0] / in.weight - turned.x, c.y + s[1] / in.weight - turned.y,
                  c.z + s[2] / in.weight - turned.z};
  return motion;
}

Twist point_twist(std::span<const Link> links, const PairInformation& in, const Freedom& freedom) {
  Matrix7 m = Matrix7::Zero();
  Vector7 g = Vector7::Zero();
  const double scale = 1 / in.radius;
  const auto s = sums<16>(links, [&](const Link& l, auto& t) {
    const Point3 a = scale * (l.moving - in.centre), d = l.fixed - l.moving, turn = cross(a, d);
    const double w = l.weight;
    t[0] += w * a.x * a.x, t[1] += w * a.x * a.y, t[2] += w * a.x * a.z;
    t[3] += w * a.y * a.y, t[4] += w * a.y * a.z, t[5] += w * a.z * a.z;
    t[6] += w * turn.x, t[7] += w * turn.y, t[8] += w * turn.z;
    t[9] += w * d.x, t[10] += w * d.y, t[11] += w * d.z, t[12] += w * dot(a, d);
  });
  const double xx = s[0], xy = s[1], xz = s[2], yy = s[3], yz = s[4], zz = s[5];
  m.topLeftCorner<3, 3>() << yy + zz, -xy, -xz, -xy, xx + zz, -yz, -xz, -yz, xx + yy;
  m(3, 3) = m(4, 4) = m(5, 5) = in.weight;
  m(6, 6) = xx + yy + zz;
  for (Eigen::Index i = 0; i < 7; ++i) g[i] = s[static_cast<std::size_t>(6 + i)];
  constexpr double rounding = 1e-14;
  return to_twist(solve(m / in.weight, g / in.weight, freedom, rounding), in.radius);
}

std::array<double, 36> pair_covariance(const PairInformation& in, double sigma2, double count, double floor,
                                       const std::array<std::string, 3>& axes, std::vector<std::string>& directions) {
  const Matrix7 all = Eigen::Map<const Matrix7>(in.normal.data());
  const Eigen::Matrix<double, 6, 6> m = all.topLeftCorner<6, 6>();
  const Spectrum<6> held = spectrum(m);
  Eigen::Matrix<double, 6, 6> c = Eigen::Matrix<double, 6, 6>::Zero();
  const double most = in.radius * in.radius;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const double size = held.values[k];
    const Eigen::Matrix<double, 6, 1> v = held.vectors.col(k);
    const bool weak = !(size > floor);
    c += (weak ? most : std::min(most, sigma2 / (count * size))) * v * v.transpose();
    if (weak)
      directions.push_back(motion_words(v, axes) +
                           " is weakly held: the scans look the same after it (flat, round or straight)");
  }
  c.topRows<3>() /= in.radius;
  c.leftCols<3>() /= in.radius;
  std::array<double, 36> result{};
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = 0; j < 6; ++j) result[static_cast<std::size_t>(6 * i + j)] = c(i, j);
  return result;
}

}  // namespace isopach
