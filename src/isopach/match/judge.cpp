#include "isopach/match/judge.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/distance/vectors.hpp"
#include "isopach/match/checks.hpp"
#include "isopach/match/coarse/repeats.hpp"
#include "isopach/match/surface/nominal.hpp"
#include "isopach/match/verdict/another.hpp"

namespace isopach {

void Judge::take_as_nominal(bool moving, bool fixed) {
  if ((!moving || nominal_moving_) && (!fixed || nominal_fixed_)) return;
  nominal_moving_ = nominal_moving_ || moving, nominal_fixed_ = nominal_fixed_ || fixed;
  scans_.reset();
}

JudgedScan Judge::judged(const CloudView& cloud, const ProjectOptions& project, bool nominal) const {
  if (!nominal) return judged_scan(cloud, project, context_);
  ProjectOptions all = project;
  all.classes.clear();  // of points, which these are not
  return judged_scan(points_on_faces(cloud, judged_points, context_.seed), all, context_);
}

const Judge::Scans& Judge::scans() {
  if (scans_) return *scans_;
  scans_ = Scans{};
  const ProjectOptions& project = options_.compare.project;
  ProjectOptions uncropped = project;  // a crop is of input coordinates: what of MOVING lies in it hangs on the pose
  uncropped.crop.reset();
  both([&] { scans_->fixed = judged(fixed_, project, nominal_fixed_); },
       [&] { scans_->moving = judged(moving_, uncropped, nominal_moving_); });
  if (!all_rigid_motions(options_.freedom))
    scans_->axes = choose_frame(fixed_, moving_, options_.start, uncropped, context_).rotation;
  return *scans_;
}

Verdict Judge::operator()(const Pose& pose) {
  const Scans& s = scans();
  Verdict v = judge(s.moving, s.fixed, pose, options_.freedom, s.axes);
  v.accepted = options_.accept_doubt;
  return v;
}

Rival Judge::apart_from(const Pose& from, const Pose& to) { return apart(from, to, scans().moving.origin); }

bool Judge::is_another(const Pose& from, const Pose& to) {
  return isopach::is_another(from, to, scans().moving.origin, scans().fixed.extent);
}

double Judge::share_of_way(const Pose& from, const Pose& to, const Pose& at) {
  const JudgedScan& moving = scans().moving;
  double along = 0, whole = 0;
  for (const Index i : moving.queries) {
    const Point3 p = moving.points[i] + moving.origin, begin = from.apply(p), way = to.apply(p) - begin;
    along += dot(at.apply(p) - begin, way), whole += dot(way, way);
  }
  return whole > 0 ? along / whole : 0;
}

std::vector<Pose> Judge::repeated(const Pose& pose) {
  const Scans& s = scans();
  constexpr double larger = 1.2;
  const bool of_moving = s.moving.extent > larger * s.fixed.extent;
  const JudgedScan& scan = of_moving ? s.moving : s.fixed;
  Frame frame;
  frame.origin = scan.origin;
  std::vector<Pose> poses;
  for (const Motion& motion : repeats(scan, context_))
    poses.push_back(of_moving ? composed(pose, pose_of(motion, frame, Pose{})) : pose_of(motion, frame, pose));
  return poses;
}

Array<PointVerdict> Judge::labels(const Pose& pose, const Verdict& verdict) {
  return agreement_of(moving_, scans().fixed, pose, std::hypot(verdict.evidence.noise[0], verdict.evidence.noise[1]),
                      context_);
}

}  // namespace isopach
