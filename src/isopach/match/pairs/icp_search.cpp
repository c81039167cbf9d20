#include "isopach/match/pairs/icp_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "isopach/base/error.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/pairs/anderson.hpp"

namespace isopach {
namespace {

constexpr double least_share = 0.02;     // of the queries; below it nothing holds the pose
constexpr std::size_t least_links = 12;  // twice the freedoms
constexpr std::size_t coarsest = 4096;   // points of the first level; each next one has 8 times more
constexpr double same_error = 1e-6;      // relative change of E, at most
constexpr double last_deviations = 0.03, coarse_deviations = 0.1;
constexpr double coarse_step = 1e-5;  // share of the radius: enough before the next level

bool six_free(const Freedom& f) { return f.shift_x && f.shift_y && f.shift_z && f.turn_x && f.turn_y && f.turn_z; }

/// How far the step takes points at `radius` from the centre, at most about.
double size_of(const Motion& before, const Motion& now, const Point3& centre, double radius) {
  const Point3 place = before.undo(centre);
  double size = length(now.apply(place) - centre);
  double turn = 0;
  for (std::size_t i = 0; i < 9; ++i) {
    const double d = now.scale * now.rotation[i] - before.scale * before.rotation[i];
    turn += d * d;
  }
  return size + radius * std::sqrt(turn);
}

/// Whether the last steps lead nowhere: together less far than half their sum, and they do not shrink.
bool goes_round(const std::vector<Motion>& passed, const std::vector<double>& steps, const Point3& centre,
                double radius) {
  constexpr std::size_t window = 10;
  constexpr double shrinking = 0.1;
  if (steps.size() < window) return false;
  const auto first = steps.end() - window;
  if (steps.back() < shrinking * *std::max_element(first, steps.end())) return false;
  const double sum = std::accumulate(first, steps.end(), 0.0);
  return size_of(passed[passed.size() - 1 - window], passed.back(), centre, radius) < sum / 2;
}

/// By how much the step lowers E, if the pairs stay.
double gain_of(const Twist& twist, const std::array<double, 49>& normal, double radius) {
  const auto length_of = [&](std::size_t i) { return twist[i] * (i < 3 || i == 6 ? radius : 1); };
  double gain = 0;
  for (std::size_t i = 0; i < 7; ++i)
    for (std::size_t j = 0; j < 7; ++j) gain += length_of(i) * normal[7 * i + j] * length_of(j);
  return gain;
}

class Search {
 public:
  Search(const OrientedCloud& moving, const OrientedCloud& fixed, const MatchOptions& options, const Context& context)
      : moving_(moving),
        o_(options),
        icp_(options.icp),
        overlap_(options.overlap),
        context_(context),
        kind_(pair_kind(options.objective)),
        of_means_(moving.of_means || fixed.of_means),
        floor_(information_floor(moving, fixed)),
        forward_(moving, fixed, false),
        backward_(fixed, moving, true) {}

  IcpState run(const Motion& start, FirstLevel first) {
    std::vector<std::size_t> strides{1};
    while (first != FirstLevel::none && moving_.points.size() / strides.back() > 2 * coarsest)
      strides.push_back(strides.back() * 8);
    std::reverse(strides.begin(), strides.end());
    begin(start, strides.front());
    level(strides.front(), strides.size() == 1);
    if (first == FirstLevel::twice && is_selective()) again(start, strides.front(), strides.size() == 1);
    for (std::size_t k = 1; k < strides.size(); ++k) level(strides[k], k + 1 == strides.size());
    return std::move(state_);
  }

 private:
  void begin(const Motion& start, std::size_t stride) {
    state_ = {};
    state_.motion = start;
    pair_up(stride);
    note();
  }

  /// Whether the pairs themselves say which of them are too long.
  [[nodiscard]] bool is_selective() const {
    return o_.overlap < 1 || o_.icp.weights != IcpOptions::Weights::uniform ||
           (o_.icp.reject_distance > 0 && !o_.icp.reject_distance_absolute);
  }

  /// The first level once more, its first half with all pairs alike, of any length; keeps the better one.
  void again(const Motion& start, std::size_t stride, bool last) {
    IcpState strict = std::move(state_);
    icp_.reject_distance = o_.icp.reject_distance_absolute ? o_.icp.reject_distance : 0;
    icp_.weights = IcpOptions::Weights::uniform;
    overlap_ = 1;
    begin(start, stride);
    level(stride, false);
    icp_ = o_.icp, overlap_ = o_.overlap;
    level(stride, last);
    const double width = std::min(residual_width(strict.links, kind_), residual_width(state_.links, kind_));
    if (fitting(state_.motion, stride, width) > fitting(strict.motion, stride, width)) return;
    state_ = std::move(strict);
  }

  /// Weight of all queries whose residual is below `width`, whatever the length of the pair.
  double fitting(const Motion& motion, std::size_t stride, double width) {
    IcpOptions all = o_.icp;
    all.reject_distance = 0;
    Sum sum;
    const auto add = [&](PairSearch& pairs) {
      for (const Link& l : pairs.find(motion, stride, all, 1))
        if (residual(l, kind_) <= width) sum.add(l.weight);
    };
    add(forward_);
    if (o_.icp.symmetric) add(backward_);
    return sum.value();
  }

  void pair_up(std::size_t stride) {
    state_.links = forward_.find(state_.motion, stride, icp_, overlap_);
    set_weights(state_.links, icp_.weights, kind_);
    const double asked = std::ceil(static_cast<double>(moving_.points.size()) / static_cast<double>(stride));
    state_.share = static_cast<double>(state_.links.size()) / asked;
    if (state_.share < least_share || state_.links.size() < least_links)
      throw OverlapError(fmt::format(
          "the scans do not overlap here: {} of {:.0f} points of MOVING have a partner in FIXED that passes "
          "the rejections; give @start, ask for @coarse, or loosen @reject-distance",
          state_.links.size(), asked));
    if (!icp_.symmetric) {
      state_.information = pair_information(state_.links, kind_);
      return;
    }
    both_ = state_.links;
    state_.back = backward_.find(state_.motion, stride, icp_, overlap_);
    set_weights(state_.back, icp_.weights, kind_);
    both_.insert(both_.end(), state_.back.begin(), state_.back.end());
    state_.information = pair_information(both_, kind_);
  }
  [[nodiscard]] const Array<Link>& links() const { return icp_.symmetric ? both_ : state_.links; }

  [[nodiscard]] Motion next() {
    const PairInformation& in = state_.information;
    if (kind_ != PairKind::point) {
      const bool plane = kind_ == PairKind::plane;
      const Twist twist = plane ? plane_step(in, o_.freedom, floor_) : planes_step(in, o_.freedom, floor_);
      gain_ = gain_of(twist, plane ? in.normal : in.planes, in.radius);
      return moved(state_.motion, twist, in.centre);
    }
    if (six_free(o_.freedom)) return composed(point_step(links(), in, o_.freedom.scale), state_.motion);
    return moved(state_.motion, point_twist(links(), in, o_.freedom), in.centre);
  }

  void note() {
    state_.history.push_back(
        {std::numeric_limits<double>::quiet_NaN(), std::sqrt(state_.information.error), state_.share});
  }

  /// Whether the last step was below so many standard deviations of the pose, were the residuals independent: means are
  /// a sample, and the steps that follow are no larger.
  [[nodiscard]] bool is_lost_in_noise(bool last) const {
    const double deviations = last ? last_deviations : coarse_deviations;
    return kind_ != PairKind::point &&
           gain_ * static_cast<double>(links().size()) < deviations * deviations * state_.information.error;
  }

  /// Pairs of points hold every point in its place, so that their steps shrink slowly, in straight lines.
  [[nodiscard]] bool accelerates(std::size_t steps) const {
    constexpr std::size_t plain_steps = 5;
    return kind_ == PairKind::point && steps >= plain_steps && six_free(o_.freedom);
  }

  void level(std::size_t stride, bool last) {
    pair_up(stride);
    const double tolerance = o_.tolerance > 0 ? o_.tolerance : default_match_tolerance;
    int quiet = 0;
    std::vector<Motion> passed{state_.motion};
    std::vector<double> steps;
    Anderson ahead(state_.motion, state_.information.centre, state_.information.radius);
    state_.converged = false;
    state_.reason = fmt::format("stopped after {} iterations (@max-iterations)", o_.max_iterations);
    while (state_.iterations < o_.max_iterations) {
      context_.check();
      const double error = state_.information.error, radius = state_.information.radius;
      const Point3 centre = state_.information.centre;
      const Motion before = state_.motion;
      const Motion plain = next();
      ++state_.iterations;
      const bool fast = accelerates(steps.size());
      state_.motion = fast ? ahead.next(before, plain) : plain;
      pair_up(stride);
      if (fast && !(state_.information.error <= error)) {  // too far: the plain step does not raise E
        ahead.forget();
        state_.motion = plain;
        pair_up(stride);
      }
      note();
      const double step = size_of(before, state_.motion, centre, radius);
      if (step <= (last ? tolerance : std::max(tolerance, coarse_step)) * radius) {
        state_.converged = true;
        state_.reason = "the last step was below the tolerance";
        return;
      }
      if (of_means_ && is_lost_in_noise(last)) {
        state_.converged = true;
        state_.reason = "the last step was nothing beside what noise does to the pose";
        return;
      }
      passed.push_back(state_.motion), steps.push_back(step);
      if (goes_round(passed, steps, centre, radius)) {
        state_.converged = true;
        state_.reason = "the pairs change to and fro, and the steps lead nowhere";
        return;
      }
      // What a pair more or less changes is no progress: E is known to 1/n of itself.
      const double noise = std::min(same_error * (last ? 1 : 100), 0.01 / state_.information.weight);
      quiet = std::fabs(state_.information.error - error) <= noise * error ? quiet + 1 : 0;
      if (quiet >= 2 || (!last && quiet >= 1)) {
        state_.converged = true;
        state_.reason = "E no longer changes";
        return;
      }
    }
  }

  const OrientedCloud& moving_;
  const MatchOptions& o_;
  IcpOptions icp_;  ///< and overlap_: what holds now; the options but in the first half of again()
  double overlap_;
  const Context& context_;
  PairKind kind_;
  bool of_means_;
  double floor_;
  double gain_ = 0;  ///< of the last step, but of points
  PairSearch forward_, backward_;
  Array<Link> both_;
  IcpState state_;
};

}  // namespace

double information_floor(const OrientedCloud& moving, const OrientedCloud& fixed) {
  constexpr double rounding = 1e-12;
  return std::max(rounding, 2 * std::max(moving.slope_noise, fixed.slope_noise));
}

IcpState icp_search(const OrientedCloud& moving, const OrientedCloud& fixed, const Motion& start,
                    const MatchOptions& options, FirstLevel first, const Context& context) {
  return Search(moving, fixed, options, context).run(start, first);
}

}  // namespace isopach
