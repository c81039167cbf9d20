#include "isopach/match/clusters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "isopach/base/linear.hpp"
#include "isopach/match/sandwich.hpp"

namespace isopach {

namespace {

constexpr std::size_t cells_of_a_cluster = 16;
constexpr double clusters_per_parameter = 2;                    // at least: fewer say nothing of a variance
constexpr double beyond_chance = 2;                             // standard deviations of the trace
constexpr double strips_beyond_chance = 3;                      // of twelve partitions the one that says most is taken
constexpr std::array<std::size_t, 3> strip_counts{48, 24, 12};  // across the scans, in each direction
constexpr double wider_is_more = 0.5;  // relative standard deviations by which wider strips must say more to be taken
constexpr Eigen::Index along_heights = 5;  // the parameter that shifts all heights
constexpr double least_left = 0.2;         // of a cluster's leverage: nearly all of what holds a motion lies in it

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Number of the cluster of each cell.
using Partition = std::vector<std::size_t>;

Partition runs_of(std::size_t cells, std::size_t run) {
  Partition p(cells);
  for (std::size_t i = 0; i < cells; ++i) p[i] = i / run;
  return p;
}

/// The cells in coordinates in which the information of all of them together is the unit matrix.
class Whitened {
 public:
  Whitened(std::span<const ScoreCell> cells, const Matrix& basis) : cells_(cells), basis_(basis) {
    const Eigen::Index p = basis.cols();
    Matrix all = Matrix::Zero(p, p);
    for (const ScoreCell& c : cells) all += within(basis, matrix(c.information));
    const Spectrum<Eigen::Dynamic> axes = spectrum(all);
    const double floor = 1e-14 * axes.values.maxCoeff();
    const Vector size = axes.values.cwiseMax(floor);
    to_ = axes.vectors * size.cwiseInverse().cwiseSqrt().asDiagonal();
    back_ = axes.vectors * size.cwiseSqrt().asDiagonal();
    for (const ScoreCell& c : cells) {
      const Vector score = Eigen::Map<const Vector>(c.score.data(), parameters);
      score_.push_back(product_of_transposed(to_, product_of_transposed(basis, score)));
      information_.push_back(within(to_, basis, matrix(c.information)));
    }
  }
  [[nodiscard]] std::size_t count() const { return cells_.size(); }
  [[nodiscard]] Eigen::Index size() const { return to_.cols(); }
  [[nodiscard]] const Matrix& back() const { return back_; }
  [[nodiscard]] const Vector& score(std::size_t i) const { return score_[i]; }
  [[nodiscard]] const Matrix& information(std::size_t i) const { return information_[i]; }

  /// Strips across (x, y), each with a like share of the information.
  [[nodiscard]] Partition strips_across(double x, double y, std::size_t strips) const {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const ScoreCell& c = cells_[i];
      if (c.weight > 0) order.emplace_back((x * c.x + y * c.y) / c.weight, i);
    }
    std::sort(order.begin(), order.end());
    Partition p(cells_.size(), 0);
    double passed = 0;
    for (const auto& [place, i] : order) {
      const double share = information_[i].trace() / static_cast<double>(size());
      p[i] = std::min(strips - 1, static_cast<std::size_t>((passed + share / 2) * static_cast<double>(strips)));
      passed += share;
    }
    return p;
  }

  /// What an offset of 1 of the heights of cell i adds to its score.
  [[nodiscard]] Vector by_offset(std::size_t i) const {
    const Vector within_basis = basis_.transpose() * matrix(cells_[i].information).col(along_heights);
    return product_of_transposed(to_, within_basis);
  }
  [[nodiscard]] double height_score(std::size_t i) const { return cells_[i].score[along_heights]; }
  [[nodiscard]] double height_information(std::size_t i) const {
    return matrix(cells_[i].information)(along_heights, along_heights);
  }

 private:
  std::span<const ScoreCell> cells_;
  Matrix basis_, to_, back_;
  std::vector<Vector> score_;
  std::vector<Matrix> information_;
};

struct Scatter {
  Matrix meat;
  double size = 0;      // mean of its diagonal
  double clusters = 0;  // as many of equal information
};

/// The sums of the clusters, each by its leverage larger than the fit left it.
std::vector<Vector> scores_of(const Whitened& w, const Partition& partition, double& clusters) {
  const Eigen::Index p = w.size();
  const std::size_t count = partition.empty() ? 0 : 1 + *std::max_element(partition.begin(), partition.end());
  std::vector<Vector> score(count, Vector::Zero(p)), corrected;
  std::vector<Matrix> information(count, Matrix::Zero(p, p));
  for (std::size_t i = 0; i < w.count(); ++i) {
    score[partition[i]] += w.score(i);
    information[partition[i]] += w.information(i);
  }
  double squares = 0;
  for (std::size_t b = 0; b < count; ++b) {
    const double share = information[b].trace() / static_cast<double>(p);
    if (!(share > 0)) continue;
    squares += share * share;
    const Spectrum<Eigen::Dynamic> axes = spectrum(information[b]);
    const Vector left = (1 - axes.values.array()).cwiseMax(least_left);
    const Vector own = product_of_transposed(axes.vectors, score[b]);
    corrected.push_back(product(axes.vectors, Vector(own.cwiseQuotient(left.cwiseSqrt()))));
  }
  clusters = squares > 0 ? 1 / squares : 0;
  return corrected;
}

/// Σ s sᵀ over the clusters, drawn to a multiple of the unit matrix by as much as its own scatter says.
Scatter scatter(const Whitened& w, const Partition& partition) {
  const Eigen::Index p = w.size();
  Scatter s{Matrix::Zero(p, p), 0, 0};
  const std::vector<Vector> scores = scores_of(w, partition, s.clusters);
  for (const Vector& v : scores) s.meat += v * v.transpose();
  s.size = s.meat.trace() / static_cast<double>(p);
  if (!(s.size > 0)) return s;
  double by_chance = 0;
  for (const Vector& v : scores) by_chance += (s.clusters * v * v.transpose() - s.meat).squaredNorm();
  by_chance /= s.clusters * s.clusters;
  const Matrix even = s.size * Matrix::Identity(p, p);
  const double uneven = (s.meat - even).squaredNorm();
  const double drawn = uneven > 0 ? std::min(1.0, by_chance / uneven) : 1;
  s.meat = (1 - drawn) * s.meat + drawn * even;
  return s;
}

/// `small`, where along no motion is less than `large` says.
Matrix at_least(const Matrix& small, const Matrix& large) {
  const Spectrum<Eigen::Dynamic> s = spectrum(small);
  const Vector size = s.values.cwiseMax(1e-12 * s.values.maxCoeff()).cwiseSqrt();
  const Matrix root = from_spectrum(s.vectors, size), inverse = from_spectrum(s.vectors, size.cwiseInverse());
  const Spectrum<Eigen::Dynamic> ratio = spectrum(product(product(inverse, large), inverse));
  return from_spectrum_between(root, ratio.vectors, ratio.values.cwiseMax(1));
}

/// How strips differ in height as a whole, and what that adds to the meat: Σ g gᵀ τ², g = ∂score/∂offset. Of the scores
/// of the strips only that of the heights is asked, for one number, the variance τ² of an offset: the outer products of
/// so few sums are too few for a matrix.
struct Offsets {
  Matrix meat;
  double chance = 0;    // standard deviations of what noise makes of the squares
  double relative = 0;  // standard deviation of τ² over itself
};

Offsets offsets_of(const Whitened& w, const Partition& partition, std::size_t strips, const Scatter& small) {
  const auto n = static_cast<Eigen::Index>(strips);
  Matrix by = Matrix::Zero(w.size(), n);
  Vector score = Vector::Zero(n), information = Vector::Zero(n);
  for (std::size_t i = 0; i < w.count(); ++i) {
    const auto strip = static_cast<Eigen::Index>(partition[i]);
    by.col(strip) += w.by_offset(i);
    score(strip) += w.height_score(i), information(strip) += w.height_information(i);
  }
  if (!(information.minCoeff() > 1e-6 * information.maxCoeff())) return {};
  // The fit takes a share of an offset off again: what is left of it in the scores of all strips.
  Matrix left = -product_of_transposed(by, by);
  left.diagonal() += information;
  const Vector root = information.cwiseSqrt().cwiseInverse();
  const Matrix unit = root.asDiagonal() * left * root.asDiagonal();
  const double squares = score.cwiseAbs2().cwiseQuotient(information).sum();
  const double by_noise = small.size * unit.trace(), by_one = (root.asDiagonal() * left).squaredNorm();
  const auto p = static_cast<double>(w.size());
  const double spread =
      std::hypot(small.size * std::sqrt(2 * unit.squaredNorm()), by_noise * std::sqrt(2 / (p * small.clusters)));
  if (!(by_one > 0 && spread > 0)) return {};
  return {std::max(0.0, (squares - by_noise) / by_one) * product_with_transposed(by, by), (squares - by_noise) / spread,
          std::sqrt(2 / unit.trace())};
}

/// Of the strips across four directions, narrow and wide, those that add most; wide ones, of which there are few, only
/// where they add clearly more.
Matrix strip_meat(const Whitened& w, const Scatter& small) {
  constexpr double diagonal = 0.70710678118654752;
  constexpr double directions[4][2] = {{1, 0}, {0, 1}, {diagonal, diagonal}, {diagonal, -diagonal}};
  Matrix best = Matrix::Zero(w.size(), w.size());
  for (const auto& [x, y] : directions) {
    double least = 0;
    for (const std::size_t strips : strip_counts) {
      if (w.count() < 2 * strips) continue;
      const Offsets o = offsets_of(w, w.strips_across(x, y, strips), strips, small);
      if (!(o.chance > strips_beyond_chance)) continue;
      const double size = o.meat.trace();
      if (size > best.trace() && size > least * (1 + wider_is_more * o.relative)) best = o.meat;
      least = size;
    }
  }
  return best;
}

Matrix meat_of(const Whitened& w) {
  const auto p = static_cast<double>(w.size());
  std::size_t run = cells_of_a_cluster;
  Scatter small = scatter(w, runs_of(w.count(), run));
  while (run > 1 && small.clusters < clusters_per_parameter * p) small = scatter(w, runs_of(w.count(), run /= 2));
  if (!(small.size > 0)) return small.meat;
  Matrix best = small.meat;
  double largest = 1;
  while ((run *= 2) < 2 * w.count()) {
    const Scatter s = scatter(w, runs_of(w.count(), run));
    if (s.clusters < clusters_per_parameter * p) break;
    const double ratio = s.size / small.size, chance = std::sqrt(2 / (p * s.clusters) + 2 / (p * small.clusters));
    if (ratio > 1 + beyond_chance * chance && ratio > largest) largest = ratio, best = at_least(small.meat, s.meat);
  }
  return at_least(best, small.meat + strip_meat(w, small));
}

}  // namespace

Symmetric7 clustered_scores(std::span<const ScoreCell> cells, std::span<const Vector7> basis) {
  Symmetric7 result;
  if (cells.empty() || basis.empty()) return result;
  Matrix columns(parameters, basis.size());
  for (std::size_t c = 0; c < basis.size(); ++c)
    columns.col(static_cast<Eigen::Index>(c)) = Eigen::Map<const Vector>(basis[c].data(), parameters);
  double information = 0;
  for (const ScoreCell& c : cells) information += matrix(c.information).trace();
  if (!(information > 0)) return result;
  const Whitened w(cells, columns);
  const Matrix meat = outside(columns, w.back(), meat_of(w));
  std::size_t i = 0;
  for (int r = 0; r < meat.rows(); ++r)
    for (int c = r; c < meat.cols(); ++c) result.m[i++] = meat(r, c);
  return result;
}

}  // namespace isopach
