// Judge: the verdicts of one matching. Both scans are prepared once, at the first verdict.
#pragma once
#include <optional>
#include <vector>

#include "isopach/match/matching.hpp"

namespace isopach {

class Judge {
 public:
  /// `options` and `context` are kept by reference. `options` as in match().
  Judge(const CloudView& moving, const CloudView& fixed, const MatchOptions& options, const Context& context)
      : moving_(moving), fixed_(fixed), options_(options), context_(context) {}

  /// From now on these are nominal meshes, judged by points on their faces: their corners alone show too little.
  void take_as_nominal(bool moving, bool fixed);

  /// Verdict on a pose, by the motions that are free.
  [[nodiscard]] Verdict operator()(const Pose& pose);

  /// Whether the second lies farther from the first than other_turn or other_shift.
  [[nodiscard]] bool is_another(const Pose& from, const Pose& to);
  [[nodiscard]] Rival apart_from(const Pose& from, const Pose& to);
  /// How far `at` lies on the way of MOVING from one pose to another: 0 at the first, 1 at the second, by least squares
  /// over its points; what leads off that way does not count.
  [[nodiscard]] double share_of_way(const Pose& from, const Pose& to, const Pose& at);

  /// Poses that take MOVING to where it looks as at `pose`, because the larger of the scans repeats itself (repeats()).
  [[nodiscard]] std::vector<Pose> repeated(const Pose& pose);

  /// Of every point of MOVING at the pose.
  [[nodiscard]] Array<PointVerdict> labels(const Pose& pose, const Verdict& verdict);

 private:
  struct Scans {
    JudgedScan moving, fixed;
    std::array<double, 9> axes{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< that the freedom speaks of
  };
  const Scans& scans();
  [[nodiscard]] JudgedScan judged(const CloudView& cloud, const ProjectOptions& project, bool nominal) const;

  CloudView moving_, fixed_;
  const MatchOptions& options_;
  const Context& context_;
  bool nominal_moving_ = false, nominal_fixed_ = false;
  std::optional<Scans> scans_;
};

}  // namespace isopach
