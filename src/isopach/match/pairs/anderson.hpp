// Anderson acceleration of a search that repeats one and the same step: where steps point one way and shrink slowly,
// their differences tell where they lead [Walker2011], here of motions [Pavlov2018].
#pragma once
#include <vector>

#include "isopach/match/motion.hpp"

namespace isopach {

class Anderson {
 public:
  /// Motions are seen as twists from `base` about `centre`; turns and scale are counted in `radius` · angle.
  Anderson(const Motion& base, const Point3& centre, double radius) : base_(base), centre_(centre), radius_(radius) {}

  /// The step took `from` to `to`. Where the last six such steps together lead: the affine combination of them whose
  /// step is the least; `to` where there is one alone. Cost O(1). Test: Anderson.* in tests/match/means_test.cpp.
  [[nodiscard]] Motion next(const Motion& from, const Motion& to);
  void forget() { steps_.clear(); }

 private:
  struct Step {
    Twist to, length;  ///< lengths: turns and scale times the radius
  };
  [[nodiscard]] Twist twist_to(const Motion& motion) const;

  Motion base_;
  Point3 centre_;
  double radius_;
  std::vector<Step> steps_;  ///< the latest last
};

}  // namespace isopach
