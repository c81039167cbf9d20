#include "isopach/match/icp_covariance.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <span>

#include "isopach/distance/vectors.hpp"
#include "isopach/match/sandwich.hpp"

namespace isopach {
namespace {

using Basis = Eigen::Matrix<double, 7, Eigen::Dynamic>;
using Vector = Eigen::Matrix<double, 7, 1>;

constexpr std::size_t points_of_a_cell = 8, most_cells = 4096;
constexpr double near_the_longest = 0.2;  // of it: pairs that a motion may make too long
constexpr double least_curvature = 0.1;

/// What the pairs give together.
struct Totals {
  std::vector<ScoreCell> cells;
  Symmetric7 noise;                   // of the normals, in the information
  double curvature = 0, weights = 0;  // of the loss; Σ w
};

class Pairs {
 public:
  Pairs(const IcpState& found, const OrientedCloud& moving, const OrientedCloud& fixed, bool plane)
      : found_(found), moving_(moving), fixed_(fixed), plane_(plane) {
    // A cell holds as many points of either scan at least.
    cell_ = points_of_a_cell;
    while (cell_ * fixed.points.size() < points_of_a_cell * moving.points.size() / 2) cell_ *= 2;
    while (moving.points.size() / cell_ > most_cells) cell_ *= 2;
    totals_.cells.resize((moving.points.size() + cell_ - 1) / cell_);
  }

  [[nodiscard]] Totals take() {
    add(found_.links, found_.width, fixed_.slope_noise, [](const Link& l) { return l.query; });
    add(found_.back, found_.back_width, moving_.slope_noise, [](const Link& l) { return l.partner; });
    return std::move(totals_);
  }

 private:
  template <class PointOf>
  void add(const Array<Link>& links, double width, double slope_noise, const PointOf& point_of) {
    double longest = 0;
    for (const Link& l : links) longest = std::max(longest, length(l.moving - l.fixed));
    for (const Link& l : links) {
      totals_.weights += l.weight;
      totals_.curvature += l.weight * curvature(l, width, longest);
      add(l, slope_noise, totals_.cells[point_of(l) / cell_]);
    }
  }

  /// Of one pair, as a share of its weight: the biweight bends back, and a pair that gets too long drops out.
  [[nodiscard]] double curvature(const Link& l, double width, double longest) const {
    const Point3 d = l.moving - l.fixed;
    const double along = dot(d, l.normal), size = length(d), u = width > 0 ? residual(l, plane_) / width : 0;
    double c = 1;
    if (width > 0) c -= 4 * along * along / (width * width * (1 - u * u));
    if (size > (1 - near_the_longest) * longest) c -= along * along / (size * near_the_longest * longest);
    return c;
  }

  void add(const Link& l, double slope_noise, ScoreCell& c) {
    const double scale = 1 / found_.information.radius;
    const Point3 arm = scale * (l.moving - found_.information.centre), d = l.moving - l.fixed;
    const auto row = [&](const Point3& n) {
      const Point3 turn = cross(arm, n);
      return Vector7{turn.x, turn.y, turn.z, n.x, n.y, n.z, dot(arm, n)};
    };
    const Vector7 j = row(l.normal), pull = plane_ ? j : row(d);
    const double size = plane_ ? dot(d, l.normal) : 1;
    for (std::size_t k = 0; k < parameters; ++k) c.score[k] -= l.weight * size * pull[k];
    c.information.add(j, l.weight);
    c.weight += l.weight, c.x += l.weight * l.moving.x, c.y += l.weight * l.moving.y;
    const Point3 least = std::fabs(l.normal.x) < std::fabs(l.normal.z) ? Point3{1, 0, 0} : Point3{0, 0, 1};
    const Point3 across = cross(l.normal, least);
    const Point3 one = (1 / length(across)) * across;
    totals_.noise.add(row(one), l.weight * slope_noise);
    totals_.noise.add(row(cross(l.normal, one)), l.weight * slope_noise);
  }

  const IcpState& found_;
  const OrientedCloud &moving_, &fixed_;
  bool plane_;
  std::size_t cell_;
  Totals totals_;
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
  const Totals t = Pairs(found, moving, fixed, options.objective == Objective::icp_plane).take();
  result.covariance = {};
  result.radius = found.information.radius;
  if (!(t.weights > 0)) return;
  Information known;
  Vector gradient = Vector::Zero();
  for (const ScoreCell& c : t.cells) {
    known.h.add(c.information);
    gradient += Eigen::Map<const Vector>(c.score.data());
  }
  known.noise = t.noise;
  const double radius = found.information.radius;
  const double unit[7] = {1 / radius, 1 / radius, 1 / radius, 1, 1, 1, 1 / radius};
  const Basis free = unit_columns(options.freedom);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(free.transpose() * matrix(known.h) * free);
  const double floor = information_floor(moving, fixed) * t.weights;
  Basis held(7, 0);
  for (int k = 0; k < free.cols(); ++k) {
    const Vector v = free * solver.eigenvectors().col(k);
    if (solver.eigenvalues()(k) > floor) {
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
  const double curvature = std::clamp(t.curvature / t.weights, least_curvature, 1.0);
  Eigen::Matrix<double, 7, 7> c = sandwich(t.cells, known, held, curvature);
  if (held.cols() > 0) {  // the step that is left
    const Eigen::MatrixXd h = held.transpose() * matrix(known.h) * held;
    const Vector left = held * h.ldlt().solve(held.transpose() * gradient);
    c += left * left.transpose();
  }
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 7; ++j) result.covariance[static_cast<std::size_t>(7 * i + j)] = c(i, j) * unit[i] * unit[j];
}

}  // namespace isopach
