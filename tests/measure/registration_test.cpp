// What an error of the pose does to heights and volumes: against scans that are moved by a little.
#include "isopach/measure/uncertainty/registration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "isopach/base/error.hpp"
#include "isopach/compare/compare.hpp"
#include "tests/support/clouds.hpp"

namespace isopach::test {
namespace {

/// Diagonal, with two numbers that go together.
PoseCovariance example(const Point3& centre) {
  PoseCovariance c;
  constexpr std::array<double, 6> deviation{0.02, 0.01, 0.03, 0.05, 0.04, 0.02};
  for (std::size_t i = 0; i < 6; ++i) c.matrix[7 * i] = deviation[i] * deviation[i];
  c.matrix[6 * 0 + 5] = c.matrix[6 * 5 + 0] = 0.7 * deviation[0] * deviation[5];
  c.centre = centre;
  return c;
}

/// p + ω × (p − c) + t, where only motion number `i` is `step`.
Cloud moved(Cloud cloud, std::size_t i, double step, const Point3& c) {
  std::array<double, 6> m{};
  m[i] = step;
  for (Point3& p : cloud.points) {
    const Point3 r{p.x - c.x, p.y - c.y, p.z - c.z};
    p = {p.x + m[1] * r.z - m[2] * r.y + m[3], p.y + m[2] * r.x - m[0] * r.z + m[4],
         p.z + m[0] * r.y - m[1] * r.x + m[5]};
  }
  return cloud;
}

/// Points of `around` reach beyond those of `inside` on all sides, so the domain is the hull of `inside`.
Cloud inside() { return rough_cloud(uniform(70, 601), 602); }
Cloud around(std::size_t n = 120) {
  Points xy = uniform(n, 603);
  for (Point2& p : xy) p = {3 * p.x - 1, 3 * p.y - 1};
  return rough_cloud(xy, 604);
}

CompareOptions overlay_options() {
  CompareOptions o;
  o.surface = Surface::overlay;
  o.border = BorderRule::hull;
  o.check_layers = false;
  return o;
}

// ∂ of the three volumes by each motion of B.
std::array<VolumeTriple, 6> by_differences(const Cloud& a, const Cloud& b, const CompareOptions& o, const Point3& c) {
  std::array<VolumeTriple, 6> result;
  constexpr double step = 1e-5;
  for (std::size_t i = 0; i < 6; ++i) {
    const Volume up = compare(a, moved(b, i, step, c), o, {}).measures.volume,
                 down = compare(a, moved(b, i, -step, c), o, {}).measures.volume;
    result[i] = {(up.net - down.net) / (2 * step), (up.above - down.above) / (2 * step),
                 (up.below - down.below) / (2 * step)};
  }
  return result;
}

double deviation(const std::array<VolumeTriple, 6>& g, double VolumeTriple::*part, const PoseCovariance& c) {
  double sum = 0;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) sum += g[i].*part * c.matrix[6 * i + j] * g[j].*part;
  return std::sqrt(sum);
}

TEST(Registration, OfTheVolumesIsThatOfScansThatAreMoved) {
  const Cloud a = inside(), b = around();
  const PoseCovariance c = example({0.3, -0.4, 0.9});
  for (const Direction& direction : {Direction{}, Direction{Direction::Kind::vector, {0.05, -0.1, 1}}}) {
    CompareOptions o = overlay_options();
    o.project.direction = direction;
    const auto g = by_differences(a, b, o, c.centre);
    o.uncertainty.model = UncertaintyModel::registration;
    o.uncertainty.registration_covariance = c;
    const Uncertainty u = compare(a, b, o, {}).uncertainty;
    for (const auto part : {&VolumeTriple::net, &VolumeTriple::above, &VolumeTriple::below})
      EXPECT_NEAR((*u.sigma).*part, deviation(g, part, c), 1e-4 * deviation(g, part, c));
    EXPECT_EQ(*u.sigma_net_registration, u.sigma->net);
  }
}

TEST(Registration, IsTheSameOverCommonCellsWhereTheyAreThoseOfTheOverlay) {
  const Points xy = framed_square(150, 611);
  const Cloud a = rough_cloud(xy, 612), b = rough_cloud(xy, 613);
  CompareOptions o = overlay_options();
  o.uncertainty.model = UncertaintyModel::registration;
  o.uncertainty.registration_covariance = example({0.5, 0.5, 0});
  const Uncertainty overlay = compare(a, b, o, {}).uncertainty;
  o.surface = Surface::common;
  const Uncertainty common = compare(a, b, o, {}).uncertainty;
  for (const auto part : {&VolumeTriple::net, &VolumeTriple::above, &VolumeTriple::below})
    EXPECT_NEAR((*common.sigma).*part, (*overlay.sigma).*part, 1e-10 * (*overlay.sigma).*part);
}

TEST(Registration, OfAShiftAlongTheDirectionIsThatOfAPlainRegistrationError) {
  const Cloud a = rough_cloud(framed_square(200, 621), 622), b = rough_cloud(framed_square(150, 623), 624);
  for (const Direction& direction : {Direction{}, Direction{Direction::Kind::axis_y, {0, 1, 0}}}) {
    const bool along_y = direction.kind == Direction::Kind::axis_y;
    const auto turned = [&](Cloud cloud) {  // what was z becomes y
      for (Point3& p : cloud.points)
        if (along_y) p = {p.y, p.z, p.x};
      return cloud;
    };
    CompareOptions o;
    o.check_layers = false;
    o.project.direction = direction;
    o.uncertainty.model = UncertaintyModel::registration;
    o.uncertainty.sigma1 = o.uncertainty.sigma2 = {SigmaSource::Kind::constant, 0.1, ""};
    o.uncertainty.registration_error = 0.2;
    const Comparison shift = compare(turned(a), turned(b), o, {});
    o.uncertainty.registration_error = 0;
    o.uncertainty.registration_covariance = PoseCovariance{};
    o.uncertainty.registration_covariance->matrix[along_y ? 28 : 35] = 0.04;
    const Comparison pose = compare(turned(a), turned(b), o, {});
    EXPECT_NEAR(pose.uncertainty.sigma->net, shift.uncertainty.sigma->net, 1e-12);
    EXPECT_NEAR(pose.uncertainty.sigma->above, shift.uncertainty.sigma->above, 1e-12);
    EXPECT_NEAR(*pose.uncertainty.lod, *shift.uncertainty.lod, 1e-12);
    EXPECT_NEAR(*pose.uncertainty.rectification_bias, *shift.uncertainty.rectification_bias, 1e-12);
    for (std::size_t i = 0; i < shift.fields_a.lod.size(); ++i)
      if (!std::isnan(shift.fields_a.lod[i])) {
        EXPECT_NEAR(pose.fields_a.lod[i], shift.fields_a.lod[i], 1e-12);
      }
  }
}

TEST(Registration, OfHeightsIsThatOfAPlaneThatIsMoved) {
  const auto plane = [](const Point2& p) { return 0.4 * p.x - 0.7 * p.y + 2; };
  const Cloud a = cloud_over(uniform(50, 631), plane), b = cloud_over(framed_square(100, 632), plane);
  const PoseCovariance c = example({0.2, 0.1, 1});
  CompareOptions o;
  o.check_layers = false;
  o.uncertainty.model = UncertaintyModel::registration;
  o.uncertainty.sigma1 = o.uncertainty.sigma2 = {SigmaSource::Kind::constant, 0, ""};
  o.uncertainty.registration_covariance = c;
  const Comparison found = compare(a, b, o, {});
  const Point3 n{-0.4, 0.7, 1};  // of the plane: a point that moves by m lifts it by n · m
  for (std::size_t i = 0; i < b.points.size(); ++i) {
    const Point3& p = b.points[i];
    double sum = 0;
    std::array<double, 6> g{};
    for (std::size_t k = 0; k < 6; ++k) {
      Cloud one;
      one.points.push_back(p);
      const Point3 q = moved(one, k, 1, c.centre).points[0];
      g[k] = n.x * (q.x - p.x) + n.y * (q.y - p.y) + n.z * (q.z - p.z);
    }
    for (std::size_t j = 0; j < 6; ++j)
      for (std::size_t k = 0; k < 6; ++k) sum += g[j] * c.matrix[6 * j + k] * g[k];
    if (!std::isnan(found.fields_b.lod[i])) {
      EXPECT_NEAR(found.fields_b.lod[i], found.uncertainty.deviations * std::sqrt(sum), 1e-10);
    }
  }
}

TEST(Registration, DoesNotDependOnThreadsOrOrder) {
  const Cloud a = rough_cloud(uniform(5000, 641), 642), b = rough_cloud(uniform(4000, 643), 644);
  for (const Surface surface : {Surface::common, Surface::overlay}) {
    CompareOptions o;
    o.surface = surface;
    o.uncertainty.model = UncertaintyModel::registration;
    o.uncertainty.sigma1 = o.uncertainty.sigma2 = {SigmaSource::Kind::constant, 0.1, ""};
    o.uncertainty.registration_covariance = example({0.5, 0.5, 0});
    Context one, seven;
    one.threads = 1, seven.threads = 7;
    const Uncertainty u = compare(a, b, o, one).uncertainty;
    for (const Uncertainty& v :
         {compare(a, b, o, seven).uncertainty, compare(shuffled(a, 1), shuffled(b, 2), o, {}).uncertainty}) {
      EXPECT_EQ(u.sigma->net, v.sigma->net);
      EXPECT_EQ(u.sigma->above, v.sigma->above);
      EXPECT_EQ(*u.lod, *v.lod);
    }
  }
}

TEST(Registration, CovariancesThatAreNoneAreRefused) {
  const auto fault = [](const std::function<void(PoseCovariance&)>& spoil) {
    PoseCovariance c = example({0, 0, 0});
    spoil(c);
    return fault_of(c);
  };
  EXPECT_EQ(fault([](auto&) {}), "");
  EXPECT_EQ(fault([](auto& c) { c = {}; }), "");
  EXPECT_NE(fault([](auto& c) { c.matrix[3] = std::nan(""); }), "");
  EXPECT_NE(fault([](auto& c) { c.centre.x = HUGE_VAL; }), "");
  EXPECT_NE(fault([](auto& c) { c.matrix[7] = -1e-9; }), "");
  EXPECT_NE(fault([](auto& c) { c.matrix[1] = 1e-5; }), "");
  EXPECT_NE(fault([](auto& c) { c.matrix[1] = c.matrix[6] = 1e-3; }), "");  // more than the deviations allow
  EXPECT_NE(fault([](auto& c) { c.matrix[7] = 0, c.matrix[8] = c.matrix[13] = 1e-9; }), "");
  CompareOptions o;
  o.uncertainty.model = UncertaintyModel::registration;
  o.uncertainty.registration_covariance = example({0, 0, 0});
  o.uncertainty.registration_covariance->matrix[0] = -1;
  EXPECT_THROW((void)compare(inside(), around(), o, {}), InputError);
  o.uncertainty.registration_covariance = example({0, 0, 0});
  o.uncertainty.registration_error = 1;
  EXPECT_THROW((void)compare(inside(), around(), o, {}), UsageError);
}

}  // namespace
}  // namespace isopach::test
