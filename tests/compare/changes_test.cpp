// Changes as objects in a comparison: σ against heights moved one at a time, points against the fields at the points.
#include "isopach/compare/changes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/compare/compare.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

constexpr double lod = 0.3;

CompareOptions options_of(UncertaintyModel model) {
  CompareOptions o;
  o.check_layers = false;
  o.changes.asked = true;
  o.changes.min_area = 0;
  o.uncertainty.lod = lod;
  o.uncertainty.model = model;
  o.uncertainty.sigma1 = {SigmaSource::Kind::attribute, 0, "noise"};
  o.uncertainty.sigma2 = {SigmaSource::Kind::attribute, 0, "noise"};
  return o;
}

Cloud with_sigma(Cloud cloud, std::uint64_t seed) {
  Random random(seed);
  cloud.attributes.push_back({"noise", Array<double>(cloud.points.size())});
  for (double& s : cloud.attributes[0].values) s = random.uniform(0.01, 0.1);
  return cloud;
}

// ∫ (|d| − level) over the object with its largest |d| at a place: its derivative has no part of the moving outline.
double beyond(const Comparison& c, const Point2& peak) {
  for (const Change& change : c.changes->list) {
    const Point3 at = c.frame.to_input({change.largest_at.x, change.largest_at.y, 0});
    if (std::hypot(at.x - peak.x, at.y - peak.y) < 1e-9) return change.volume - lod * change.area;
  }
  ADD_FAILURE() << "no such object";
  return 0;
}

TEST(ChangeSigma, IsThatOfHeightsMovedOneByOne) {
  const Cloud a = with_sigma(rough_cloud(uniform(40, 421), 422), 423),
              b = with_sigma(rough_cloud(uniform(60, 424), 425), 426);
  const CompareOptions o = options_of(UncertaintyModel::independent);
  const Comparison whole = compare(a, b, o, {});
  ASSERT_GE(whole.changes->list.size(), 2U);
  for (std::size_t object = 0; object < 2; ++object) {
    const Change& change = whole.changes->list[object];
    const Point3 at = whole.frame.to_input({change.largest_at.x, change.largest_at.y, 0});
    double variance = 0;
    for (const bool first : {true, false}) {
      const Cloud& cloud = first ? a : b;
      for (std::size_t i = 0; i < cloud.points.size(); ++i) {
        constexpr double step = 1e-6;
        std::array<double, 2> v{};
        for (const std::size_t side : {0U, 1U}) {
          Cloud moved = cloud;
          moved.points[i].z += side == 0 ? step : -step;
          v[side] = beyond(first ? compare(moved, b, o, {}) : compare(a, moved, o, {}), {at.x, at.y});
        }
        variance += std::pow((v[0] - v[1]) / (2 * step) * cloud.attributes[0].values[i], 2);
      }
    }
    EXPECT_NEAR(*change.sigma, std::sqrt(variance), 1e-6 * std::sqrt(variance));
  }
}

TEST(ChangeSigma, OfErrorsThatAreAllAlikeIsThatOfAShift) {
  const Cloud a = with_sigma(rough_cloud(uniform(200, 431), 432), 433),
              b = with_sigma(rough_cloud(uniform(300, 434), 435), 436);
  CompareOptions o = options_of(UncertaintyModel::registration);
  o.uncertainty.sigma1 = o.uncertainty.sigma2 = {};
  CompareOptions by_pose = o;
  o.uncertainty.registration_error = 0.02;
  by_pose.uncertainty.registration_covariance = PoseCovariance{};
  by_pose.uncertainty.registration_covariance->matrix[35] = 0.02 * 0.02;  // of the shift along z alone
  const Comparison shifted = compare(a, b, o, {}), posed = compare(a, b, by_pose, {});
  ASSERT_EQ(shifted.changes->list.size(), posed.changes->list.size());
  for (std::size_t i = 0; i < shifted.changes->list.size(); ++i) {
    const Change& change = shifted.changes->list[i];
    EXPECT_NEAR(*change.sigma, 0.02 * change.area, 1e-14);
    EXPECT_NEAR(*posed.changes->list[i].sigma, 0.02 * change.area, 1e-12);
  }
  // Of heights that err alike over a range far larger than the scene: the same σ everywhere, from both scans.
  CompareOptions correlated = options_of(UncertaintyModel::correlated);
  correlated.uncertainty.correlation_range = 1e6;
  correlated.uncertainty.sigma1 = {SigmaSource::Kind::constant, 0.03, ""};
  correlated.uncertainty.sigma2 = {SigmaSource::Kind::constant, 0.04, ""};
  const Comparison alike = compare(a, b, correlated, {});
  for (const Change& change : alike.changes->list)
    EXPECT_NEAR(*change.sigma, 0.05 * change.area, 0.01 * 0.05 * change.area);
}

TEST(ChangePoints, AreThoseWhoseDifferenceExceedsTheLevel) {
  Cloud a = with_sigma(rough_cloud(uniform(400, 441), 442), 443);
  const Cloud b = with_sigma(rough_cloud(uniform(500, 444), 445), 446);
  for (std::size_t i = 0; i < 20; ++i) {  // places that have two points
    a.points.push_back(a.points[i]);
    a.attributes[0].values.push_back(a.attributes[0].values[i]);
  }
  const Comparison c = compare(a, b, options_of(UncertaintyModel::independent), {});
  std::array<std::size_t, 2> found{}, expected{};
  for (const Change& change : c.changes->list)
    for (const std::size_t scan : {0U, 1U}) found[scan] += change.points[scan];
  for (const double d : c.fields_a.dz_signed) expected[0] += std::fabs(d) > lod ? 1 : 0;
  for (const double d : c.fields_b.dz_signed) expected[1] += std::fabs(d) > lod ? 1 : 0;
  for (const std::size_t scan : {0U, 1U}) {  // those on the border are corners of no whole cell
    EXPECT_LE(found[scan], expected[scan]);
    EXPECT_GE(found[scan] + 8, expected[scan]);
  }
}

}  // namespace
}  // namespace isopach::test
