#include "isopach/apps/quadric_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "isopach/apps/motions.hpp"
#include "isopach/base/linear.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t query_block = 256;
constexpr std::size_t spacing_neighbours = 8;  // the point itself included
constexpr std::size_t spacing_sample = 2000;
constexpr std::size_t least_window = 24, most_window = 96;  // points that a quadric is fitted to
constexpr std::size_t least_pairs = 24, most_queries = 60000;
constexpr double near_spacings = 1.5, near_scales = 4;  // of the two: how far a pair is sought
constexpr double rounding = 1e-12;
constexpr int most_steps = 60, free_scale_steps = 10;
constexpr double tolerance = 1e-7;           // of the radius
constexpr double least_cosine = 0.70710678;  // of two normals: 45 degrees
constexpr double worst_window = 3;           // times the median misfit: the window crosses an edge
constexpr double tukey_width = 4.685;        // 95 % efficient for normal residuals
constexpr double most_sigmas = 3;            // of a point of the denser cloud about its own quadric
constexpr double cell_windows = 4;           // side of a cell, in radii of a window
constexpr double least_cells = 18;           // three a freedom: fewer tell nothing

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Where the scanner saw the point, before it was put on the plane of its neighbours.
Point3 as_scanned(const OrientedCloud& cloud, Index i) { return cloud.points[i] + cloud.height[i] * cloud.normals[i]; }

/// The quadric through the neighbours of one point of a cloud, as heights over its tangent plane.
struct Quadric {
  Point3 origin{0, 0, 0}, across{0, 0, 0}, along{0, 0, 0}, beside{0, 0, 0};
  Vector6 shape = Vector6::Zero();
  Matrix6 inverse = Matrix6::Zero();  ///< of the normal matrix of its terms
  double radius = 0;                  ///< of the neighbourhood; 0: none could be fitted
  double misfit = 0;                  ///< standard deviation of the neighbours about it

  [[nodiscard]] Vector6 terms(const Point3& p) const {
    const Point3 d = p - origin;
    const double u = dot(d, along) / radius, v = dot(d, beside) / radius;
    Vector6 t;
    t << 1, u, v, u * u, u * v, v * v;
    return t;
  }
  [[nodiscard]] double height(const Point3& p) const { return dot(p - origin, across); }
};

class Windows {
 public:
  Windows(const OrientedCloud& cloud, std::size_t count) : cloud_(cloud), count_(count) {}

  [[nodiscard]] Quadric fit(Index at) {
    Quadric q;
    q.origin = cloud_.points[at];
    q.across = cloud_.normals[at];
    if (squared_length(q.across) == 0) return q;
    const Point3& n = q.across;
    const Point3 least = std::fabs(n.x) <= std::fabs(n.y) && std::fabs(n.x) <= std::fabs(n.z) ? Point3{1, 0, 0}
                         : std::fabs(n.y) <= std::fabs(n.z)                                   ? Point3{0, 1, 0}
                                                                                              : Point3{0, 0, 1};
    q.along = cross(n, least);
    q.along = (1 / length(q.along)) * q.along;
    q.beside = cross(n, q.along);
    cloud_.tree->nearest(q.origin, count_, found);
    const double radius = length(cloud_.points[found.back()] - q.origin);
    if (found.size() < least_window || !(radius > 0)) return q;
    q.radius = radius;
    solve(q);
    return q;
  }

  std::vector<Index> found;  ///< the neighbours of the last fit

 private:
  void solve(Quadric& q) const {
    Matrix6 normal = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    double squares = 0;
    for (const Index k : found) {
      const Point3 p = as_scanned(cloud_, k);
      const Vector6 t = q.terms(p);
      const double h = q.height(p);
      normal += t * t.transpose();
      right += h * t;
      squares += h * h;
    }
    const Ldlt<6> solver(normal);
    constexpr double least_pivot = 1e-6;  // of the largest: the points lie on too few lines
    const Vector6 pivots = solver.pivots();
    if (!(pivots.minCoeff() > least_pivot * pivots.maxCoeff())) {
      q.radius = 0;
      return;
    }
    q.shape = solver.solve(right);
    q.inverse = solver.solve_columns(Matrix6::Identity());
    const double left = std::max(0.0, squares - q.shape.dot(right));
    q.misfit = std::sqrt(left / static_cast<double>(found.size() - 6));
  }

  const OrientedCloud& cloud_;
  std::size_t count_;
};

/// Points of `cloud` that lie within `reach` of `other` after the motion.
Array<Index> points_near(const OrientedCloud& cloud, const OrientedCloud& other, const Motion& motion, bool inverse,
                         double reach) {
  Array<unsigned char> is_near(cloud.points.size());
  for_blocks(is_near.size(), query_block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Point3& p = cloud.points[i];
      is_near[i] = other.tree->nearest_distance2(inverse ? motion.undo(p) : motion.apply(p)) <= reach * reach;
    }
  });
  Array<Index> result;
  for (std::size_t i = 0; i < is_near.size(); ++i)
    if (is_near[i] != 0) result.push_back(static_cast<Index>(i));
  return result;
}

/// Median squared distance of the eighth point, by some of the points `which`.
double squared_spacing(const OrientedCloud& cloud, const Array<Index>& which) {
  const std::size_t n = which.size(), stride = std::max<std::size_t>(1, n / spacing_sample);
  Array<double> all((n + stride - 1) / stride);
  for_blocks(all.size(), query_block, [&](std::size_t begin, std::size_t end) {
    std::vector<Index> found;
    for (std::size_t k = begin; k < end; ++k) {
      const Point3& p = cloud.points[which[k * stride]];
      cloud.tree->nearest(p, spacing_neighbours, found);
      all[k] = squared_length(cloud.points[found.back()] - p);
    }
  });
  return median(all);
}

double squared_spacing(const OrientedCloud& cloud) {
  Array<Index> all(cloud.points.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
  return squared_spacing(cloud, all);
}

/// One query: who asks, and what it is answered.
struct Asked {
  Index query = no_index;
  Index target = no_index;
  Quadric quadric;
};

struct Answer {
  Link link;                     ///< moving − fixed along the normal is the distance; in coordinates of the scan
  Vector6 terms;                 ///< of the quadric at the place of the query
  const Asked* asked = nullptr;  ///< nullptr: no pair
  double leverage = 0;           ///< variance of the quadric's height there, over that of its points
};

class Fitting {
 public:
  Fitting(const OrientedCloud& object, const OrientedCloud& scan, const Motion& start, double start_scale,
          const Context& context)
      : object_(object), scan_(scan), context_(context) {
    fit_.motion = start;
    reach_ =
        near_spacings * std::sqrt(std::max(squared_spacing(object), squared_spacing(scan))) + near_scales * start_scale;
  }

  std::optional<QuadricFit> run() {
    const Array<Index> on_scan = points_near(object_, scan_, fit_.motion, false, reach_),
                       on_object = points_near(scan_, object_, fit_.motion, true, reach_);
    if (std::min(on_scan.size(), on_object.size()) < least_window) return std::nullopt;
    const double of_object = squared_spacing(object_, on_scan), of_scan = squared_spacing(scan_, on_object);
    fit_.object_asks = of_object >= of_scan;
    queries_ = fit_.object_asks ? &object_ : &scan_;
    targets_ = fit_.object_asks ? &scan_ : &object_;
    const Array<Index>& near = fit_.object_asks ? on_scan : on_object;
    const std::size_t stride = (near.size() + most_queries - 1) / most_queries;
    for (std::size_t k = 0; k < near.size(); k += stride) asked_.push_back({near[k], no_index, {}});
    choose_window(std::max(of_object, of_scan), std::min(of_object, of_scan));
    if (!iterate()) return std::nullopt;
    finish();
    return fit_;
  }

 private:
  /// A quadric spans about the spacing of the queries: what of the denser cloud lies there is told alike by all of it.
  void choose_window(double coarse, double fine) {
    const double denser = coarse / std::max(fine, 1e-300);
    window_ = denser < static_cast<double>(most_window)
                  ? std::clamp(static_cast<std::size_t>(spacing_neighbours * denser), least_window, most_window)
                  : most_window;
  }

  bool iterate() {
    double width = 0;
    for (int step = 0; step < most_steps; ++step) {
      context_.check();
      look();
      if (answers_.size() < least_pairs) return false;
      if (step < free_scale_steps) fit_.scale = scale_of(), width = tukey_width * fit_.scale;
      weigh(width);
      fit_.information = pair_information(links_, PairKind::plane);
      if (!(fit_.information.weight > 0)) return false;
      const PairInformation& in = fit_.information;
      const Twist twist = plane_step(in, Freedom{}, floor_);
      const double turn = std::sqrt(twist[0] * twist[0] + twist[1] * twist[1] + twist[2] * twist[2]);
      const double shift = std::sqrt(twist[3] * twist[3] + twist[4] * twist[4] + twist[5] * twist[5]);
      if (in.radius * turn + shift <= tolerance * in.radius || !(width > 0)) return true;
      fit_.motion = moved(fit_.motion, twist, in.centre);
    }
    return settled();
  }

  /// Pairs that change to and fro keep the steps from ending; what they move is far below what noise does.
  [[nodiscard]] bool settled() const {
    const PairInformation& in = fit_.information;
    const Twist twist = plane_step(in, Freedom{}, floor_);
    const double shift = std::sqrt(twist[3] * twist[3] + twist[4] * twist[4] + twist[5] * twist[5]);
    const double turn = std::sqrt(twist[0] * twist[0] + twist[1] * twist[1] + twist[2] * twist[2]);
    return in.radius * turn + shift <= 0.1 * fit_.scale;
  }

  /// Asks every query; answers_ in the order of the queries.
  void look() {
    Array<Answer> all(asked_.size());
    for_blocks(all.size(), query_block, [&](std::size_t begin, std::size_t end) {
      Windows windows(*targets_, window_);
      for (std::size_t i = begin; i < end; ++i) ask(asked_[i], windows, all[i]);
    });
    answers_.clear();
    Array<double> misfits, slopes;
    for (const Answer& a : all) {
      if (a.asked == nullptr) continue;
      const Quadric& q = a.asked->quadric;
      misfits.push_back(q.misfit);
      slopes.push_back(q.misfit * q.misfit * (q.inverse(1, 1) + q.inverse(2, 2)) / (q.radius * q.radius));
    }
    if (misfits.empty()) return;
    floor_ = std::max(rounding, 2 * median(slopes));
    const double worst = worst_window * median(misfits);
    for (const Answer& a : all)
      if (a.asked != nullptr && a.asked->quadric.misfit <= worst) answers_.push_back(a);
  }

  void ask(Asked& asked, Windows& windows, Answer& answer) const {
    answer.asked = nullptr;
    const Index i = asked.query;
    const Motion& m = fit_.motion;
    const Point3 p = as_scanned(*queries_, i), place = fit_.object_asks ? m.apply(p) : m.undo(p);
    const PointTree::Two two = targets_->tree->nearest_two(place);
    if (two.first2 > reach_ * reach_ || targets_->boundary[two.first] != 0) return;
    const Point3 normal = fit_.object_asks ? m.turn(queries_->normals[i]) : m.turn_back(queries_->normals[i]);
    if (std::fabs(dot(normal, targets_->normals[two.first])) < least_cosine) return;
    if (asked.target != two.first) asked = {i, two.first, windows.fit(two.first)};
    const Quadric& q = asked.quadric;
    if (!(q.radius > 0)) return;
    const Vector6 t = q.terms(place);
    if (t[1] * t[1] + t[2] * t[2] > 1) return;
    const double off = q.height(place) - q.shape.dot(t);
    // Gradient of the quadric along its two axes, per unit of length.
    const double gu = (q.shape[1] + 2 * q.shape[3] * t[1] + q.shape[4] * t[2]) / q.radius;
    const double gv = (q.shape[2] + q.shape[4] * t[1] + 2 * q.shape[5] * t[2]) / q.radius;
    const double steep = 1 / std::sqrt(1 + gu * gu + gv * gv);
    const Point3 n = steep * (q.across - gu * q.along - gv * q.beside);
    const Point3 foot = place - (off * steep) * n;
    answer.link = fit_.object_asks ? Link{place, foot, n, 1, i} : Link{m.apply(foot), p, m.turn(n), 1, i};
    answer.terms = t;
    answer.asked = &asked;
    answer.leverage = t.dot(q.inverse * t) * steep * steep;
  }

  [[nodiscard]] static double distance(const Link& l) { return dot(l.moving - l.fixed, l.normal); }

  [[nodiscard]] double scale_of() const {
    Array<double> sizes(answers_.size());
    for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = std::fabs(distance(answers_[i].link));
    return mad_to_sigma * median(sizes);
  }

  void weigh(double width) {
    links_.resize(answers_.size());
    for (std::size_t i = 0; i < links_.size(); ++i) {
      Link& l = links_[i] = answers_[i].link;
      const double t = width > 0 ? distance(l) / width : 0;
      l.weight = std::fabs(t) < 1 ? (1 - t * t) * (1 - t * t) : 0;
    }
  }

  void finish() {
    fit_.rms = std::sqrt(fit_.information.error);
    fit_.pairs = static_cast<std::size_t>(
        std::count_if(links_.begin(), links_.end(), [](const Link& l) { return l.weight > 0; }));
    set_covariance();
    set_slip();
  }

  void set_slip() {
    const Eigen::Map<const Eigen::Matrix<double, 7, 7, Eigen::RowMajor>> all(fit_.information.normal.data());
    const Spectrum<6> held = spectrum<6>(all.topLeftCorner<6, 6>());
    Box3 box;
    for (const Point3& p : object_.points) box.add(p);
    const double least = std::sqrt(std::max(0.0, held.values[0])), extent = length(box.max - box.min);
    fit_.slip = fit_.scale > 0 ? 0.01 * extent * least / fit_.scale : std::numeric_limits<double>::infinity();
    if (held.values[0] <= floor_) fit_.slip = 0;
    const Vector6 v = held.vectors.col(0);
    fit_.least_held = v.head<3>().norm() >= v.tail<3>().norm() ? "a turn" : "a shift";
  }

  [[nodiscard]] Vector6 row_of(const Link& l) const {
    const PairInformation& in = fit_.information;
    const Point3 turn = cross((1 / in.radius) * (l.moving - in.centre), l.normal);
    Vector6 row;
    row << turn.x, turn.y, turn.z, l.normal.x, l.normal.y, l.normal.z;
    return row;
  }

  /// Distance of each point of the target from its own quadric, so scaled that noise keeps its size; of those that hold
  /// a quadric which takes part. Others stay 0.
  [[nodiscard]] Array<double> target_noise() {
    const std::size_t n = targets_->points.size();
    Array<unsigned char> wanted(n);
    std::fill(wanted.begin(), wanted.end(), static_cast<unsigned char>(0));
    Windows windows(*targets_, window_);
    for (std::size_t i = 0; i < answers_.size(); ++i) {
      if (links_[i].weight == 0) continue;
      targets_->tree->nearest(targets_->points[answers_[i].asked->target], window_, windows.found);
      for (const Index k : windows.found) wanted[k] = 1;
    }
    Array<double> noise(n);
    for_blocks(n, query_block, [&](std::size_t begin, std::size_t end) {
      Windows own(*targets_, window_);
      for (std::size_t k = begin; k < end; ++k) {
        noise[k] = 0;
        if (wanted[k] == 0) continue;
        const Quadric q = own.fit(static_cast<Index>(k));
        if (!(q.radius > 0)) continue;
        const Point3 p = as_scanned(*targets_, static_cast<Index>(k));
        const Vector6 t = q.terms(p);
        const double leverage = t.dot(q.inverse * t);
        noise[k] = (q.height(p) - q.shape.dot(t)) / std::sqrt(std::max(0.05, 1 - leverage));
      }
    });
    return noise;
  }

  /// J = Σ share ψ² a aᵀ + Σ over points of the target e² g gᵀ, g = Σ ψ' W a; covariance H⁻¹ J H⁻¹ ([Huber1981], 6.3).
  void set_covariance() {
    const Array<double> noise = target_noise();
    Array<double> sizes;
    for (const double e : noise)
      if (e != 0) sizes.push_back(std::fabs(e));
    const double target_sigma = sizes.empty() ? 0 : mad_to_sigma * median(sizes);
    const double scale2 = fit_.scale * fit_.scale, width = tukey_width * fit_.scale;
    Array<Vector6> pulls(targets_->points.size());
    std::fill(pulls.begin(), pulls.end(), Vector6::Zero());
    Matrix6 spread = Matrix6::Zero(), normal = Matrix6::Zero();
    double weights = 0, slopes = 0;
    Windows windows(*targets_, window_);
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const Link& l = links_[i];
      if (l.weight == 0) continue;
      const Vector6 a = row_of(l);
      const double r = distance(l), t2 = width > 0 ? (r / width) * (r / width) : 0;
      const double slope = (1 - t2) * (1 - 5 * t2), psi = l.weight * r;
      const double share =
          scale2 > 0 ? std::clamp(1 - target_sigma * target_sigma * answers_[i].leverage / scale2, 0.0, 1.0) : 1;
      spread += share * psi * psi * a * a.transpose();
      normal += l.weight * a * a.transpose();
      weights += l.weight, slopes += slope;
      const Asked& asked = *answers_[i].asked;
      const Vector6 by = asked.quadric.inverse * answers_[i].terms;
      const double steep =
          std::fabs(dot(asked.quadric.across, fit_.object_asks ? l.normal : fit_.motion.turn_back(l.normal)));
      targets_->tree->nearest(targets_->points[asked.target], window_, windows.found);
      for (const Index k : windows.found)
        pulls[k] += slope * steep * by.dot(asked.quadric.terms(as_scanned(*targets_, k))) * a;
    }
    const double most_noise = most_sigmas * target_sigma;  // a point beyond is on an edge, not noisy
    for (std::size_t k = 0; k < pulls.size(); ++k) {
      const double e = std::min(std::fabs(noise[k]), most_noise);
      spread += e * e * pulls[k] * pulls[k].transpose();
    }
    fit_.correlation = correlation(spread);
    const double most = fit_.information.radius, loss = std::max(0.1, slopes / weights);
    const Matrix6 h = loss * normal;
    const Spectrum<6> held = spectrum<6>(h / weights);
    Matrix6 inverse = Matrix6::Zero(), unheld = Matrix6::Zero();
    for (Eigen::Index k = 0; k < 6; ++k) {
      const Vector6 v = held.vectors.col(k);
      if (held.values[k] > loss * floor_)
        inverse += v * v.transpose() / (weights * held.values[k]);
      else
        unheld += most * most * v * v.transpose();
    }
    Matrix6 c = fit_.correlation * inverse * spread * inverse + unheld;
    c.topRows<3>() /= most;
    c.leftCols<3>() /= most;
    for (Eigen::Index i = 0; i < 6; ++i)
      for (Eigen::Index j = 0; j < 6; ++j) fit_.covariance[static_cast<std::size_t>(6 * i + j)] = c(i, j);
  }

  /// Sums of the pulls over cells of a few windows each, against what `spread` makes of independent noise.
  [[nodiscard]] double correlation(const Matrix6& spread) const {
    Array<double> radii;
    for (const Answer& a : answers_) radii.push_back(a.asked->quadric.radius);
    const double side = cell_windows * median(radii);
    if (!(side > 0)) return 1;
    struct Cell {
      Vector6 sum = Vector6::Zero();
      Matrix6 normal = Matrix6::Zero();
    };
    std::map<std::array<std::int64_t, 3>, Cell> cells;
    Matrix6 all = Matrix6::Zero();
    for (const Link& l : links_) {
      if (l.weight == 0) continue;
      const Point3 d = (1 / side) * (l.moving - fit_.information.centre);
      const std::array<std::int64_t, 3> key{static_cast<std::int64_t>(std::floor(d.x)),
                                            static_cast<std::int64_t>(std::floor(d.y)),
                                            static_cast<std::int64_t>(std::floor(d.z))};
      Cell& cell = cells[key];
      const Vector6 a = row_of(l);
      cell.sum += l.weight * distance(l) * a;
      cell.normal += l.weight * a * a.transpose();
      all += l.weight * a * a.transpose();
    }
    const auto count = static_cast<double>(cells.size());
    if (count < least_cells) return 1;
    const Ldlt<6> of_spread(spread), of_all(all);
    if (!of_spread.succeeded() || !of_spread.is_positive() || !of_all.is_positive()) return 1;
    Matrix6 blocks = Matrix6::Zero();
    double left = 6;  // what the fit leaves of it: each cell's part of the normal matrix takes its own share off
    for (const auto& [key, cell] : cells) {
      blocks += cell.sum * cell.sum.transpose();
      const Matrix6 part = of_all.solve_columns(cell.normal);
      left -= (part * part).trace();
    }
    if (!(left > 1)) return 1;
    const double ratio = of_spread.solve_columns(blocks).trace() / left;
    // Independent noise makes the ratio vary by sqrt(2 / (6 cells)) about 1: within two of these nothing is shown.
    return std::isfinite(ratio) && ratio > 1 + 2 * std::sqrt(2 / (6 * count)) ? ratio : 1;
  }

  const OrientedCloud& object_;
  const OrientedCloud& scan_;
  double reach_ = 0;
  double floor_ = 0;  ///< least eigenvalue that the surfaces made: noise of the quadrics' slopes alone makes half of it
  const Context& context_;
  const OrientedCloud *queries_ = nullptr, *targets_ = nullptr;
  std::size_t window_ = least_window;
  Array<Asked> asked_;
  Array<Answer> answers_;
  Array<Link> links_;
  QuadricFit fit_;
};

}  // namespace

std::optional<QuadricFit> fit_quadrics(const OrientedCloud& object, const OrientedCloud& scan, const Motion& start,
                                       double start_scale, const Context& context) {
  return Fitting(object, scan, start, start_scale, context).run();
}

}  // namespace isopach
