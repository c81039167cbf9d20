// What both sides of a scan say about a plane, on a face whose plane is known.
#include "isopach/apps/symmetry_check.hpp"

#include <gtest/gtest.h>

#include "isopach/apps/asymmetry.hpp"
#include "tests/apps/faces.hpp"

namespace isopach {
namespace {

Cloud seen_from_front(const test::FaceScan& scan) { return test::face_scan(scan); }

PoseEvidence evidence_at_turn(const test::FaceScan& scan, double degrees) {
  const Cloud cloud = seen_from_front(scan);
  return symmetry_evidence(placed(cloud.points, Upright{}.turned_and_shifted(0, degrees, 0)), {});
}

TEST(SymmetryCheck, BothSidesAgreeAboutThePlaneAloneAndNotAboutOthers) {
  const test::FaceScan scan;
  const PoseEvidence right = evidence_at_turn(scan, 0);
  EXPECT_GT(right.agree, 0.95);
  EXPECT_GT(right.shape, 0.9);
  EXPECT_TRUE(is_symmetric(right));
  for (const double turn : {-30.0, -15.0, 15.0, 30.0}) EXPECT_FALSE(is_symmetric(evidence_at_turn(scan, turn))) << turn;
}

TEST(SymmetryCheck, ASwellingOfACheekIsNoDoubt) {
  const Bump bump = test::cheek(8);
  test::FaceScan scan;
  scan.added = [&](double x, double y) { return bump.at(x, y); };
  EXPECT_TRUE(is_symmetric(evidence_at_turn(scan, 0)));
}

TEST(SymmetryCheck, ScansWithoutDetailAreJudgedByAgreementAlone) {
  PoseEvidence e;
  e.points_in_view = 100, e.agree = 0.9, e.shape = 0, e.detail = {0.1, 0.9};
  EXPECT_TRUE(is_symmetric(e));
  e.detail = {0.9, 0.9};
  EXPECT_FALSE(is_symmetric(e));
  e.shape = 0.3;
  EXPECT_TRUE(is_symmetric(e)) << "coarse points: shape counts less where almost all agrees";
  e.shape = 0.9, e.agree = 0.4;
  EXPECT_FALSE(is_symmetric(e));
  EXPECT_NE(sides_sentence(e).find("40 % agrees within noise (needs 50 %), and their shapes agree by 0.90"),
            std::string::npos);
}

TEST(SymmetryCheck, OtherPlaneIsTheOneInSpace) {
  const Cloud cloud = seen_from_front({});
  const Upright wrong = Upright{}.turned_and_shifted(0, 25, 20);
  const std::optional<Upright> found = other_plane(cloud.points, wrong, {1, 0, 0}, {}, {});
  ASSERT_TRUE(found.has_value());
  EXPECT_GT(found->axis(0).x, 0.9999);
  EXPECT_NEAR(dot(found->axis(0), found->origin), 0, 0.3);
}

TEST(SymmetryCheck, SigmaGrowsWhereTheSidesDiffer) {
  test::FaceScan scan;
  const PlaneSigma even = plane_sigma(seen_from_front(scan).points, Upright{}, {}, {});
  EXPECT_LT(even.angle, 0.06);
  EXPECT_LT(even.offset, 0.06);
  // One side of the forehead 1.5 mm higher, with soft flanks.
  const Bump bump{{35, 70}, 1.5, 60, 50, {1, 0}, 0, 0};
  scan.added = [&](double x, double y) { return bump.at(x, y); };
  const PlaneSigma uneven = plane_sigma(seen_from_front(scan).points, Upright{}, {}, {});
  EXPECT_GT(uneven.angle, 3 * even.angle);
}

// More points than the jackknife takes: means of neighbours, which must not be those of the file.
TEST(SymmetryCheck, SigmaIsThatOfThePointsInAnyOrder) {
  test::FaceScan scan;
  scan.points = 20000;
  Array<Point3> points = seen_from_front(scan).points;
  const PlaneSigma sorted = plane_sigma(points, Upright{}, {}, {});
  EXPECT_LT(sorted.angle, 0.05);
  const RandomStream random(3, 1);
  for (std::size_t i = points.size(); i-- > 1;)
    std::swap(points[i], points[static_cast<std::size_t>(random.uniform(i) * static_cast<double>(i + 1))]);
  const PlaneSigma shuffled = plane_sigma(points, Upright{}, {}, {});
  EXPECT_EQ(shuffled.angle, sorted.angle);
  EXPECT_EQ(shuffled.offset, sorted.offset);
}

}  // namespace
}  // namespace isopach
