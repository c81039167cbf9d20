#include "isopach/apps/evidence.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t query_block = 256;
constexpr double most_sigmas = 5;  // a distance beyond this says no more than this one
constexpr double step = 1.0 / static_cast<double>(Evidence::levels - 1);

/// Where the costs are least, and half their curvature there.
struct Own {
  double blend, certainty;
};
Own own_of(const std::array<double, Evidence::levels>& cost) {
  const auto best = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  if (best == 0) return {0, std::max(0.0, (cost[1] - cost[0]) / (step * step))};
  if (best == Evidence::levels - 1) return {1, std::max(0.0, (cost[best - 1] - cost[best]) / (step * step))};
  const double left = cost[best - 1] - cost[best], right = cost[best + 1] - cost[best];
  const double sum = left + right;
  if (!(sum > 0)) return {static_cast<double>(best) * step, 0};
  return {step * (static_cast<double>(best) + 0.5 * (left - right) / sum), sum / (2 * step * step)};
}

}  // namespace

Evidence::Evidence(const OrientedCloud& model) : model_(model), near_(model.points.size()), cost_(model.points.size()) {
  for_blocks(near_.size(), query_block, [&](std::size_t begin, std::size_t end) {
    std::vector<Index> found;
    for (std::size_t i = begin; i < end; ++i) {
      near_[i].fill(no_index);
      model_.tree->nearest(model_.points[i], neighbours + 1, found);
      std::size_t k = 0;
      for (const Index j : found)
        if (j != i && k < neighbours) near_[i][k++] = j;
    }
  });
  clear();
}

void Evidence::clear() {
  frames_ = 0;
  std::fill(cost_.begin(), cost_.end(), std::array<double, levels>{});
}

void Evidence::add(const OrientedCloud& frame, const Motion& still, const Motion& moving, double sigma, double reach) {
  ++frames_;
  for_blocks(cost_.size(), query_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Point3 a = still.apply(model_.points[i]), b = moving.apply(model_.points[i]);
      for (std::size_t k = 0; k < levels; ++k) {
        const double t = std::min(
            most_sigmas, surface_distance(frame, a + (static_cast<double>(k) * step) * (b - a), reach) / sigma);
        cost_[i][k] += t * t;
      }
    }
  });
}

Array<double> Evidence::blend() const {
  Array<double> own(cost_.size()), certainty(cost_.size());
  for_each_index(cost_.size(), [&](std::size_t i) {
    const Own o = own_of(cost_[i]);
    own[i] = o.blend, certainty[i] = o.certainty;
  });
  // Noise alone makes two sums of squares differ by sqrt(4 frames): what is known no better than that is not known.
  const double stiffness = std::sqrt(4 * static_cast<double>(std::max<std::size_t>(1, frames_))) / (step * step);
  Array<double> field = smooth_field(near_, own, certainty, stiffness, 0);
  for (double& w : field) w = std::clamp(w, 0.0, 1.0);
  return field;
}

Array<double> smooth_field(std::span<const std::array<Index, Evidence::neighbours>> near, std::span<const double> own,
                           std::span<const double> certainty, double stiffness, double lonely) {
  const auto n = static_cast<Eigen::Index>(own.size());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(own.size() * (1 + 4 * Evidence::neighbours));
  Eigen::VectorXd right(n);
  const double slight = 1e-9 * stiffness;  // decides where nothing else does, and keeps the matrix regular
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    entries.emplace_back(i, i, certainty[at] + slight);
    right[i] = certainty[at] * own[at] + slight * lonely;
    for (const Index j : near[at]) {
      if (j == no_index) continue;
      const auto k = static_cast<Eigen::Index>(j);
      entries.emplace_back(i, i, stiffness);
      entries.emplace_back(k, k, stiffness);
      entries.emplace_back(i, k, -stiffness);
      entries.emplace_back(k, i, -stiffness);
    }
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
  const Eigen::VectorXd solution = solver.solve(right);
  return {solution.data(), solution.data() + n};
}

}  // namespace isopach
