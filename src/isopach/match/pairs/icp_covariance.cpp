#include "isopach/match/pairs/icp_covariance.hpp"

#include <cmath>
#include <vector>

#include "isopach/base/linear.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/pairs/icp_response.hpp"
#include "isopach/match/sandwich.hpp"

namespace isopach {
namespace {

using Basis = Eigen::Matrix<double, 7, Eigen::Dynamic>;
using Vector = Eigen::Matrix<double, 7, 1>;

constexpr std::size_t points_of_a_cell = 8, most_cells = 4096;

/// What the pairs pull, by runs of points of MOVING. A cell holds as many points of either scan at least.
class PairCells {
 public:
  PairCells(const IcpState& found, const OrientedCloud& moving, const OrientedCloud& fixed, PairKind kind)
      : found_(found), kind_(kind) {
    cell_ = points_of_a_cell;
    while (cell_ * fixed.points.size() < points_of_a_cell * moving.points.size() / 2) cell_ *= 2;
    while (moving.points.size() / cell_ > most_cells) cell_ *= 2;
    cells_.resize((moving.points.size() + cell_ - 1) / cell_);
  }

  [[nodiscard]] std::vector<ScoreCell> take() {
    for (const Link& l : found_.links) add(l, cells_[l.query / cell_]);
    for (const Link& l : found_.back) add(l, cells_[l.partner / cell_]);
    return std::move(cells_);
  }

 private:
  void add(const Link& l, ScoreCell& c) const {
    const Vector7 drawn = pair_row(found_.information, l.moving, pull(l, kind_));
    for (std::size_t k = 0; k < parameters; ++k) c.score[k] -= l.weight * drawn[k];
    add_link(found_.information, l, kind_, c.information);
    c.weight += l.weight, c.x += l.weight * l.moving.x, c.y += l.weight * l.moving.y;
  }

  const IcpState& found_;
  PairKind kind_;
  std::size_t cell_;
  std::vector<ScoreCell> cells_;
};

Basis unit_columns(const Freedom& f) {
  const std::array<bool, 7> free{f.turn_x, f.turn_y, f.turn_z, f.shift_x, f.shift_y, f.shift_z, f.scale};
  Basis basis(7, 0);
  for (int k = 0; k < 7; ++k) {
    if (!free[static_cast<std::size_t>(k)]) continue;
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.col(basis.cols() - 1) = Vector::Unit(k);
  }
  return basis;
}

std::string words(const Vector& v, const std::array<std::string, 3>& axes) {
  std::string text;
  for (int i = 0; i < 7; ++i) {
    if (std::fabs(v(i)) < 0.4) continue;
    if (!text.empty()) text += " with ";
    text +=
        i == 6 ? "scale" : std::string(i < 3 ? "turn about " : "shift along ") + axes[static_cast<std::size_t>(i % 3)];
  }
  return text;
}

}  // namespace

void find_icp_covariance(const IcpState& found, const OrientedCloud& moving, const OrientedCloud& fixed,
                         const MatchOptions& options, const std::array<std::string, 3>& axes, SearchResult& result) {
  const std::vector<ScoreCell> cells = PairCells(found, moving, fixed, pair_kind(options.objective)).take();
  result.covariance = {};
  const double radius = result.radius = found.information.radius;
  double weight = 0;
  Vector pull = Vector::Zero();
  for (const ScoreCell& c : cells) weight += c.weight, pull += Eigen::Map<const Vector>(c.score.data());
  if (!(weight > 0)) return;
  const double unit[7] = {1 / radius, 1 / radius, 1 / radius, 1, 1, 1, 1 / radius};
  const Basis free = unit_columns(options.freedom);
  const Spectrum<Eigen::Dynamic> seen = spectrum(within(free, pair_normal_matrix(found)));
  const double floor = information_floor(moving, fixed) * weight;
  Basis held(7, 0);
  for (int k = 0; k < free.cols(); ++k) {
    const Vector v = from_basis(free, seen.vectors.col(k));
    if (seen.values(k) > floor) {
      held.conservativeResize(Eigen::NoChange, held.cols() + 1);
      held.col(held.cols() - 1) = v;
      continue;
    }
    Twist twist;
    for (int i = 0; i < 7; ++i) twist[static_cast<std::size_t>(i)] = v(i) * unit[i];
    result.undetermined.push_back(twist);
    result.weak_directions.push_back(words(v, axes) +
                                     " is not determined: the scans look the same after it (flat, round or straight)");
  }
  if (held.cols() == 0) return;
  const Eigen::MatrixXd bread = pull_response(found, moving, fixed, options, held);
  const Vector left = from_basis(held, Ldlt(bread).solve(along_basis(held, pull)));  // the step that is left
  const Eigen::Matrix<double, 7, 7> c = sandwich(cells, held, bread) + left * left.transpose();
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 7; ++j) result.covariance[static_cast<std::size_t>(7 * i + j)] = c(i, j) * unit[i] * unit[j];
}

}  // namespace isopach
