#include "isopach/match/search.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "isopach/base/parallel.hpp"

namespace isopach {

namespace {

using Matrix = Eigen::Matrix<double, 7, 7>;
using Vector = Eigen::Matrix<double, 7, 1>;

constexpr std::size_t coarsest_nodes = 600;  // of the smoothest level
constexpr std::size_t level_factor = 8;
constexpr double unobserved_ratio = 3;      // information below this many times what noise alone gives is none
constexpr double unobserved = 1e-9;         // … and below this share of the largest
constexpr double weak = 1e-3;               // information below this share of the largest is named
constexpr double least_overlap_kept = 0.5;  // of the common area: a step may not shrink it further

Matrix matrix(const Symmetric7& s) {
  Matrix m;
  std::size_t i = 0;
  for (int r = 0; r < 7; ++r)
    for (int c = r; c < 7; ++c) m(r, c) = m(c, r) = s.m[i++];
  return m;
}
Vector vector(const Vector7& v) { return Eigen::Map<const Vector>(v.data()); }

/// The motions that are asked for and that the scans determine: columns that span them.
using Basis = Eigen::Matrix<double, 7, Eigen::Dynamic>;

Basis basis_of(const Freedom& f) {
  const bool free[7] = {f.turn_x, f.turn_y, f.turn_z, f.shift_x, f.shift_y, f.shift_z, f.scale};
  Basis basis(7, 0);
  for (int k = 0; k < 7; ++k) {
    if (!free[k]) continue;
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.col(basis.cols() - 1) = Vector::Unit(k);
  }
  return basis;
}

struct State {
  Motion motion;
  ResidualSums sums;
};

double mean_loss(const ResidualSums& s) { return s.trusted > 0 ? s.loss / s.trusted : 0; }

// The mean loss of `s`, where the area that it has less than `before` counts as it did before: losing overlap is no
// gain.
double guarded_loss(const ResidualSums& s, const ResidualSums& before) {
  const double lost = std::max(0.0, before.trusted - s.trusted);
  if (!(s.trusted > 0)) return std::numeric_limits<double>::infinity();
  return (s.loss + lost * mean_loss(before)) / (s.trusted + lost);
}

class Search {
 public:
  Search(Residuals& residuals, const Basis& basis, const Context& context)
      : r_(residuals), basis_(basis), context_(context) {}

  Loss loss;
  State at;
  int evaluations = 0, accepted = 0;
  std::vector<MatchStep>* history = nullptr;
  std::string stuck;  // why the last descend ended without small steps

  void start(const Motion& motion) {
    at = {motion, r_.evaluate(motion, loss, context_)};
    ++evaluations;
  }

  /// Damped Gauss-Newton steps with fixed weights of patches and scale, at most `most`. The length of the last
  /// accepted step; 0 where none lowers the loss.
  double descend(int most, double tolerance) {
    double damping = 0, last = 0;
    stuck.clear();
    for (int i = 0; i < most; ++i) {
      bool done = false;
      for (;;) {
        const Vector step = newton_step(damping);
        const double length = step.norm();
        if (!(length > 0) || !std::isfinite(length)) return last;
        Vector7 s;
        Eigen::Map<Vector>(s.data()) = step;
        State next{moved(at.motion, r_.twist(s), r_.centre()), {}};
        next.sums = r_.evaluate(next.motion, loss, context_);
        ++evaluations;
        const bool overlaps = next.sums.area >= least_overlap_kept * at.sums.area;
        if (overlaps && guarded_loss(next.sums, at.sums) <= mean_loss(at.sums)) {
          at = std::move(next);
          last = length;
          ++accepted;
          note();
          damping = damping > 1e-3 ? damping / 10 : 0;
          done = length < tolerance;
          break;
        }
        if (length < tolerance) return length;  // as near as the rounding of the sums lets it
        damping = std::max(1e-3, damping * 10);
        if (damping > 1e6) {
          stuck = "no step lowers the measure";
          return 0;
        }
      }
      if (done) return last;
    }
    return last;
  }

  void note() {
    if (history == nullptr) return;
    const ResidualSums& s = at.sums;
    history->push_back({s.within > 0 ? s.volume / s.within : 0, s.fitted > 0 ? std::sqrt(s.squares / s.fitted) : 0,
                        s.area > 0 ? s.within / s.area : 0});
  }

 private:
  [[nodiscard]] Vector newton_step(double damping) const {
    if (basis_.cols() == 0) return Vector::Zero();
    Eigen::MatrixXd h = basis_.transpose() * matrix(at.sums.h) * basis_;
    const Eigen::VectorXd b = basis_.transpose() * vector(at.sums.b);
    h.diagonal() += (damping + 1e-14) * h.trace() * Eigen::VectorXd::Ones(h.rows());
    return basis_ * h.ldlt().solve(b);
  }

  Residuals& r_;
  const Basis& basis_;
  const Context& context_;
};

/// One pair of surfaces of the same thinness.
struct Level {
  const MatchSurface *moving, *fixed;
  bool finest;
};

double extent_of(const MatchSurface& s) {
  Box2 box;
  for (const Point2& p : s.xy) box.add(p);
  return box.empty() ? 0 : std::hypot(box.max.x - box.min.x, box.max.y - box.min.y);
}

Point3 centre_of(const MatchSurface& s) {
  Point3 sum{0, 0, 0};
  double area = 0;
  for (std::size_t i = 0; i < s.xy.size(); ++i) {
    const double w = s.weight[i];
    sum = {sum.x + w * s.xy[i].x, sum.y + w * s.xy[i].y, sum.z + w * s.z[i]};
    area += w;
  }
  return area > 0       ? Point3{sum.x / area, sum.y / area, sum.z / area}
         : s.xy.empty() ? Point3{0, 0, 0}
                        : Point3{s.xy[0].x, s.xy[0].y, s.z[0]};
}

struct Weak {
  Vector direction;
  double share;  // of the largest information
  bool noise;    // no more than noise gives
};

// Eigenvectors of the information within `basis` that hold less than they should.
std::vector<Weak> weak_within(const Information& info, const Basis& basis, bool against_noise) {
  std::vector<Weak> found;
  if (basis.cols() == 0) return found;
  const Eigen::MatrixXd h = basis.transpose() * matrix(info.h) * basis;
  const Eigen::MatrixXd noise = basis.transpose() * matrix(info.noise) * basis;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(h);
  const double largest = solver.eigenvalues().maxCoeff();
  for (int k = 0; k < h.cols(); ++k) {
    const Eigen::VectorXd v = solver.eigenvectors().col(k);
    const double own = solver.eigenvalues()(k), by_noise = v.dot(noise * v);
    const bool none = !(own > unobserved * largest) || (against_noise && own < unobserved_ratio * by_noise);
    if (none || own < weak * largest) found.push_back({basis * v, largest > 0 ? own / largest : 0, none});
  }
  return found;
}

std::string words(const Weak& w, const std::array<std::string, 3>& axes) {
  const std::string names[7] = {"turn about " + axes[0],
                                "turn about " + axes[1],
                                "turn about " + axes[2],
                                "shift along " + axes[0],
                                "shift along " + axes[1],
                                "shift along " + axes[2],
                                "scale"};
  std::vector<int> order;
  const double largest = w.direction.cwiseAbs().maxCoeff();
  for (int k = 0; k < 7; ++k)
    if (std::fabs(w.direction(k)) > 0.4 * largest) order.push_back(k);
  std::sort(order.begin(), order.end(),
            [&](int i, int j) { return std::fabs(w.direction(i)) > std::fabs(w.direction(j)); });
  std::string text;
  for (const int k : order) text += (text.empty() ? "" : " with ") + names[k];
  return text;
}

}  // namespace

SearchResult search(const MatchSurface& moving, const MatchSurface& fixed, const MatchOptions& options,
                    const std::array<std::string, 3>& axes, const Context& context) {
  SearchResult result;
  const double extent = std::max(extent_of(fixed), extent_of(moving));
  const double tolerance = (options.tolerance > 0 ? options.tolerance : default_match_tolerance) * extent;
  const double floor = 1e-12 * extent;  // of scales: identical scans have no residuals
  const bool trim = options.compare.border == BorderRule::trim;
  result.centre = centre_of(moving);

  // Copies of both surfaces, ever thinner.
  std::vector<std::array<MatchSurface, 2>> copies;
  std::vector<std::size_t> runs;
  const std::size_t most = std::max(moving.xy.size(), fixed.xy.size());
  for (std::size_t run = level_factor; most / run >= coarsest_nodes; run *= level_factor) runs.push_back(run);
  copies.resize(runs.size());
  for (std::size_t k = 0; k < runs.size(); ++k)
    both(
        [&] {
          copies[k][0] = thinned(moving.xy, moving.z,
                                 std::min(runs[k], std::max<std::size_t>(1, moving.xy.size() / 64)), trim, context);
        },
        [&] {
          copies[k][1] = thinned(fixed.xy, fixed.z, std::min(runs[k], std::max<std::size_t>(1, fixed.xy.size() / 64)),
                                 trim, context);
        });
  std::vector<Level> levels;
  for (std::size_t k = runs.size(); k-- > 0;) levels.push_back({&copies[k][0], &copies[k][1], false});
  levels.push_back({&moving, &fixed, true});

  Basis basis = basis_of(options.freedom);
  Motion motion;
  const bool everything = options.overlap == 1;
  std::vector<Weak> frozen;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const Level& level = levels[k];
    Residuals residuals(*level.moving, *level.fixed, result.centre, extent / 4);
    Search s(residuals, basis, context);
    s.loss = {Loss::Kind::huber, std::numeric_limits<double>::max()};
    if (level.finest) s.history = &result.history;
    s.start(motion);
    if (!(s.at.sums.area > 0)) {
      if (!level.finest) continue;
      throw OverlapError(
          "the scans do not overlap at the start: check their coordinate systems, give a start with "
          "--start, or let one be found with --coarse");
    }
    const double level_tolerance = level.finest ? tolerance : 1e-6 * extent;
    const auto reweigh = [&](Loss::Kind kind, bool trust) {
      s.loss.kind = kind;
      s.loss.scale = std::max(floor, residuals.spread());
      if (everything || !trust) {
        residuals.trust_all();
      } else if (options.overlap > 0) {
        residuals.trust_share(options.overlap);
      } else {
        residuals.trust_by_mean();
      }
      s.start(s.at.motion);
    };
    const auto settle = [&](Loss::Kind kind, bool trust, int rounds, int steps, double until) {
      for (int i = 0; i < rounds && s.evaluations < options.max_iterations * 4; ++i) {
        reweigh(kind, trust);
        if (s.descend(steps, until) < until) return true;
      }
      return false;
    };
    if (!level.finest || levels.size() == 1) {
      settle(Loss::Kind::huber, false, 20, 3, 1e-4 * extent);
      if (k == 0) {  // what the smoothest level does not hold is not searched for on finer ones
        const Information info =
            residuals.information(s.at.motion, s.loss, std::max(floor, residuals.spread()), context);
        for (const Weak& w : weak_within(info, basis, true)) {
          if (!w.noise) continue;
          frozen.push_back(w);
          const Basis old = basis;
          const Vector& v = w.direction;
          Basis rest(7, 0);
          for (int c = 0; c < old.cols(); ++c) {
            Vector column = old.col(c) - v * v.dot(old.col(c));
            for (int d = 0; d < rest.cols(); ++d) column -= rest.col(d) * rest.col(d).dot(column);
            if (column.norm() < 1e-6) continue;
            rest.conservativeResize(Eigen::NoChange, rest.cols() + 1);
            rest.col(rest.cols() - 1) = column.normalized();
          }
          basis = rest;
        }
        if (!frozen.empty()) s.start(Motion{}), settle(Loss::Kind::huber, false, 20, 3, 1e-4 * extent);
      }
    }
    if (everything) {
      settle(Loss::Kind::huber, false, 6, 3, level_tolerance * 100);
    } else {
      settle(Loss::Kind::tukey, true, 8, 2, level_tolerance * 100);
    }
    if (level.finest) {  // one fixed objective to the end
      reweigh(everything ? Loss::Kind::huber : Loss::Kind::tukey, true);
      result.history.clear();
      s.note();
      const int before = s.accepted;
      const double last = s.descend(options.max_iterations, tolerance);
      result.converged = last < tolerance || s.stuck.size() > 0;
      result.reason = !s.stuck.empty() ? s.stuck
                      : result.converged
                          ? fmt::format("the last step moved the scan by {:.1e} of its extent", last / extent)
                          : fmt::format("stopped after {} steps (--max-iterations)", s.accepted - before);
      result.overlap = s.at.sums.area > 0 ? s.at.sums.within / s.at.sums.area : 0;
      const Information info = residuals.information(s.at.motion, s.loss, s.loss.scale, context);
      const Basis all = basis_of(options.freedom);
      for (const Weak& w : frozen)
        result.weak_directions.push_back(words(w, axes) +
                                         " is not determined by the scans and was left as it was at the start");
      for (const Weak& w : weak_within(info, basis, false))
        result.weak_directions.push_back(words(w, axes) + " is weakly held: it carries " +
                                         fmt::format("{:.1g}", w.share) +
                                         " of the information of the strongest motion");
      const Eigen::MatrixXd h = basis.transpose() * matrix(info.h) * basis;
      const Eigen::MatrixXd score = basis.transpose() * matrix(info.score) * basis;
      if (h.cols() > 0) {
        const Eigen::MatrixXd inverse = h.ldlt().solve(Eigen::MatrixXd::Identity(h.rows(), h.cols()));
        const Matrix covariance = 2 * basis * inverse * score * inverse * basis.transpose();
        const double l = residuals.length();
        const double unit[7] = {1 / l, 1 / l, 1 / l, 1, 1, 1, 1 / l};
        for (int i = 0; i < 7; ++i)
          for (int j = 0; j < 7; ++j)
            result.covariance[static_cast<std::size_t>(7 * i + j)] = covariance(i, j) * unit[i] * unit[j];
      }
      result.stable.resize(moving.xy.size());
      for (std::size_t i = 0; i < moving.xy.size(); ++i) result.stable[i] = residuals.fitted(i, s.loss) ? 1 : 0;
    }
    motion = s.at.motion;
    result.iterations += s.accepted;
  }
  result.motion = motion;
  return result;
}

}  // namespace isopach
