// The scene of `combine`: its poses take the object's points to where they lie in both scans.
#include "isopach/simulate/face_and_jaw.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "isopach/distance/point_tree.hpp"

namespace isopach {
namespace {

FaceAndJawOptions small() {
  FaceAndJawOptions o;
  o.points = 12000;
  o.noise = 0;
  return o;
}

/// Share of the object's points that have a point of the scan within 2 mm, once they are where `pose` says.
double share_there(const Cloud& scan, const Cloud& reference, const Pose& pose) {
  const PointTree tree(scan.points);
  double there = 0;
  for (const Point3& p : reference.points) there += tree.nearest_distance2(pose.apply(p)) < 4 ? 1 : 0;
  return there / static_cast<double>(reference.points.size());
}

TEST(FaceAndJaw, TheObjectIsWhereTheTruthSays) {
  const FaceAndJaw s = make_face_and_jaw(small(), 3);
  EXPECT_GT(share_there(s.face, s.reference, s.face_reference), 0.99);
  EXPECT_GT(share_there(s.jaw, s.reference, s.jaw_reference), 0.99);
  EXPECT_LT(share_there(s.face, s.reference, s.jaw_reference), 0.2);
  EXPECT_GT(s.face_share, 0.15);
  EXPECT_GT(s.jaw_share, 0.15);
  // T_face_jaw chains the two.
  const Point3 p{3, -8, 2}, in_jaw = s.jaw_reference.apply(p), in_face = s.face_reference.apply(p);
  const Point3 q = s.face_jaw.apply(in_jaw);
  EXPECT_NEAR(q.x, in_face.x, 1e-9);
  EXPECT_NEAR(q.y, in_face.y, 1e-9);
  EXPECT_NEAR(q.z, in_face.z, 1e-9);
}

TEST(FaceAndJaw, ForgottenAndSeeded) {
  FaceAndJawOptions o = small();
  const FaceAndJaw one = make_face_and_jaw(o, 3), again = make_face_and_jaw(o, 3), other = make_face_and_jaw(o, 4);
  EXPECT_EQ(one.jaw.points, again.jaw.points);
  EXPECT_NE(one.jaw.points, other.jaw.points);
  o.held = false;
  const FaceAndJaw without = make_face_and_jaw(o, 3);
  EXPECT_EQ(without.face_share, 0);
  EXPECT_LT(share_there(without.face, without.reference, without.face_reference), 0.3);
}

TEST(FaceAndJaw, RefusesWhatMakesNoSense) {
  FaceAndJawOptions o = small();
  o.points = 10;
  EXPECT_THROW((void)make_face_and_jaw(o, 1), UsageError);
  o = small(), o.noise = -1;
  EXPECT_THROW((void)make_face_and_jaw(o, 1), UsageError);
  o.noise = std::numeric_limits<double>::infinity();
  EXPECT_THROW((void)make_face_and_jaw(o, 1), UsageError);
}

}  // namespace
}  // namespace isopach
