#include "isopach/distance/m3c2.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/distance/point_tree.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double two_sided_95 = 1.96;
constexpr std::size_t core_block = 64;
constexpr double most_balls = 64;

struct Statistics {
  std::size_t n = 0;
  double mean = 0, sigma = 0;
};

/// In ascending order, so that the sums do not depend on the order of the points.
Statistics statistics(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  Sum sum, squares;
  for (const double v : values) sum.add(v);
  const auto n = static_cast<double>(values.size());
  const double mean = sum.value() / n;
  for (const double v : values) squares.add((v - mean) * (v - mean));
  return {values.size(), mean, std::sqrt(squares.value() / n)};
}

/// The clouds and room for what is found in them, reused from core to core.
class Sampler {
 public:
  Sampler(std::span<const Point3> points, const PointTree& tree) : points_(points), tree_(tree) {}

  std::optional<Point3> normal(const Point3& core, double radius) {
    found_.clear();
    tree_.within(core, radius, found_);
    if (found_.size() < 3) return std::nullopt;
    sort_found();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Index i : found_) mean += vector(points_[i] - core);
    mean /= static_cast<double>(found_.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const Index i : found_) {
      const Eigen::Vector3d d = vector(points_[i] - core) - mean;
      scatter += d * d.transpose();
    }
    const Spectrum<3> axes = spectrum(scatter);
    const Eigen::Vector3d& sizes = axes.values;
    if (!(sizes[1] > 1e-12 * sizes[2])) return std::nullopt;
    const Eigen::Vector3d n = axes.vectors.col(0);
    return n[2] < 0 ? Point3{-n[0], -n[1], -n[2]} : Point3{n[0], n[1], n[2]};
  }

  /// Distances along the normal of the points in the cylinder. A long one is gone along from ball to ball, each seeing
  /// to its own stretch.
  Statistics in_cylinder(const Point3& core, const Point3& normal, double radius, double depth) {
    along_.clear();
    const double balls = std::clamp(std::ceil(depth / radius), 1.0, most_balls), half = depth / balls;
    const double reach = std::sqrt(radius * radius + half * half) * (1 + 1e-9);
    for (double k = 0; k < balls; ++k) {
      const bool first = k == 0, last = k + 1 == balls;
      const double middle = (2 * k + 1) * half - depth;
      const double from = first ? -depth : 2 * k * half - depth, to = last ? depth : 2 * (k + 1) * half - depth;
      found_.clear();
      tree_.within(core + middle * normal, reach, found_);
      for (const Index i : found_) {
        const Point3 d = points_[i] - core;
        const double t = dot(d, normal);
        const bool here = t >= from && (last ? t <= to : t < to);
        if (here && squared_length(d - t * normal) <= radius * radius) along_.push_back(t);
      }
    }
    return along_.empty() ? Statistics{} : statistics(along_);
  }

 private:
  static Eigen::Vector3d vector(const Point3& p) { return {p.x, p.y, p.z}; }
  void sort_found() {
    std::sort(found_.begin(), found_.end(), [this](Index i, Index j) {
      const Point3 &p = points_[i], &q = points_[j];
      if (p.x != q.x) return p.x < q.x;
      return p.y != q.y ? p.y < q.y : p.z < q.z;
    });
  }

  std::span<const Point3> points_;
  const PointTree& tree_;
  std::vector<Index> found_;
  std::vector<double> along_;
};

void clear(M3c2Field& field, std::size_t i) {
  field.distance[i] = field.lod[i] = field.sigma1[i] = field.sigma2[i] = nan;
  field.significant[i] = field.n1[i] = field.n2[i] = 0;
  field.normal[i] = {nan, nan, nan};
}

void measure_core(Sampler& first, Sampler& second, const Point3& core, const M3c2Options& o, M3c2Field& field,
                  std::size_t i) {
  clear(field, i);
  const std::optional<Point3> normal = first.normal(core, o.normal_scale / 2);
  if (!normal) return;
  field.normal[i] = *normal;
  const Statistics s1 = first.in_cylinder(core, *normal, o.projection_scale / 2, o.max_depth);
  const Statistics s2 = second.in_cylinder(core, *normal, o.projection_scale / 2, o.max_depth);
  field.n1[i] = static_cast<double>(s1.n), field.n2[i] = static_cast<double>(s2.n);
  if (s1.n > 0) field.sigma1[i] = s1.sigma;
  if (s2.n > 0) field.sigma2[i] = s2.sigma;
  if (s1.n == 0 || s2.n == 0) return;
  field.distance[i] = s2.mean - s1.mean;
  if (s1.n < m3c2_least || s2.n < m3c2_least) return;
  field.lod[i] = two_sided_95 * (std::sqrt(s1.sigma * s1.sigma / field.n1[i] + s2.sigma * s2.sigma / field.n2[i]) +
                                 o.registration_error);
  field.significant[i] = std::fabs(field.distance[i]) > field.lod[i] ? 1 : 0;
}

}  // namespace

M3c2Field m3c2(std::span<const Point3> first, std::span<const Point3> second, std::span<const Point3> cores,
               const M3c2Options& options, const Context& context) {
  context.check();
  std::unique_ptr<PointTree> tree1, tree2;
  both([&] { tree1 = std::make_unique<PointTree>(first); }, [&] { tree2 = std::make_unique<PointTree>(second); });
  M3c2Field field;
  for (Array<double>* values :
       {&field.distance, &field.lod, &field.significant, &field.sigma1, &field.sigma2, &field.n1, &field.n2})
    values->resize(cores.size());
  field.normal.resize(cores.size());
  for_blocks(cores.size(), core_block, [&](std::size_t begin, std::size_t end) {
    Sampler sampler1(first, *tree1), sampler2(second, *tree2);
    for (std::size_t i = begin; i < end; ++i) measure_core(sampler1, sampler2, cores[i], options, field, i);
  });
  return field;
}

}  // namespace isopach
