#include "isopach/match/surface/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/match/sandwich.hpp"

namespace isopach {

namespace {

using Matrix = Eigen::Matrix<double, 7, 7>;
using Vector = Eigen::Matrix<double, 7, 1>;

constexpr std::size_t coarsest_nodes = 600;  // of the smoothest level
constexpr std::size_t level_factor = 8;
constexpr double unobserved_ratio = 1.5;       // information below this many times what noise alone gives is none
constexpr double unobserved = 1e-9;            // … and below this share of the largest
constexpr double weak = 1e-3;                  // information below this share of the largest is named
constexpr double negligible = 0.02;            // step over standard deviation: the search ends before it
constexpr double negligible_of_many = 0.1;     // … where a step costs time
constexpr double rejected = 2.5;               // a step that does not lower the loss ends it below so many of those
constexpr double least_curvature = 0.55;       // of the loss over its weights, as a step takes it: less would overshoot
constexpr double least_known_curvature = 0.1;  // … and as the covariance takes it
constexpr std::size_t sample_stride = 8;       // before all nodes of the scans themselves every eighth patch
constexpr std::size_t sampled_nodes = 20000;   // from so many nodes on
constexpr double least_overlap_kept = 0.5;     // of the common area: a step may not shrink it further

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

/// Damped Gauss-Newton steps on one pair of surfaces.
class Solver {
 public:
  Solver(Residuals& residuals, const Basis& basis, const Context& context)
      : r_(residuals), basis_(basis), context_(context) {}

  Loss loss{Loss::Kind::huber, std::numeric_limits<double>::max()};
  double negligible = 0;       // a step of less standard deviations is not made: the descent ends
  double rejected_within = 0;  // … and one of less that does not lower the loss ends it too
  bool trust_follows = false;  // after each step come new weights of the patches
  State at;
  int evaluations = 0, accepted = 0;
  std::vector<MatchStep>* history = nullptr;
  std::string stuck;          // why the last descend ended without small steps
  bool within_noise = false;  // … or with one that is nothing beside the noise

  /// `equations` false: new weights come before the first step.
  void start(const Motion& motion, bool equations = true) {
    at = {motion, r_.evaluate(motion, loss, context_, equations)};
    ++evaluations;
    is_fresh_ = true;
  }

  /// New sums of `at` where only weights have changed.
  void reweigh() {
    if (!is_fresh_) return start(at.motion);
    at.sums = r_.reweighed(at.motion, loss, context_);
    ++evaluations;
  }

  /// The residuals of `at`, whatever was tried last.
  void refresh() {
    if (!is_fresh_) start(at.motion);
  }

  /// With fixed weights of patches and scale, at most `most` steps. The length of the last step; 0 where none lowers
  /// the loss.
  double descend(int most, double tolerance) {
    double damping = 0, last = 0;
    stuck.clear(), within_noise = false;
    for (int i = 0; i < most; ++i) {
      bool done = false;
      for (;;) {
        const Vector step = newton_step(damping);
        const double length = step.norm(), deviations = in_deviations(step);
        if (!(length > 0) || !std::isfinite(length)) return last;
        within_noise = deviations < negligible;
        if (within_noise) return length;
        if (try_step(step)) {
          last = length;
          damping = damping > 1e-3 ? damping / 10 : 0;
          done = length < tolerance;
          break;
        }
        if (length < tolerance) return length;  // as near as the rounding of the sums lets it
        // The loss of facets with noise is rough: that the step does not lower it says no more than that it is short.
        within_noise = deviations < rejected_within;
        if (within_noise) return length;
        damping = std::max(1e-3, damping * 30);
        if (damping > 1e6) {
          stuck = "no step lowers the measure";
          return 0;
        }
      }
      if (done) return last;
    }
    return last;
  }

  /// Of the loss over its weights: the size of Gauss-Newton's matrix over that of Newton's, with normal noise.
  [[nodiscard]] double curvature(bool with_trust, double least = least_curvature) const {
    const ResidualSums& s = at.sums;
    if (!(s.fitted > 0)) return 1;
    // What trust takes is taken of the pull of a patch, which grows with its mean by as much as the loss bends.
    const double of_trust = with_trust ? 1 + s.bend / s.fitted : 1;
    return std::clamp(s.curvature / s.fitted * of_trust, least, 1.0);
  }

  void note() {
    if (history == nullptr) return;
    const ResidualSums& s = at.sums;
    history->push_back({s.within > 0 ? s.volume / s.within : 0, s.fitted > 0 ? std::sqrt(s.squares / s.fitted) : 0,
                        s.area > 0 ? s.within / s.area : 0});
  }

 private:
  bool try_step(const Vector& step) {
    Vector7 s;
    Eigen::Map<Vector>(s.data()) = step;
    State next{moved(at.motion, r_.twist(s), r_.centre()), {}};
    next.sums = r_.evaluate(next.motion, loss, context_, !trust_follows);
    ++evaluations;
    const bool overlaps = next.sums.area >= least_overlap_kept * at.sums.area;
    is_fresh_ = overlaps && guarded_loss(next.sums, at.sums) <= mean_loss(at.sums);
    if (!is_fresh_) return false;
    at = std::move(next);
    ++accepted;
    note();
    return true;
  }

  // The step over the standard deviation that the noise of the nodes gives it: of the order of 1 from one pair of scans
  // to another.
  [[nodiscard]] double in_deviations(const Vector& step) const {
    const ResidualSums& s = at.sums;
    if (!(loss.scale > 0) || s.nodes == 0) return std::numeric_limits<double>::infinity();
    const double information = step.dot(matrix(s.h) * step) * static_cast<double>(s.nodes) / s.area;
    return std::sqrt(std::max(0.0, information)) / loss.scale;
  }

  // Undamped, h is divided by how much of it is curvature of the loss: with normal noise the step is then Newton's own.
  [[nodiscard]] Vector newton_step(double damping) const {
    if (basis_.cols() == 0) return Vector::Zero();
    Eigen::MatrixXd h = within(basis_, matrix(at.sums.h));
    const Eigen::VectorXd b = along_basis(basis_, vector(at.sums.b));
    if (damping == 0 && loss.kind == Loss::Kind::tukey) h *= curvature(trust_follows);
    h.diagonal() += (damping + 1e-14) * h.trace() * Eigen::VectorXd::Ones(h.rows());
    return from_basis(basis_, Ldlt(h).solve(b));
  }

  Residuals& r_;
  const Basis& basis_;
  const Context& context_;
  bool is_fresh_ = false;
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

double largest_within(const Information& info, const Basis& basis) {
  if (basis.cols() == 0) return 0;
  return eigenvalues(within(basis, matrix(info.h))).maxCoeff();
}

// Eigenvectors of the information within `basis` that hold less than they should, of `largest` (the most that any
// motion holds).
std::vector<Weak> weak_within(const Information& info, const Basis& basis, double largest, bool against_noise) {
  std::vector<Weak> found;
  if (basis.cols() == 0) return found;
  const Eigen::MatrixXd noise = within(basis, matrix(info.noise));
  const Spectrum<Eigen::Dynamic> axes = spectrum(within(basis, matrix(info.h)));
  for (int k = 0; k < axes.values.size(); ++k) {
    const Eigen::VectorXd v = axes.vectors.col(k);
    const double own = axes.values(k), by_noise = v.dot(product(noise, v));
    const bool none = !(own > unobserved * largest) || (against_noise && own < unobserved_ratio * by_noise);
    if (none || own < weak * largest) found.push_back({from_basis(basis, v), largest > 0 ? own / largest : 0, none});
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

/// Both surfaces, and copies of them that are ever thinner.
class Levels {
 public:
  Levels(const MatchSurface& moving, const MatchSurface& fixed, bool trim, bool sampled, const Context& context)
      : moving_(moving), fixed_(fixed) {
    std::vector<std::size_t> runs;
    const std::size_t most = std::max(moving.xy.size(), fixed.xy.size());
    // Where the scans themselves are sampled first, their sample takes the place of the densest copies.
    constexpr std::size_t thin = level_factor * level_factor;
    const std::size_t first = sampled && most / thin >= coarsest_nodes ? thin : level_factor;
    for (std::size_t run = first; most / run >= coarsest_nodes; run *= level_factor) runs.push_back(run);
    copies_.resize(runs.size());
    const auto copy = [&](const MatchSurface& s, std::size_t run) {
      return thinned(s, std::min(run, std::max<std::size_t>(1, s.xy.size() / 64)), trim, context);
    };
    for (std::size_t k = 0; k < runs.size(); ++k)
      both([&] { copies_[k][0] = copy(moving, runs[k]); }, [&] { copies_[k][1] = copy(fixed, runs[k]); });
  }
  /// From 0, the thinnest, to the scans themselves.
  [[nodiscard]] std::size_t count() const { return copies_.size() + 1; }
  [[nodiscard]] bool is_finest(std::size_t level) const { return level == copies_.size(); }
  [[nodiscard]] const MatchSurface& moving(std::size_t level) const {
    return is_finest(level) ? moving_ : copies_[copies_.size() - 1 - level][0];
  }
  [[nodiscard]] const MatchSurface& fixed(std::size_t level) const {
    return is_finest(level) ? fixed_ : copies_[copies_.size() - 1 - level][1];
  }

 private:
  const MatchSurface &moving_, &fixed_;
  std::vector<std::array<MatchSurface, 2>> copies_;
};

// `basis` without the direction v.
Basis without(const Basis& basis, const Vector& v) {
  Basis rest(7, 0);
  for (int c = 0; c < basis.cols(); ++c) {
    Vector column = basis.col(c) - v * v.dot(basis.col(c));
    for (int d = 0; d < rest.cols(); ++d) column -= rest.col(d) * rest.col(d).dot(column);
    if (column.norm() < 1e-6) continue;
    rest.conservativeResize(Eigen::NoChange, rest.cols() + 1);
    rest.col(rest.cols() - 1) = column.normalized();
  }
  return rest;
}

class Search {
 public:
  Search(const MatchSurface& moving, const MatchSurface& fixed, const MatchOptions& options,
         const std::array<std::string, 3>& axes, const Context& context)
      : moving_(moving),
        options_(options),
        axes_(axes),
        context_(context),
        fixed_nodes_(fixed.xy.size()),
        extent_(std::max(extent_of(fixed), extent_of(moving))),
        centre_(centre_of(moving)),
        levels_(moving, fixed, options.compare.border == BorderRule::trim, is_sampled(), context),
        basis_(basis_of(options.freedom)) {}

  SearchResult run() {
    doubtful_ = basis_;
    pass();
    if (doubtful_.cols() > 0) {  // once more without what no level holds: it stays as it was at the start
      frozen_ = doubtful_;
      for (int c = 0; c < frozen_.cols(); ++c) basis_ = without(basis_, frozen_.col(c));
      result_ = {};
      motion_ = {};
      pass();
    }
    result_.motion = motion_;
    return std::move(result_);
  }

 private:
  [[nodiscard]] bool everything() const { return options_.overlap == 1; }
  /// Of scales: identical scans have no residuals.
  [[nodiscard]] double floor() const { return 1e-12 * extent_; }

  [[nodiscard]] bool is_sampled() const { return std::min(moving_.xy.size(), fixed_nodes_) >= sampled_nodes; }

  // Scale of the loss and trust in the patches from the residuals; `bounded`: what differs more than noise is left out.
  void reweigh(Residuals& residuals, Solver& s, bool bounded) const {
    s.loss = {bounded ? Loss::Kind::tukey : Loss::Kind::huber, std::max(floor(), residuals.spread())};
    if (!bounded) {
      residuals.trust_all();
    } else if (options_.overlap > 0) {
      residuals.trust_share(options_.overlap);
    } else {
      residuals.trust_by_mean();
    }
    s.reweigh();
  }

  // Rounds of weights and steps until a step is less than `until`.
  void settle(Residuals& residuals, Solver& s, bool bounded, int rounds, int steps, double until) const {
    for (int i = 0; i < rounds && s.evaluations < options_.max_iterations * 4; ++i) {
      s.refresh();
      reweigh(residuals, s, bounded);
      s.trust_follows = steps == 1;
      const double last = s.descend(steps, until);
      s.trust_follows = false;
      if (last < until) return;
    }
  }

  // All levels, from the thinnest to the scans themselves.
  void pass() {
    result_.centre = centre_;
    result_.radius = extent_ / 4;
    for (std::size_t k = 0; k < levels_.count(); ++k) {
      Residuals residuals(levels_.moving(k), levels_.fixed(k), centre_, extent_ / 4);
      Solver s(residuals, basis_, context_);
      if (levels_.is_finest(k) && is_sampled()) residuals.sample(sample_stride);
      s.start(motion_, false);
      if (!(s.at.sums.area > 0)) {
        if (!levels_.is_finest(k)) continue;
        throw OverlapError(
            "the scans do not overlap at the start: check their coordinate systems, give a start with "
            "@start, or let one be found with @coarse");
      }
      if (!levels_.is_finest(k) || k == 0) settle(residuals, s, false, 20, 3, 1e-4 * extent_);
      if (levels_.is_finest(k)) {
        finish(residuals, s);
      } else {
        settle(residuals, s, !everything(), 8, 2, 1e-4 * extent_);
        if (is_doubtful()) doubt(information(residuals, k, s));
      }
      motion_ = s.at.motion;
      result_.iterations += s.accepted;
    }
  }

  [[nodiscard]] bool is_doubtful() const { return doubtful_.cols() > 0 && frozen_.cols() == 0; }

  // Of the motions that no level before has held, those that this one does not hold either: what it knows of them is
  // no more than noise gives. Each level has its say: a thin one misses detail, a dense one has noise in every slope.
  // Noise is what the scans show, each against itself: residuals far from the best motion are more than noise.
  void doubt(const Information& info) {
    Basis still(7, 0);
    for (const Weak& w : weak_within(info, doubtful_, largest_within(info, basis_), true)) {
      if (!w.noise) continue;
      still.conservativeResize(Eigen::NoChange, still.cols() + 1);
      still.col(still.cols() - 1) = w.direction;
    }
    doubtful_ = still;
  }

  // With the noise of each scan as it shows against itself, but no more than the residuals have.
  [[nodiscard]] Information information(Residuals& residuals, std::size_t level, Solver& s) const {
    s.refresh();
    std::array<double, 2> noise{roughness(levels_.moving(level)), roughness(levels_.fixed(level))};
    const double all = std::hypot(noise[0], noise[1]), spread = residuals.spread();
    for (double& n : noise) n = std::max(floor(), all > spread ? n * spread / all : n);
    return residuals.information(s.at.motion, s.loss, noise, context_);
  }

  // The scans themselves: the weights settle, on a sample first, then one fixed objective to the end.
  void finish(Residuals& residuals, Solver& s) {
    const bool by_default = options_.tolerance == 0;
    const double tolerance = (by_default ? default_match_tolerance : options_.tolerance) * extent_;
    const bool bounded = !everything();
    settle(residuals, s, bounded, 6, 1, 1e-5 * extent_);
    residuals.even_out();
    settle(residuals, s, bounded, 2, 1, 1e-5 * extent_);
    if (is_sampled()) {
      residuals.sample(1);
      s.start(s.at.motion, false);
      settle(residuals, s, bounded, 1, 1, 1e-5 * extent_);
    }
    const Information known = information(residuals, levels_.count() - 1, s);
    if (is_doubtful()) doubt(known);
    residuals.balance(s.at.motion);
    reweigh(residuals, s, bounded);
    s.negligible = !by_default ? 0 : is_sampled() ? negligible_of_many : negligible;
    s.rejected_within = rejected * s.negligible;
    s.history = &result_.history;
    s.note();
    const int before = s.accepted;
    const double last = s.descend(options_.max_iterations, tolerance);
    result_.converged = last < tolerance || s.within_noise || !s.stuck.empty();
    result_.reason =
        !s.stuck.empty() ? s.stuck
        : s.within_noise
            ? fmt::format("the next step, {:.1e} of the extent, is nothing beside the noise", last / extent_)
        : result_.converged ? fmt::format("the last step moved the scan by {:.1e} of its extent", last / extent_)
                            : fmt::format("stopped after {} steps (@max-iterations)", s.accepted - before);
    s.refresh();
    result_.overlap = s.at.sums.area > 0 ? s.at.sums.within / s.at.sums.area : 0;
    name_weak({s.at.sums.h, {}});
    find_covariance(known, residuals.score_cells(s.at.motion, s.loss, context_),
                    s.curvature(true, least_known_curvature), residuals.length());
    result_.stable.resize(moving_.xy.size());
    for (std::size_t i = 0; i < moving_.xy.size(); ++i) result_.stable[i] = residuals.fitted(i, s.loss) ? 1 : 0;
  }

  void name_weak(const Information& info) {
    for (int c = 0; c < frozen_.cols(); ++c)
      result_.weak_directions.push_back(words({frozen_.col(c), 0, true}, axes_) +
                                        " is not determined by the scans and was left as it was at the start");
    for (const Weak& w : weak_within(info, basis_, largest_within(info, basis_), false))
      result_.weak_directions.push_back(words(w, axes_) + " is weakly held: it carries " +
                                        fmt::format("{:.1g}", w.share) + " of the information of the strongest motion");
  }

  void find_covariance(const Information& known, const std::vector<ScoreCell>& cells, double curvature, double length) {
    const Matrix covariance = sandwich(cells, known, basis_, curvature);
    const double unit[7] = {1 / length, 1 / length, 1 / length, 1, 1, 1, 1 / length};
    for (int i = 0; i < 7; ++i)
      for (int j = 0; j < 7; ++j)
        result_.covariance[static_cast<std::size_t>(7 * i + j)] = covariance(i, j) * unit[i] * unit[j];
    for (int c = 0; c < frozen_.cols(); ++c) {
      Vector7 direction;
      for (int k = 0; k < 7; ++k) direction[static_cast<std::size_t>(k)] = frozen_(k, c) * unit[k];
      result_.undetermined.push_back(direction);
    }
  }

  const MatchSurface& moving_;
  const MatchOptions& options_;
  const std::array<std::string, 3>& axes_;
  const Context& context_;
  std::size_t fixed_nodes_;
  double extent_;
  Point3 centre_;
  Levels levels_;
  Basis basis_;
  Motion motion_;
  Basis doubtful_{7, 0}, frozen_{7, 0};  // frozen: not searched for
  SearchResult result_;
};

}  // namespace

SearchResult search(const MatchSurface& moving, const MatchSurface& fixed, const MatchOptions& options,
                    const std::array<std::string, 3>& axes, const Context& context) {
  return Search(moving, fixed, options, axes, context).run();
}

}  // namespace isopach
