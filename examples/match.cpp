// Finds the pose of a scan that was turned by 3 degrees about z and shifted, and refuses a pose that is not trusted.
#include <algorithm>
#include <cmath>
#include <iostream>

#include "isopach/base/option_key.hpp"
#include "isopach/match/match.hpp"
#include "isopach/simulate/scene.hpp"

int main() try {
  const isopach::Context context;
  isopach::SceneOptions options = isopach::scene_defaults("relief");
  options.points_a = options.points_b = 20000;
  options.variant = "rough";
  const isopach::Scene scene = isopach::make_scene("relief", options, context);

  const double c = std::cos(0.0524), s = std::sin(0.0524);
  const isopach::Pose truth{{c, -s, 0, 15, s, c, 0, -8, 0, 0, 1, 2, 0, 0, 0, 1}};  // takes MOVING to FIXED
  isopach::Cloud fixed = scene.b;
  for (isopach::Point3& p : fixed.points) p = truth.apply(p);

  const isopach::Matching m = isopach::match(scene.a, fixed, isopach::MatchOptions{}, context);
  isopach::require_trust(m, "match");  // throws where the scans do not confirm the pose
  double largest = 0;
  for (const isopach::Point3& p : scene.a.points) {
    const isopach::Point3 is = m.pose.apply(p), should = truth.apply(p);
    largest = std::max(largest, std::hypot(is.x - should.x, is.y - should.y, is.z - should.z));
  }
  std::cout << "mean |d| " << m.before.rho << " before, " << m.after.rho << " after"
            << "\nno point is farther than " << largest << " " << m.unit << " from its true place\n";
  return largest < 0.5 ? 0 : 1;
} catch (const isopach::Error& error) {
  std::cerr << isopach::for_keywords(error.what()) << "\n";
  return static_cast<int>(error.code());
}
