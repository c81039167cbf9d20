// Fits of points to quadrics on scans of tests/apps/held_object.hpp, whose truth is known.
#include "isopach/apps/quadric_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "isopach/apps/motions.hpp"
#include "isopach/apps/part_fit.hpp"
#include "isopach/distance/vectors.hpp"
#include "tests/apps/held_object.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

OrientedCloud flat(const Cloud& cloud, const Frame& frame) {
  OrientedCloud result = order_points(cloud, Pose{}, frame, {}, 0, {});
  orient(result, {});
  flatten(result);
  return result;
}

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Object and scan lie on one another as they are: what the fit moves is its error.
Vector6 error_of(const QuadricFit& fit) {
  const Point3 c = fit.information.centre, shift = fit.motion.apply(c) - c;
  const auto& r = fit.motion.rotation;
  Vector6 e;
  e << (r[7] - r[5]) / 2, (r[2] - r[6]) / 2, (r[3] - r[1]) / 2, shift.x, shift.y, shift.z;
  return e;
}

std::optional<QuadricFit> fit_of(const Cloud& object, const Cloud& scan, const Motion& start = {}) {
  const Frame frame = choose_frame(scan, object, Pose{}, {}, {});
  return fit_quadrics(flat(object, frame), flat(scan, frame), start, 0.3, {});
}

TEST(QuadricFit, ExactOnAQuadricWhateverTheDensities) {
  const auto bowl = [](double x, double y) { return 0.01 * x * x - 0.006 * x * y + 0.015 * y * y + 0.1 * x; };
  for (const auto& [object, scan] : {std::pair{2500, 400}, {400, 2500}}) {
    test::HeldObjectScanner scanner(3);
    const Cloud a = scanner.alone(static_cast<std::size_t>(object), 0, bowl);
    const Cloud b = scanner.alone(static_cast<std::size_t>(scan), 0, bowl);
    Motion start;
    start.shift = {0.02, -0.03, 0.1};
    const auto fit = fit_of(a, b, start);
    ASSERT_TRUE(fit);
    // A tangent plane is not that of the quadric itself: heights are along it, so that a quadric is one to third order.
    EXPECT_LT(error_of(*fit).head<3>().norm(), 4e-4);
    EXPECT_LT(error_of(*fit).tail<3>().norm(), 1e-2);
    EXPECT_EQ(fit->object_asks, object < scan);
  }
}

/// The covariance of many draws is that which each of them states: chi² of the errors, dense and sparse to either side.
TEST(QuadricFit, CovarianceIsThatOfManyDraws) {
  constexpr int draws = 16;
  for (const auto& [object, scan] : {std::pair{4000, 900}, {900, 4000}, {2500, 2500}}) {
    double sum = 0;
    int within = 0;
    for (int k = 0; k < draws; ++k) {
      test::HeldObjectScanner scanner(static_cast<std::uint64_t>(100 + k));
      const Cloud a = scanner.alone(static_cast<std::size_t>(object), 0.05);
      const Cloud b = scanner.alone(static_cast<std::size_t>(scan), 0.05);
      const auto fit = fit_of(a, b);
      ASSERT_TRUE(fit);
      const Vector6 e = error_of(*fit);
      const Eigen::Map<const Eigen::Matrix<double, 6, 6>> c(fit->covariance.data());
      const double chi2 = e.dot(c.ldlt().solve(e));
      sum += chi2, within += chi2 < 12.592;
    }
    // The mean of 16 draws of chi² with 6 freedoms has standard deviation 0.87; fewer than 12 within: once in 500.
    EXPECT_NEAR(sum / draws, 6, 3) << object << " " << scan;
    EXPECT_GE(within, 12) << object << " " << scan;
  }
}

TEST(QuadricFit, SameBitsForAnyOrder) {
  test::HeldObjectScanner scanner(5);
  const Cloud a = scanner.alone(2000, 0.05), b = scanner.held(900, 0.05, 0.2);
  const auto fit = fit_of(a, b), again = fit_of(test::shuffled(a, 1), test::shuffled(b, 2));
  ASSERT_TRUE(fit && again);
  EXPECT_EQ(fit->motion.rotation, again->motion.rotation);
  EXPECT_EQ(fit->motion.shift, again->motion.shift);
  EXPECT_EQ(fit->covariance, again->covariance);
}

TEST(QuadricFit, NothingWhereHardlyAPointIsNear) {
  test::HeldObjectScanner scanner(6);
  const Cloud a = scanner.alone(1000, 0.05);
  EXPECT_FALSE(fit_of(a, test::shifted(a, {0, 0, 300})));
}

}  // namespace
}  // namespace isopach
