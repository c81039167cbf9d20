#include "isopach/match/pairs/icp_response.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/linear.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/sandwich.hpp"

namespace isopach {
namespace {

using Vector = Eigen::Matrix<double, 7, 1>;

constexpr std::size_t most_asked = 8192;
constexpr double step_size = 0.5;                      // standard deviations of the residuals, along the normals
constexpr double least_step = 1e-7, most_step = 0.05;  // of the radius
constexpr double least_response = 0.1;                 // of the normal matrix

class Response {
 public:
  Response(const IcpState& found, const OrientedCloud& moving, const OrientedCloud& fixed, const MatchOptions& options)
      : found_(found),
        options_(options),
        kind_(pair_kind(options.objective)),
        stride_((std::max(moving.points.size(), fixed.points.size()) + most_asked - 1) / most_asked),
        forward_(moving, fixed, false),
        backward_(fixed, moving, true) {}

  struct Pull {
    Vector sum = Vector::Zero();
    double weight = 0;
  };

  /// Of the pairs that the pose finds which is `step` away.
  Pull at(const Vector& step) {
    const double radius = found_.information.radius;
    Twist twist;
    for (Eigen::Index i = 0; i < 7; ++i)
      twist[static_cast<std::size_t>(i)] = i >= 3 && i < 6 ? step(i) : step(i) / radius;
    const Motion motion = moved(found_.motion, twist, found_.information.centre);
    Pull pull;
    add(forward_, motion, pull);
    if (options_.icp.symmetric) add(backward_, motion, pull);
    return pull;
  }

 private:
  void add(PairSearch& search, const Motion& motion, Pull& pull) const {
    Array<Link> links = search.find(motion, stride_, options_.icp, options_.overlap);
    set_weights(links, options_.icp.weights, kind_);
    for (const Link& l : links) {
      const Vector7 row = pair_row(found_.information, l.moving, isopach::pull(l, kind_));
      pull.sum -= l.weight * Eigen::Map<const Vector>(row.data());
      pull.weight += l.weight;
    }
  }

  const IcpState& found_;
  const MatchOptions& options_;
  PairKind kind_;
  std::size_t stride_;
  PairSearch forward_, backward_;
};

struct Totals {
  Symmetric7 normal;
  double weight = 0, squares = 0;  // Σ w, Σ w r² of the distances along the normals
};

Totals totals_of(const IcpState& found, PairKind kind) {
  Totals t;
  const auto add = [&](const Array<Link>& links) {
    for (const Link& l : links) {
      const double r = residual(l, kind);
      add_link(found.information, l, kind, t.normal);
      t.weight += l.weight, t.squares += l.weight * r * r;
    }
  };
  add(found.links), add(found.back);
  return t;
}

}  // namespace

Vector7 pair_row(const PairInformation& information, const Point3& at, const Point3& direction) {
  const Point3 arm = (1 / information.radius) * (at - information.centre), turn = cross(arm, direction);
  return {turn.x, turn.y, turn.z, direction.x, direction.y, direction.z, dot(arm, direction)};
}

void add_link(const PairInformation& information, const Link& l, PairKind kind, Symmetric7& normal) {
  if (kind != PairKind::planes) return normal.add(pair_row(information, l.moving, l.normal), l.weight);
  const Symmetric3 p = precision(l);  // = L D Lᵀ: three distances along the columns of L
  const double b = p.xy / p.xx, c = p.xz / p.xx, second = p.yy - b * p.xy;
  const double d = (p.yz - b * p.xz) / second, third = p.zz - c * p.xz - d * d * second;
  normal.add(pair_row(information, l.moving, {1, b, c}), l.weight * p.xx);
  normal.add(pair_row(information, l.moving, {0, 1, d}), l.weight * second);
  normal.add(pair_row(information, l.moving, {0, 0, 1}), l.weight * third);
}

Eigen::Matrix<double, 7, 7> pair_normal_matrix(const IcpState& found) {
  return matrix(totals_of(found, PairKind::plane).normal);
}

Eigen::MatrixXd pull_response(const IcpState& found, const OrientedCloud& moving, const OrientedCloud& fixed,
                              const MatchOptions& options, const Eigen::Matrix<double, 7, Eigen::Dynamic>& basis) {
  const PairKind kind = pair_kind(options.objective) == PairKind::planes ? PairKind::planes : PairKind::plane;
  const Totals totals = totals_of(found, kind);
  const Eigen::VectorXd size = (basis.transpose() * matrix(totals.normal) * basis).diagonal().cwiseSqrt();
  const double deviation = std::sqrt(totals.squares / totals.weight), radius = found.information.radius;
  Response response(found, moving, fixed, options);
  const double scale = totals.weight / response.at(Vector::Zero()).weight;
  Eigen::MatrixXd ratio(basis.cols(), basis.cols());  // to the normal matrix, which is the unit matrix
  for (Eigen::Index k = 0; k < basis.cols(); ++k) {
    const double wanted = step_size * deviation * std::sqrt(totals.weight) / size(k);
    const Vector step = std::clamp(wanted, least_step * radius, most_step * radius) * basis.col(k);
    const Vector change = (scale / (2 * step.norm())) * (response.at(-step).sum - response.at(step).sum);
    ratio.col(k) = size.cwiseInverse().asDiagonal() * along_basis(basis, change) / size(k);
  }
  const Spectrum<Eigen::Dynamic> axes = spectrum<Eigen::Dynamic>(0.5 * (ratio + ratio.transpose()));
  const Eigen::VectorXd kept = axes.values.cwiseMax(least_response).cwiseMin(1);
  return from_spectrum_scaled(size, axes.vectors, kept);
}

}  // namespace isopach
