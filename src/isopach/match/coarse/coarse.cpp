#include "isopach/match/coarse/coarse.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "isopach/base/error.hpp"
#include "isopach/base/median.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/coarse/consensus.hpp"
#include "isopach/match/coarse/landmarks.hpp"
#include "isopach/match/pairs/icp_search.hpp"
#include "isopach/match/verdict/another.hpp"

namespace isopach {
namespace {

constexpr std::size_t landmark_points = 48000;  // of each scan, for the means
constexpr std::size_t landmark_count = 1800;    // of the larger scan
constexpr std::size_t points_of_one = 4;        // at least, where a scan has so many
constexpr std::size_t likeness_count = 1500;
constexpr std::size_t candidate_count = 6;  // of each side of the surface
constexpr std::size_t trial_points = 4000;  // of each scan, in a trial
constexpr int trial_iterations = 12;
constexpr double least_share = 0.25;  // of the smaller scan that must come to lie on the other
constexpr double fit_widths = 3;      // a trial counts what fits within so many medians of the best one

/// Every k-th point, so that at most about `most` remain.
Array<Point3> some_of(const Array<Point3>& points, std::size_t most) {
  const std::size_t stride = std::max<std::size_t>(1, points.size() / most);
  Array<Point3> result;
  for (std::size_t i = 0; i < points.size(); i += stride) result.push_back(points[i]);
  return result;
}

OrientedCloud trial_cloud(const Array<Point3>& points, const Context& context) {
  OrientedCloud cloud;
  cloud.points = some_of(points, trial_points);
  cloud.ids.resize(cloud.points.size());
  for (std::size_t i = 0; i < cloud.ids.size(); ++i) cloud.ids[i] = static_cast<Index>(i);
  orient(cloud, context);
  return cloud;
}

/// The residuals of a trial, from both sides.
struct Trial {
  Motion motion;
  std::array<Array<double>, 2> residuals;  ///< of the queries whose partner lies inside the other scan
  std::array<std::size_t, 2> asked{};
  double middle = 0;  ///< median of all residuals

  [[nodiscard]] double share() const {
    double most = 0;
    for (std::size_t k = 0; k < 2; ++k)
      most = std::max(most, static_cast<double>(residuals[k].size()) / static_cast<double>(asked[k]));
    return most;
  }
  /// How much of the smaller scan fits within `width`.
  [[nodiscard]] double score(double width) const {
    double best = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      double sum = 0;
      for (const double r : residuals[k]) sum += std::max(0.0, 1 - (r / width) * (r / width));
      best = std::max(best, sum / static_cast<double>(asked[k]));
    }
    return best;
  }
};

class Trials {
 public:
  Trials(const Array<Point3>& moving, const Array<Point3>& fixed, double reach, const Context& context)
      : reach_(reach), context_(context) {
    both([&] { moving_ = trial_cloud(moving, context); }, [&] { fixed_ = trial_cloud(fixed, context); });
    options_.objective = Objective::icp_plane;
    options_.max_iterations = trial_iterations;
  }

  /// A few steps of ICP from `start`; nothing where it loses the other scan.
  [[nodiscard]] std::optional<Trial> run(const Motion& start) const {
    Trial trial;
    try {
      trial.motion = icp_search(moving_, fixed_, start, options_, FirstLevel::once, context_).motion;
    } catch (const OverlapError&) {
      return std::nullopt;
    }
    collect(moving_, fixed_, trial.motion, false, trial.residuals[0]);
    collect(fixed_, moving_, trial.motion, true, trial.residuals[1]);
    trial.asked = {moving_.points.size(), fixed_.points.size()};
    if (trial.share() < least_share) return std::nullopt;
    Array<double> all = trial.residuals[0];
    all.insert(all.end(), trial.residuals[1].begin(), trial.residuals[1].end());
    trial.middle = median(all);
    return trial;
  }
  [[nodiscard]] double roughness() const { return std::max(moving_.roughness, fixed_.roughness); }

 private:
  void collect(const OrientedCloud& queries, const OrientedCloud& target, const Motion& motion, bool inverse,
               Array<double>& residuals) const {
    Array<double> all(queries.points.size());
    for_each_index(queries.points.size(), [&](std::size_t i) {
      const Point3 p = inverse ? motion.undo(queries.points[i]) : motion.apply(queries.points[i]);
      const PointTree::Two two = target.tree->nearest_two(p);
      const bool outside = target.boundary[two.first] != 0 || two.first2 > reach_ * reach_;
      all[i] = outside ? -1 : std::fabs(dot(p - target.points[two.first], target.normals[two.first]));
    });
    for (const double r : all)
      if (r >= 0) residuals.push_back(r);
  }

  OrientedCloud moving_, fixed_;
  MatchOptions options_;
  double reach_;
  const Context& context_;
};

Point3 mean_of(const CloudView& cloud) {
  Box3 box;
  for (const Point3& p : cloud.points)
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) box.add(p);
  return {(box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2, (box.min.z + box.max.z) / 2};
}

/// MOVING brought to where FIXED is, unturned, so that all coordinates are small.
Pose middle_on_middle(const CloudView& moving, const CloudView& fixed) {
  const Point3 d = mean_of(fixed) - mean_of(moving);
  Pose pose;
  pose.m[3] = d.x, pose.m[7] = d.y, pose.m[11] = d.z;
  return pose;
}

/// Motions that the landmarks of both sides of the surface agree on.
std::vector<Motion> candidates(const Array<Point3>& moving, const Array<Point3>& fixed, double side,
                               const Context& context) {
  Landmarks a, b;
  both([&] { a = landmarks(fixed, side, context); }, [&] { b = landmarks(moving, side, context); });
  describe(a, b, context);
  std::vector<Motion> result;
  for (const bool turned : {false, true})
    for (const Agreement& found :
         agreements(likenesses(b, a, turned, likeness_count, context), side, candidate_count, context))
      result.push_back(found.motion);
  return result;
}

double extent_of(const Array<Point3>& points) {
  Box3 box;
  for (const Point3& p : points) box.add(p);
  return length(box.max - box.min);
}

}  // namespace

std::vector<Pose> coarse_poses(const CloudView& moving, const CloudView& fixed, const MatchOptions& options,
                               std::size_t most, const Context& context) {
  const ProjectOptions& project = options.compare.project;
  ProjectOptions uncropped = project;  // what of MOVING lies in the crop is known at the pose alone
  uncropped.crop.reset();
  const Pose start = middle_on_middle(moving, fixed);
  const Frame frame = choose_frame(fixed, moving, start, uncropped, context);
  OrientedCloud a, b;
  both([&] { a = order_points(fixed, Pose{}, frame, project, 0, context); },
       [&] { b = order_points(moving, start, frame, uncropped, 0, context); });
  const std::size_t target =
      std::clamp<std::size_t>(std::max(a.points.size(), b.points.size()) / points_of_one, 50, landmark_count);
  const Array<Point3> few_a = some_of(a.points, landmark_points), few_b = some_of(b.points, landmark_points);
  const double side = landmark_side(few_a, few_b, target);

  std::vector<Motion> starts{Motion{}};
  for (const Motion& m : candidates(few_b, few_a, side, context)) starts.push_back(m);
  const Trials trials(b.points, a.points, 2 * side, context);
  std::vector<Trial> found;
  double least = std::numeric_limits<double>::infinity();
  for (const Motion& m : starts) {
    context.check();
    std::optional<Trial> trial = trials.run(m);
    if (!trial) continue;
    least = std::min(least, trial->middle);
    found.push_back(std::move(*trial));
  }
  // The best trial tells how well these scans can fit; the one with the most that fits so well is right.
  const double width = fit_widths * std::max(least, std::numeric_limits<double>::min());
  std::vector<std::pair<double, const Trial*>> ranked;
  for (const Trial& trial : found) ranked.emplace_back(trial.score(width), &trial);
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& x, const auto& y) { return x.first > y.first; });
  if (ranked.empty() || !(ranked.front().first >= least_share / 2))
    throw OverlapError(
        "@coarse: no place was found where the scans fit one another; are they of one surface? Give @start if so");
  const Point3 middle = mean_of(moving);
  const double extent = extent_of(a.points);
  std::vector<Pose> poses;
  for (const auto& [score, trial] : ranked) {
    if (poses.size() >= most) break;
    const Pose pose = pose_of(trial->motion, frame, start);
    const bool is_new = std::all_of(poses.begin(), poses.end(),
                                    [&](const Pose& other) { return is_another(other, pose, middle, extent); });
    if (is_new) poses.push_back(pose);
  }
  return poses;
}

Pose coarse_start(const CloudView& moving, const CloudView& fixed, const MatchOptions& options,
                  const Context& context) {
  return coarse_poses(moving, fixed, options, 1, context).front();
}

}  // namespace isopach
