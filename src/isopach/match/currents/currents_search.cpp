#include "isopach/match/currents/currents_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/point_tree.hpp"
#include "isopach/measure/currents/current.hpp"
#include "isopach/measure/currents/currents_gradient.hpp"

namespace isopach {
namespace {

using Vector = Eigen::Matrix<double, 6, 1>;  // turn x, y, z times the length,
                                             // shift x, y, z: all lengths
using Matrix = Eigen::Matrix<double, 6, 6>;

constexpr double widest_share = 0.2;      // first σ, of the extent
constexpr double edges_a_sigma = 5;       // of the thinned surfaces
constexpr std::size_t least_nodes = 600;  // of a thinned surface
constexpr double coarse_error = 1e-5;     // of the sums before the last steps
constexpr double no_curvature = 1e-9;     // of the largest: a motion that the surface does not see
constexpr double weak_curvature = 1e-3;   // … and one that is named
constexpr double beyond_edges = 1.5;      // to the nearest triangle of the other scan in the plane: it ends before
constexpr double named_pull = 1;          // of the border, in standard deviations: from here on a warning
constexpr double least_inner = 1e-6;      // of the norms: less at the widest kernel is no overlap

struct Width {
  SurfaceCurrent moving, fixed;
  double sigma, error;
};

SurfaceCurrent moved_by(const SurfaceCurrent& s, const Motion& motion) {
  SurfaceCurrent out;
  out.mean_edge = s.mean_edge;
  out.centroids.resize(s.centroids.size());
  out.normals.resize(s.centroids.size());
  for_each_index(s.centroids.size(), [&](std::size_t i) {
    out.centroids[i] = motion.apply(s.centroids[i]);
    out.normals[i] = motion.turn(s.normals[i]);
  });
  return out;
}

SurfaceCurrent current_of(const MatchSurface& s) {
  Array<unsigned char> kept(s.t.real);
  for (Index i = 0; i < s.t.real; ++i) kept[i] = s.footprint.keeps(i) ? 1 : 0;
  return surface_current(s.t, s.xy, s.z, kept);
}

/// The current of the surface with about `edges_a_sigma` edges in σ, if it has
/// more.
SurfaceCurrent current_for(const MatchSurface& s, const SurfaceCurrent& full, double sigma, bool trim,
                           const Context& context) {
  std::size_t run = 1;
  for (double edge = full.mean_edge; 2 * edge * edges_a_sigma <= sigma && s.xy.size() / (4 * run) >= least_nodes;)
    run *= 4, edge *= 2;
  return run == 1 ? full : current_of(thinned(s, run, trim, context));
}

double extent_of(const SurfaceCurrent& a, const SurfaceCurrent& b) {
  double most = 0;
  for (const SurfaceCurrent* s : {&a, &b}) {
    Box3 box;
    for (const Point3& p : s->centroids) box.add(p);
    if (!box.empty()) most = std::max(most, std::hypot(box.max.x - box.min.x, box.max.y - box.min.y));
  }
  return most;
}

Point3 centre_of(const SurfaceCurrent& s) {
  Point3 sum{0, 0, 0};
  double total = 0;
  for (std::size_t i = 0; i < s.centroids.size(); ++i) {
    const Point3 &c = s.centroids[i], &n = s.normals[i];
    const double w = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    sum = {sum.x + w * c.x, sum.y + w * c.y, sum.z + w * c.z};
    total += w;
  }
  return {sum.x / total, sum.y / total, sum.z / total};
}

struct State {
  Motion motion;
  double inner = 0;
  Vector gradient = Vector::Zero();  // of ρ
};

class Descent {
 public:
  Descent(const Point3& centre, double length, const Freedom& f, const Context& context)
      : centre_(centre), length_(length), context_(context) {
    const bool free[6] = {f.turn_x, f.turn_y, f.turn_z, f.shift_x, f.shift_y, f.shift_z};
    for (int k = 0; k < 6; ++k)
      if (free[k]) free_.push_back(k);
  }

  [[nodiscard]] Vector scaled(const CurrentsGradient& g) const {
    Vector v;
    for (int k = 0; k < 3; ++k) {
      v(k) = g.turn[static_cast<std::size_t>(k)] / length_;
      v(k + 3) = g.shift[static_cast<std::size_t>(k)];
    }
    return v;
  }
  [[nodiscard]] Twist twist(const Vector& v) const {
    return {v(0) / length_, v(1) / length_, v(2) / length_, v(3), v(4), v(5), 0};
  }
  [[nodiscard]] State at(const Width& w, const Motion& motion) const {
    const SurfaceCurrent a = moved_by(w.moving, motion);
    const CurrentsGradient g = currents_gradient(a.view(), w.fixed.view(), centre_, {w.sigma, w.error}, context_);
    return {motion, g.inner, scaled(g)};
  }

  /// 2 ⟨∂A, ∂A⟩ of the moving surface where it is now: the derivative of the
  /// gradient of ρ(φA, A).
  [[nodiscard]] Matrix curvature(const SurfaceCurrent& moving, double sigma, const Motion& motion) const {
    const SurfaceCurrent here = moved_by(moving, motion);
    const double step = 0.02 * sigma;
    Matrix h = Matrix::Zero();
    for (const int k : free_) {
      const SurfaceCurrent there = moved_by(moving, moved(motion, twist(step * Vector::Unit(k)), centre_));
      h.col(k) = scaled(currents_gradient(there.view(), here.view(), centre_, {sigma, 1e-7}, context_)) / step;
    }
    return (h + h.transpose()) / 2;
  }

  /// −m⁻¹ g of the free motions, along the directions that m holds.
  [[nodiscard]] Vector solved(const Matrix& m, const Vector& g) const {
    const Spectrum<Eigen::Dynamic> s = spectrum(Eigen::MatrixXd(m(free_, free_)));
    const double floor = no_curvature * s.values.maxCoeff();
    Vector x = Vector::Zero();
    const Eigen::VectorXd right = g(free_);
    Eigen::VectorXd part = Eigen::VectorXd::Zero(right.size());
    for (int k = 0; k < right.size(); ++k)
      if (s.values(k) > floor) part -= s.vectors.col(k) * (s.vectors.col(k).dot(right) / s.values(k));
    x(free_) = part;
    return x;
  }

  [[nodiscard]] const std::vector<int>& free() const { return free_; }
  [[nodiscard]] const Point3& centre() const { return centre_; }
  [[nodiscard]] double length() const { return length_; }

 private:
  Point3 centre_;
  double length_;
  const Context& context_;
  std::vector<int> free_;
};

/// The update of BFGS, damped [Powell1978] so that the matrix stays positive
/// along the step.
void update(Matrix& m, const Vector& s, Vector y) {
  const Vector ms = m * s;
  const double sms = s.dot(ms), sy = s.dot(y);
  if (!(sms > 0)) return;
  if (sy < 0.2 * sms) {
    const double theta = 0.8 * sms / (sms - sy);
    y = theta * y + (1 - theta) * ms;
  }
  m += y * y.transpose() / s.dot(y) - ms * ms.transpose() / sms;
}

struct Outcome {
  State state;
  int steps = 0;
  double last = 0;  // length of the last step
  bool converged = false, stuck = false;
};

/// Descends at one width until a step is shorter than `tolerance`. `note` sees
/// every accepted state.
template <class Note>
Outcome descend(const Descent& d, const Width& w, const Motion& start, Matrix m, double norms, double tolerance,
                int most, Note&& note) {
  Outcome o{d.at(w, start), 0, 0, false, false};
  note(o.state);
  const double slack = 2 * w.error * norms;  // what the sums may be off
  while (o.steps < most) {
    Vector step = d.solved(m, o.state.gradient);
    const double far = 0.5 * w.sigma;  // beyond it the kernel's shape is another
    if (step.norm() > far) step *= far / step.norm();
    const double slope = o.state.gradient.dot(step);
    State next;
    bool accepted = false;
    for (int halvings = 0; halvings < 12 && !accepted; ++halvings) {
      next = d.at(w, moved(o.state.motion, d.twist(step), d.centre()));
      const double change = -2 * (next.inner - o.state.inner);
      accepted = change <= 1e-4 * std::ldexp(slope, -halvings) + slack;
      if (!accepted) step /= 2;
    }
    o.last = step.norm();
    if (!accepted) {
      o.stuck = true;
      o.converged = o.last < 1e3 * tolerance;
      return o;
    }
    update(m, step, next.gradient - o.state.gradient);
    o.state = next;
    ++o.steps;
    note(o.state);
    if (o.last < tolerance) {
      o.converged = true;
      return o;
    }
  }
  return o;
}

double squared_norm(const SurfaceCurrent& s, double sigma, const Context& context) {
  return currents_gradient(s.view(), s.view(), {0, 0, 0}, {sigma, 1e-8}, context).inner;
}

std::string words(const Eigen::VectorXd& v, const std::vector<int>& free, const std::array<std::string, 3>& axes) {
  std::string text;
  for (int i = 0; i < v.size(); ++i) {
    if (std::fabs(v(i)) < 0.4 * v.cwiseAbs().maxCoeff()) continue;
    const int k = free[static_cast<std::size_t>(i)];
    text += (text.empty() ? "" : " with ") + std::string(k < 3 ? "turn about " : "shift along ") +
            axes[static_cast<std::size_t>(k % 3)];
  }
  return text;
}

/// The triangles of `s` that lie beyond `other`, seen along the direction.
SurfaceCurrent beyond(const SurfaceCurrent& s, const SurfaceCurrent& other) {
  Array<Point3> flat(other.centroids.size());
  for_each_index(flat.size(), [&](std::size_t i) { flat[i] = {other.centroids[i].x, other.centroids[i].y, 0}; });
  const PointTree tree(flat);
  const double far = beyond_edges * other.mean_edge;
  Array<unsigned char> is_beyond(s.centroids.size());
  for_each_index(s.centroids.size(), [&](std::size_t i) {
    is_beyond[i] = tree.nearest_distance2({s.centroids[i].x, s.centroids[i].y, 0}) > far * far ? 1 : 0;
  });
  SurfaceCurrent out;
  out.mean_edge = s.mean_edge;
  for (std::size_t i = 0; i < s.centroids.size(); ++i) {
    if (is_beyond[i] == 0) continue;
    out.centroids.push_back(s.centroids[i]);
    out.normals.push_back(s.normals[i]);
  }
  return out;
}

/// How far the borders pull the pose: what only one of the scans has pulls at `a`, where it is now, as if it were a
/// difference. To first order: m⁻¹ times that part of the gradient.
Vector pull_of_borders(const Descent& d, const SurfaceCurrent& a, const SurfaceCurrent& b, const CurrentsOptions& o,
                       const Matrix& m, const Context& context) {
  const SurfaceCurrent a_only = beyond(a, b), b_only = beyond(b, a);
  Vector g = Vector::Zero();
  if (!b_only.centroids.empty()) g += d.scaled(currents_gradient(a.view(), b_only.view(), d.centre(), o, context));
  if (!a_only.centroids.empty()) g -= d.scaled(currents_gradient(a.view(), a_only.view(), d.centre(), o, context));
  return d.solved(m, g);
}

/// Weak directions and the covariance m⁻¹ (Σ g gᵀ) m⁻¹ over the cubes' parts g
/// of the gradient of ρ, which would all be 0 without noise. Twice that: the
/// parts of near cubes go together.
void judge(const Descent& d, const Width& w, const Matrix& m, const Motion& motion,
           const std::array<std::string, 3>& axes, const Context& context, SearchResult& r) {
  const Eigen::MatrixXd part = m(d.free(), d.free());
  const Spectrum<Eigen::Dynamic> s = spectrum(part);
  const double largest = s.values.maxCoeff();
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(part.rows(), part.cols());
  for (int k = 0; k < part.rows(); ++k) {
    const double share = largest > 0 ? s.values(k) / largest : 0;
    const Eigen::VectorXd v = s.vectors.col(k);
    if (share > no_curvature) inverse += v * v.transpose() / s.values(k);
    if (share < weak_curvature)
      r.weak_directions.push_back(words(v, d.free(), axes) + " is weakly held: it carries " +
                                  fmt::format("{:.1g}", std::max(0.0, share)) +
                                  " of the information of the strongest motion");
  }
  const SurfaceCurrent a = moved_by(w.moving, motion);
  const CurrentsOptions o{w.sigma, w.error};
  const auto to_b = currents_gradient_by_cube(a.view(), w.fixed.view(), d.centre(), o, context),
             to_a = currents_gradient_by_cube(a.view(), a.view(), d.centre(), o, context);
  Eigen::MatrixXd score = Eigen::MatrixXd::Zero(part.rows(), part.cols());
  for (std::size_t i = 0; i < to_b.size(); ++i) {
    const Eigen::VectorXd g = (d.scaled(to_b[i]) - d.scaled(to_a[i]))(d.free());
    score += g * g.transpose();
  }
  Eigen::MatrixXd c = 2 * product(product(inverse, score), inverse);
  const Eigen::VectorXd pull = pull_of_borders(d, a, w.fixed, o, m, context)(d.free());
  double deviations = 0;
  for (int i = 0; i < c.rows(); ++i)
    if (c(i, i) > 0) deviations = std::max(deviations, std::fabs(pull(i)) / std::sqrt(c(i, i)));
  if (deviations > named_pull)
    r.weak_directions.push_back(fmt::format(
        "the border where one scan reaches beyond the other pulls the pose by up to {:.0f} standard deviations of the "
        "noise (in the precision as an error of its own): cut both scans to what they have in common, or take "
        "@objective measure",
        deviations));
  c += pull * pull.transpose();
  const auto unit = [&](int k) { return k < 3 ? 1 / d.length() : 1.0; };
  for (int i = 0; i < c.rows(); ++i)
    for (int j = 0; j < c.cols(); ++j) {
      const int p = d.free()[static_cast<std::size_t>(i)], q = d.free()[static_cast<std::size_t>(j)];
      r.covariance[static_cast<std::size_t>(7 * p + q)] = c(i, j) * unit(p) * unit(q);
    }
}

void check(const MatchOptions& o) {
  if (o.freedom.scale)
    throw UsageError(
        "@freedom scale: currents of another size have another "
        "norm: leave scale out, or take another "
        "@objective");
  if (o.compare.weight.kind != WeightSource::Kind::none)
    throw UsageError("@weight: currents have none: leave it out, or take another @objective");
  if (o.overlap > 0 && o.overlap < 1)
    throw UsageError(
        "@overlap: @objective currents fits everything: leave "
        "it out, or take another @objective");
}

}  // namespace

SearchResult currents_search(const MatchSurface& moving, const MatchSurface& fixed, const MatchOptions& options,
                             const std::array<std::string, 3>& axes, const Context& context) {
  check(options);
  const SurfaceCurrent all_moving = current_of(moving), all_fixed = current_of(fixed);
  if (all_moving.centroids.empty() || all_fixed.centroids.empty())
    throw OverlapError(
        "@objective currents: a scan has no triangle that its "
        "sampling supports: use @border hull");
  const double extent = extent_of(all_moving, all_fixed);
  const double sigma = options.sigma > 0 ? options.sigma : default_sigma(all_moving, all_fixed);
  const double tolerance = (options.tolerance > 0 ? options.tolerance : default_match_tolerance) * extent;
  const bool trim = options.compare.border == BorderRule::trim;
  const Descent d(centre_of(all_moving), extent / 4, options.freedom, context);

  std::vector<double> widths{sigma};
  while (2 * widths.back() <= widest_share * extent) widths.push_back(2 * widths.back());
  std::reverse(widths.begin(), widths.end());

  SearchResult r;
  r.centre = d.centre();
  r.radius = d.length();
  Motion motion;
  SurfaceCurrent coarser;  // of the moving surface, one width before
  for (const double width : widths) {
    const bool last = width == sigma;
    Width w{last ? all_moving : current_for(moving, all_moving, width, trim, context),
            last ? all_fixed : current_for(fixed, all_fixed, width, trim, context), width, coarse_error};
    const double aa = squared_norm(w.moving, width, context), bb = squared_norm(w.fixed, width, context);
    const Matrix m = d.curvature(coarser.centroids.empty() ? w.moving : coarser, width, motion);
    if (width == widths.front() && !(d.at(w, motion).inner > least_inner * std::sqrt(aa * bb)))
      throw OverlapError(
          "the scans do not overlap at the start: check their "
          "coordinate systems, or give a start with @start");
    const double norms = std::sqrt(aa * bb);
    Outcome o = descend(d, w, motion, m, norms, 1e-2 * width, 30, [](const State&) {});
    r.iterations += o.steps;
    if (last) {  // again, with sums good enough for the tolerance
      w.error = std::clamp(0.1 * tolerance / sigma, 1e-10, coarse_error);
      o = descend(d, w, o.state.motion, m, norms, tolerance, options.max_iterations, [&](const State& s) {
        r.history.push_back({std::max(0.0, aa + bb - 2 * s.inner), std::numeric_limits<double>::quiet_NaN(), 1});
      });
      r.iterations += o.steps;
    }
    motion = o.state.motion;
    if (last) {
      r.converged = o.converged;
      r.reason = o.stuck       ? "no step lowers the distance"
                 : o.converged ? fmt::format("the last step moved the scan by {:.1e} of its extent", o.last / extent)
                               : fmt::format("stopped after {} steps (@max-iterations)", o.steps);
      judge(d, w, m, motion, axes, context, r);
    }
    coarser = w.moving;
  }
  r.motion = motion;
  r.overlap = 1;
  r.stable.assign(moving.xy.size(), 1);
  return r;
}

}  // namespace isopach
