// Uncertainty of the volumes: against one input height moved at a time, against the double sum over all pairs of
// nodes, and against what 2000 simulated pairs of known noise show.
#include "isopach/compare/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "isopach/base/error.hpp"
#include "isopach/compare/compare.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/noisy_pairs.hpp"

namespace isopach::test {
namespace {

using Model = UncertaintyModel;
using Shape = CorrelationShape;

CompareOptions options_of(Model model, double sigma1, double sigma2) {
  CompareOptions o;
  o.check_layers = false;
  o.uncertainty.model = model;
  o.uncertainty.sigma1 = {SigmaSource::Kind::constant, sigma1, ""};
  o.uncertainty.sigma2 = {SigmaSource::Kind::constant, sigma2, ""};
  return o;
}

Cloud with_sigma(Cloud cloud, std::uint64_t seed) {
  Random random(seed);
  cloud.attributes.push_back({"noise", Array<double>(cloud.points.size())});
  for (double& s : cloud.attributes[0].values) s = random.uniform(0.01, 0.1);
  return cloud;
}

struct Derivatives {
  std::vector<VolumeTriple> a, b;
};
// By moving every input height on its own.
Derivatives derivatives(const Cloud& a, const Cloud& b, CompareOptions o) {
  o.uncertainty = {};
  const auto of = [&](const Cloud& moved, bool first) {
    std::vector<VolumeTriple> result;
    for (std::size_t i = 0; i < moved.points.size(); ++i) {
      constexpr double step = 1e-6;
      std::array<Volume, 2> v;
      for (int side = 0; side < 2; ++side) {
        Cloud other = moved;
        other.points[i].z += side == 0 ? step : -step;
        v[static_cast<std::size_t>(side)] =
            (first ? compare(other, b, o, {}) : compare(a, other, o, {})).measures.volume;
      }
      result.push_back({(v[0].net - v[1].net) / (2 * step), (v[0].above - v[1].above) / (2 * step),
                        (v[0].below - v[1].below) / (2 * step)});
    }
    return result;
  };
  return {of(a, true), of(b, false)};
}

double double_sum(const std::vector<VolumeTriple>& w, double VolumeTriple::*part, const Cloud& cloud,
                  const std::function<double(std::size_t, std::size_t)>& covariance) {
  double sum = 0;
  for (std::size_t p = 0; p < cloud.points.size(); ++p)
    for (std::size_t q = 0; q < cloud.points.size(); ++q) sum += w[p].*part * w[q].*part * covariance(p, q);
  return sum;
}

TEST(IndependentNoise, IsThatOfHeightsMovedOneByOne) {
  const Cloud a = with_sigma(rough_cloud(uniform(60, 421), 422), 423),
              b = with_sigma(rough_cloud(uniform(80, 424), 425), 426);
  for (const Surface surface : {Surface::common, Surface::overlay})
    for (const DomainKind domain : {DomainKind::overlap, DomainKind::hull}) {
      if (surface == Surface::overlay && domain == DomainKind::hull) continue;
      CompareOptions o;
      o.surface = surface;
      o.domain = domain;
      o.check_layers = false;
      const Derivatives w = derivatives(a, b, o);
      o.uncertainty.model = Model::independent;
      o.uncertainty.sigma1 = o.uncertainty.sigma2 = {SigmaSource::Kind::attribute, 0, "noise"};
      const Uncertainty u = compare(a, b, o, {}).uncertainty;
      ASSERT_TRUE(u.sigma);
      for (const auto part : {&VolumeTriple::net, &VolumeTriple::above, &VolumeTriple::below}) {
        double variance = 0;
        for (const auto& [cloud, weights] : {std::pair{&a, &w.a}, std::pair{&b, &w.b}}) {
          const auto& sigma = cloud->attributes[0].values;
          variance += double_sum(*weights, part, *cloud,
                                 [&](std::size_t p, std::size_t q) { return p == q ? sigma[p] * sigma[p] : 0; });
        }
        EXPECT_NEAR((*u.sigma).*part, std::sqrt(variance), 1e-5 * std::sqrt(variance));
      }
    }
}

TEST(CorrelatedNoise, IsTheDoubleSumOverAllPairs) {
  const Cloud a = with_sigma(rough_cloud(uniform(90, 431), 432), 433),
              b = with_sigma(rough_cloud(uniform(120, 434), 435), 436);
  CompareOptions o;
  o.check_layers = false;
  const Derivatives w = derivatives(a, b, o);
  o.uncertainty.model = Model::correlated;
  o.uncertainty.sigma1 = o.uncertainty.sigma2 = {SigmaSource::Kind::attribute, 0, "noise"};
  for (const Shape shape : {Shape::spherical, Shape::exponential, Shape::gaussian})
    for (const double range : {1e-3, 0.05, 0.2, 0.5, 2.0, 50.0}) {
      o.uncertainty.correlation = shape;
      o.uncertainty.correlation_range = range;
      const Uncertainty u = compare(a, b, o, {}).uncertainty;
      for (const auto part : {&VolumeTriple::net, &VolumeTriple::above, &VolumeTriple::below}) {
        double variance = 0;
        for (const auto& [cloud, weights] : {std::pair{&a, &w.a}, std::pair{&b, &w.b}}) {
          const auto& sigma = cloud->attributes[0].values;
          const auto& points = cloud->points;
          variance += double_sum(*weights, part, *cloud, [&](std::size_t p, std::size_t q) {
            const Point3 &s = points[p], &t = points[q];
            return sigma[p] * sigma[q] * correlation(shape, range, std::hypot(s.x - t.x, s.y - t.y));
          });
        }
        EXPECT_NEAR((*u.sigma).*part, std::sqrt(variance), 0.01 * std::sqrt(variance)) << range;
      }
    }
}

// The cases are listed in docs/use/uncertainty.md.
class IntervalOfNet : public testing::Test {
 protected:
  // Nodes of A and B, the seed of their places.
  void expect_covered(const CompareOptions& o, std::size_t n_a, std::size_t n_b, std::uint64_t seed) {
    const double share = truthful({uniform(n_a, seed), uniform(n_b, seed + 1), o}, 2000, seed + 2).net;
    EXPECT_GE(share, 0.93) << n_a << " " << n_b;
    EXPECT_LE(share, 0.97) << n_a << " " << n_b;
  }
};

TEST_F(IntervalOfNet, HoldsTheTruthUnderIndependentNoiseSlow) {
  CompareOptions o = options_of(Model::independent, 0.05, 0.02);
  expect_covered(o, 120, 30, 444);
  o.surface = Surface::overlay;
  expect_covered(o, 25, 40, 450);
}

TEST_F(IntervalOfNet, HoldsTheTruthUnderCorrelatedNoiseSlow) {
  CompareOptions o = options_of(Model::correlated, 0.05, 0.02);
  o.uncertainty.correlation_range = 0.4;
  expect_covered(o, 25, 40, 453);
  o.uncertainty.correlation = Shape::exponential;
  o.surface = Surface::overlay;
  expect_covered(o, 60, 20, 456);
}

TEST_F(IntervalOfNet, HoldsTheTruthUnderARegistrationErrorSlow) {
  CompareOptions o = options_of(Model::registration, 0.05, 0.02);
  o.uncertainty.registration_error = 0.01;
  expect_covered(o, 25, 40, 462);
}

TEST_F(IntervalOfNet, HoldsTheTruthUnderAnUncertainPoseSlow) {
  CompareOptions o = options_of(Model::registration, 0.05, 0.02);
  PoseCovariance c;
  for (std::size_t i = 0; i < 6; ++i) c.matrix[7 * i] = i < 3 ? 1e-4 : 4e-4;
  c.matrix[5] = c.matrix[30] = 1.5e-4;
  c.centre = {0.5, 0.5, 0};
  o.uncertainty.registration_covariance = c;
  Points around = uniform(60, 465);
  for (Point2& p : around) p = {1.6 * p.x - 0.3, 1.6 * p.y - 0.3};
  const double share = truthful({uniform(25, 466), around, o}, 2000, 467).net;
  EXPECT_GE(share, 0.93);
  EXPECT_LE(share, 0.97);
}

TEST(Sigma, OfMergedPointsIsThatOfTheirMean) {
  Cloud cloud = cloud_over({{0, 0}, {1, 0}, {0, 1}, {1, 1}, {1, 1}, {1, 1}}, [](const Point2& p) { return p.x; });
  cloud.attributes.push_back({"noise", {1, 2, 3, 2, 3, 6}});
  for (const DuplicatePolicy policy : {DuplicatePolicy::mean, DuplicatePolicy::median}) {
    ProjectOptions project_options;
    project_options.duplicates = policy;
    const Frame frame = choose_frame(cloud, cloud, Pose{}, project_options, {});
    const HeightField field = project(cloud, Pose{}, frame, project_options, {});
    const Array<double> sigma =
        stages::sigma_of_nodes(cloud, Pose{}, field, {SigmaSource::Kind::attribute, 0, "noise"}, policy, "@sigma1", {});
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(sigma[field.node_of_point[i]], cloud.attributes[0].values[i]);
    EXPECT_DOUBLE_EQ(sigma[field.node_of_point[3]], policy == DuplicatePolicy::mean ? 7. / 3 : 6);
  }
}

TEST(Sigma, MayBeARasterInMemoryAndIsRefusedWhereItWasNotRead) {
  const Cloud a = rough_cloud(framed_square(200, 451), 452), b = rough_cloud(framed_square(300, 453), 454);
  Cloud cells;
  cells.grid = RasterGrid{1, 1, {-1, 3, 0, -1, 0, 3}};
  cells.points.push_back({0, 0, 0.03});
  CompareOptions o = options_of(Model::none, 0.03, 0.04);
  const double constant = *compare(a, b, o, {}).uncertainty.lod;
  o.uncertainty.sigma1 = {SigmaSource::Kind::raster, 0, "everywhere", RasterValues(cells)};
  EXPECT_NEAR(*compare(a, b, o, {}).uncertainty.lod, constant, 1e-15);
  o.uncertainty.sigma1.raster.reset();
  EXPECT_THROW((void)compare(a, b, o, {}), UsageError);
}

TEST(LevelOfDetection, IsFromTheSigmasOrGiven) {
  const Cloud a = rough_cloud(framed_square(200, 451), 452), b = rough_cloud(framed_square(300, 453), 454);
  CompareOptions o = options_of(Model::none, 0.03, 0.04);
  Comparison c = compare(a, b, o, {});
  EXPECT_NEAR(*c.uncertainty.lod, 1.959963984540054 * 0.05, 1e-15);
  EXPECT_FALSE(c.uncertainty.lod_is_given);
  EXPECT_FALSE(c.uncertainty.sigma);
  for (const double lod : c.fields_a.lod) EXPECT_NEAR(lod, *c.uncertainty.lod, 1e-15);
  const Detected found = *c.uncertainty.detected;
  EXPECT_LT(found.above, c.measures.volume.above);
  EXPECT_GT(found.above, 0.8 * c.measures.volume.above);
  o.uncertainty.lod = *c.uncertainty.lod;
  c = compare(a, b, o, {});
  EXPECT_TRUE(c.uncertainty.lod_is_given);
  EXPECT_NEAR(c.uncertainty.detected->above, found.above, 1e-13);
  o.surface = Surface::overlay;
  const Comparison overlay = compare(a, b, o, {});
  EXPECT_LT(overlay.uncertainty.detected->above, overlay.measures.volume.above);
  EXPECT_NE(overlay.uncertainty.detected->above, found.above);
}

TEST(RectificationBias, BoundsWhatNoiseAddsToEqualSurfaces) {
  const double sigma = 0.05;
  const Points xy = framed_square(400, 461);
  Random random(462);
  const auto noisy = [&] { return cloud_over(xy, [&](const Point2&) { return sigma * random.bell(); }); };
  double above = 0, bound = 0, area = 0;
  for (int i = 0; i < 200; ++i) {  // one node set: d is not interpolated, the bound is met at every node
    const Comparison c = compare(noisy(), noisy(), options_of(Model::independent, sigma, sigma), {});
    above += c.measures.volume.above / 200;
    bound = *c.uncertainty.rectification_bias;
    area = c.domain_area;
  }
  EXPECT_NEAR(bound, sigma * std::sqrt(2.0) / std::sqrt(2 * std::numbers::pi) * area, 1e-12);
  EXPECT_LT(above, bound);
  EXPECT_GT(above, 0.6 * bound);  // inside the cells linear interpolation averages the noise of three nodes
}

TEST(Uncertainty, DoesNotDependOnThreadsOrOrder) {
  const Cloud a = rough_cloud(uniform(5000, 471), 472), b = rough_cloud(uniform(4000, 473), 474);
  CompareOptions o = options_of(Model::correlated, 0.05, 0.02);
  o.uncertainty.correlation_range = 0.1;
  for (const Surface surface : {Surface::common, Surface::overlay}) {
    o.surface = surface;
    Context one, seven;
    one.threads = 1, seven.threads = 7;
    const Uncertainty u = compare(a, b, o, one).uncertainty;
    for (const Uncertainty& v :
         {compare(a, b, o, seven).uncertainty, compare(shuffled(a, 1), shuffled(b, 2), o, {}).uncertainty}) {
      EXPECT_EQ(u.sigma->net, v.sigma->net);
      EXPECT_EQ(u.sigma->above, v.sigma->above);
      EXPECT_EQ(u.detected->area, v.detected->area);
      EXPECT_EQ(*u.rectification_bias, *v.rectification_bias);
    }
    const Uncertainty swapped = [&] {
      CompareOptions back = o;
      std::swap(back.uncertainty.sigma1, back.uncertainty.sigma2);
      return compare(b, a, back, {}).uncertainty;
    }();
    EXPECT_NEAR(u.sigma->net, swapped.sigma->net, 1e-14);
    EXPECT_NEAR(u.sigma->above, swapped.sigma->below, 1e-14);
  }
}

TEST(UncertaintyOptions, ThatMeanNothingAreRefusedByName) {
  const Cloud a = rough_cloud(uniform(30, 481), 482), b = rough_cloud(uniform(30, 483), 484);
  const auto refused = [&](const std::function<void(UncertaintyOptions&)>& spoil, const std::string& option) {
    CompareOptions o = options_of(Model::none, 0.1, 0.1);
    spoil(o.uncertainty);
    try {
      (void)compare(a, b, o, {});
      ADD_FAILURE() << option;
    } catch (const UsageError& e) {
      EXPECT_EQ(std::string(e.what()).rfind(option, 0), 0u) << e.what();
    }
  };
  refused([](auto& o) { o.sigma2 = {}; }, "@sigma1");
  refused([](auto& o) { o.sigma1 = {}; }, "@sigma2");
  refused([](auto& o) { o.sigma1.value = -1; }, "@sigma1");
  refused([](auto& o) { o.lod = -1; }, "@lod");
  refused([](auto& o) { o.confidence = 1; }, "@confidence");
  refused([](auto& o) { o.confidence = 0; }, "@confidence");
  refused([](auto& o) { o.sigma1 = o.sigma2 = {}, o.model = Model::independent; }, "@uncertainty-model");
  refused([](auto& o) { o.model = Model::correlated; }, "@uncertainty-model correlated");
  refused([](auto& o) { o.model = Model::registration; }, "@uncertainty-model registration");
  refused([](auto& o) { o.correlation_range = 1; }, "@correlation-range");
  refused([](auto& o) { o.model = Model::independent, o.registration_error = 1; }, "@registration-error");
}

}  // namespace
}  // namespace isopach::test
