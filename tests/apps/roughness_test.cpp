// The roughness of surfaces whose parameters, form and wrinkles are known.
#include "isopach/apps/roughness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "isopach/base/error.hpp"
#include "isopach/simulate/scene.hpp"
#include "tests/support/clouds.hpp"

namespace isopach {
namespace {

constexpr double turn = 2 * std::numbers::pi;

Cloud scene(const std::string& variant, std::size_t points, double noise, bool after = false) {
  SceneOptions options = scene_defaults("skin");
  options.points_a = options.points_b = points;
  options.noise_a = options.noise_b = noise;
  options.variant = variant;
  Scene made = make_scene("skin", options, Context{});
  return after ? std::move(made.b) : std::move(made.a);
}

RoughnessOptions plain_options() {
  RoughnessOptions o;
  o.compare.check_layers = false;
  return o;
}

/// Over the unit square, to be stretched to 10 by 8.
template <class F>
Cloud patch(std::size_t n, std::uint64_t seed, F&& height) {
  return test::cloud_over(test::framed_square(n, seed), [&](const Point2& p) { return height(10 * p.x, 8 * p.y); });
}
Cloud stretched(Cloud cloud) {
  for (Point3& p : cloud.points) p.x *= 10, p.y *= 8;
  return cloud;
}

void expect_near(double value, double truth, double share, const char* name) {
  EXPECT_NEAR(value, truth, share * std::fabs(truth)) << name;
}

TEST(Roughness, SineWaveAt20PointsAWavelength) {
  const Cloud cloud = scene("waves", 120000, 0);  // 20 wavelengths of 2 mm, 100 points a mm²
  const Roughness r = roughness(cloud, std::nullopt, std::nullopt, plain_options(), {});
  const ArealParameters& p = r.scan.parameters;
  const double amplitude = 0.05, slope = turn * amplitude / 2, k2 = slope * slope;
  expect_near(p.sa, 2 * amplitude / std::numbers::pi, 0.005, "Sa");
  expect_near(p.sq, amplitude / std::sqrt(2.0), 0.005, "Sq");
  expect_near(p.sz, 2 * amplitude, 0.005, "Sz");
  expect_near(p.sku, 1.5, 0.005, "Sku");
  EXPECT_NEAR(p.ssk, 0, 0.005);
  expect_near(p.sdr, std::sqrt(1 + k2) * std::comp_ellint_2(std::sqrt(k2 / (1 + k2))) * 2 / std::numbers::pi - 1, 0.005,
              "Sdr");
  EXPECT_NEAR(p.area, 1200, 1);
  EXPECT_EQ(r.unit, "mm");
}

TEST(Roughness, FormIsRemovedWithoutTouchingTheRest) {
  const auto relief = [](double x, double y) { return 0.03 * std::sin(6 * x + y) + 0.01 * std::cos(9 * y); };
  const auto form = [](double x, double y) {
    return 4 - 0.7 * x + 0.2 * y + 0.05 * x * x - 0.03 * x * y + 0.01 * y * y;
  };
  RoughnessOptions o = plain_options();
  o.form = FormKind::polynomial;
  o.margin = 0;
  for (const double l : {0.0, 2.0}) {  // with waviness removed as well
    o.l_filter = l;
    const Roughness without = roughness(stretched(patch(5000, 1, relief)), std::nullopt, std::nullopt, o, {});
    const Roughness with =
        roughness(stretched(patch(5000, 1, [&](double x, double y) { return form(x, y) + relief(x, y); })),
                  std::nullopt, std::nullopt, o, {});
    const auto& a = without.scan.fields[1].values;
    const auto& b = with.scan.fields[1].values;
    ASSERT_EQ(without.scan.fields[1].name, "roughness");
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-9);
    EXPECT_NEAR(without.scan.parameters.sq, with.scan.parameters.sq, 1e-9);
    EXPECT_GT(with.scan.form_sq, 1);
  }
}

TEST(Roughness, FormsDiffer) {
  const Cloud bowl = stretched(patch(3000, 2, [](double x, double y) { return 0.3 * x + 0.1 * x * x + 0.05 * y * y; }));
  RoughnessOptions o = plain_options();
  o.form = FormKind::none;
  const double none = roughness(bowl, std::nullopt, std::nullopt, o, {}).scan.parameters.sq;
  o.form = FormKind::plane;
  const double plane = roughness(bowl, std::nullopt, std::nullopt, o, {}).scan.parameters.sq;
  o.form = FormKind::polynomial;
  const double polynomial = roughness(bowl, std::nullopt, std::nullopt, o, {}).scan.parameters.sq;
  EXPECT_GT(none, 2 * plane);
  EXPECT_GT(plane, 0.1);
  EXPECT_LT(polynomial, 1e-9);
}

TEST(Roughness, ReferenceIsTheForm) {
  const auto form = [](double x, double y) { return 0.2 * x + 0.3 * y; };
  const Cloud scan = stretched(patch(4000, 3, [&](double x, double y) { return form(x, y) + 0.02 * std::sin(5 * x); }));
  Cloud reference = stretched(patch(900, 4, form));
  RoughnessOptions o = plain_options();
  o.form = FormKind::reference;
  const Roughness whole = roughness(scan, std::nullopt, reference, o, {});
  expect_near(whole.scan.parameters.sq, 0.02 / std::sqrt(2.0), 0.03, "Sq");
  EXPECT_NEAR(whole.scan.parameters.area, 80, 0.5);
  std::erase_if(reference.points, [](const Point3& p) { return p.x > 6; });  // it covers a part
  const Roughness part = roughness(scan, std::nullopt, reference, o, {});
  EXPECT_NEAR(part.scan.parameters.area, 6 * 8, 2);
  for (Point3& p : reference.points) p.x += 1000;
  EXPECT_THROW((void)roughness(scan, std::nullopt, reference, o, {}), OverlapError);
}

TEST(Roughness, MatchPutsTheReferenceInPlace) {
  const auto form = [](double x, double y) {
    return std::sin(0.9 * x) + 0.8 * std::cos(0.7 * y + 0.3 * x) + 0.2 * std::sin(0.5 * x * y / 3);
  };
  const Cloud scan = stretched(patch(4000, 5, [&](double x, double y) { return form(x, y) + 0.01 * std::sin(9 * x); }));
  const Cloud reference = test::shifted(stretched(patch(4000, 6, form)), {0.15, -0.1, 0.3});
  RoughnessOptions o = plain_options();
  o.form = FormKind::reference;
  const double astray = roughness(scan, std::nullopt, reference, o, {}).scan.parameters.sq;
  o.match = true;
  const Roughness matched = roughness(scan, std::nullopt, reference, o, {});
  EXPECT_GT(astray, 0.05);
  expect_near(matched.scan.parameters.sq, 0.01 / std::sqrt(2.0), 0.1, "Sq");
  EXPECT_NEAR(matched.reference_pose.m[3], -0.15, 0.01);
  EXPECT_NEAR(matched.reference_pose.m[11], -0.3, 0.01);
}

TEST(Roughness, FiltersSeparateWaves) {
  const Cloud cloud = stretched(patch(
      20000, 7, [](double x, double y) { return 0.1 * std::cos(turn * x / 5) + 0.01 * std::sin(turn * y / 0.8); }));
  RoughnessOptions o = plain_options();
  const double all = roughness(cloud, std::nullopt, std::nullopt, o, {}).scan.parameters.sq;
  o.l_filter = 2;
  const Roughness rough = roughness(cloud, std::nullopt, std::nullopt, o, {});
  o.s_filter = 1.9;
  o.l_filter = 0;
  o.margin = 1;
  const Roughness wavy = roughness(cloud, std::nullopt, std::nullopt, o, {});
  EXPECT_GT(all, 0.07);
  // exp(−ln 2 (2/5)²) = 0.895 of the long wave is waviness: 10 % of it stay beside the short one
  expect_near(rough.scan.parameters.sq, std::hypot(0.105 * 0.1, 0.01) / std::sqrt(2.0), 0.06, "roughness");
  expect_near(rough.scan.waviness_sq, 0.895 * 0.1 / std::sqrt(2.0), 0.08, "waviness");
  EXPECT_EQ(rough.scan.margin, 1);
  EXPECT_LT(rough.scan.parameters.area, 8.2 * 6.2);
  // between x = 1 and 9 the variance of the long wave is 0.435 of its amplitude squared, not a half
  expect_near(wavy.scan.parameters.sq, std::exp(-std::numbers::ln2 * 1.9 * 1.9 / 25) * 0.1 * std::sqrt(0.435), 0.03,
              "S");
}

/// 40 mm by 30 mm of skin: the wrinkles of the scene, before and after.
TEST(Roughness, WrinklesOfTheSkinSceneLarge) {
  const Cloud before = scene("wrinkled", 60000, 0.002), after = scene("wrinkled", 60000, 0.002, true);
  RoughnessOptions o = plain_options();
  o.form = FormKind::polynomial;
  o.s_filter = 0.4;
  o.l_filter = 8;
  o.margin = 1;
  o.wrinkles = {0.05, 3};
  const Roughness r = roughness(before, after, std::nullopt, o, {});
  ASSERT_EQ(r.scan.wrinkles.all.size(), 3u);
  const double depth[] = {0.30, 0.20, 0.12}, half[] = {9, 8, 7}, left[] = {0.5, 0.6, 1};
  for (std::size_t k = 0; k < 3; ++k) {
    const Wrinkle& w = r.scan.wrinkles.all[k];
    EXPECT_NEAR(w.depth, depth[k], 0.1 * depth[k]) << k;
    const double length = 2 * half[k] * std::sqrt(1 - std::cbrt(0.05 / depth[k]));
    EXPECT_NEAR(w.length, length, 0.1 * length) << k;
    EXPECT_NEAR(r.wrinkles_after[k].mean_depth / w.mean_depth, left[k], 0.06) << k;
  }
  EXPECT_LT(r.after->parameters.sv, r.scan.parameters.sv);
  const auto& number = r.scan.fields[3];
  EXPECT_EQ(number.name, "wrinkle");
  EXPECT_GT(std::count(number.values.begin(), number.values.end(), 1.0), 100);
}

TEST(Roughness, PoseMovesTheSecondScan) {
  const auto relief = [](double x, double y) { return 0.02 * std::sin(5 * x) + (std::fabs(y - 4) < 0.3 ? -0.2 : 0); };
  const Cloud before = stretched(patch(8000, 8, relief));
  const Cloud after = test::shifted(stretched(patch(8000, 9, relief)), {0, 3, 0.5});
  RoughnessOptions o = plain_options();
  o.wrinkles = {0.1, 4};
  const Roughness astray = roughness(before, after, std::nullopt, o, {});
  o.compare.pose.m[7] = -3, o.compare.pose.m[11] = -0.5;
  const Roughness placed = roughness(before, after, std::nullopt, o, {});
  ASSERT_EQ(placed.scan.wrinkles.all.size(), 1u);
  EXPECT_NEAR(placed.wrinkles_after[0].mean_depth, placed.scan.wrinkles.all[0].mean_depth, 0.01);
  EXPECT_LT(astray.wrinkles_after[0].mean_depth, 0.05);
}

TEST(Roughness, SameBitsForAnyNumberOfThreadsAndOrderOfPoints) {
  const Cloud cloud = scene("wrinkled", 6000, 0.002);
  RoughnessOptions o = plain_options();
  o.l_filter = 8;
  const auto numbers = [&](const Cloud& c, int threads) {
    Context context;
    context.threads = threads;
    const Roughness r = roughness(c, std::nullopt, std::nullopt, o, context);
    std::vector<double> out{r.scan.parameters.sa, r.scan.parameters.sku, r.scan.parameters.sdr, r.scan.waviness_sq};
    for (const Wrinkle& w : r.scan.wrinkles.all) out.insert(out.end(), {w.depth, w.length, w.volume});
    return out;
  };
  const std::vector<double> first = numbers(cloud, 1);
  EXPECT_GT(first.size(), 4u);
  EXPECT_EQ(numbers(cloud, 3), first);
  EXPECT_EQ(numbers(test::shuffled(cloud, 5), 2), first);
}

TEST(Roughness, LineAndSparePointsAndOutliers) {
  Cloud line = test::cloud_over(test::framed_square(100, 1), [](const Point2&) { return 0.0; });
  for (Point3& p : line.points) p.y = p.x;
  EXPECT_THROW((void)roughness(line, std::nullopt, std::nullopt, plain_options(), {}), InputError);
  Cloud outlier = stretched(patch(3000, 10, [](double x, double) { return 0.01 * std::sin(5 * x); }));
  const double clean = roughness(outlier, std::nullopt, std::nullopt, plain_options(), {}).scan.parameters.sq;
  outlier.points.push_back({90, 70, 40});
  const Roughness r = roughness(outlier, std::nullopt, std::nullopt, plain_options(), {});
  EXPECT_NEAR(r.scan.parameters.sq, clean, 1e-3 * clean);
  EXPECT_TRUE(std::isnan(r.scan.fields[1].values.back()));
}

TEST(Roughness, RefusesWhatMakesNoSense) {
  const Cloud cloud = stretched(patch(500, 11, [](double x, double) { return x; }));
  const auto refused = [&](const char* option, auto&& change, bool with_after = false, bool with_reference = false) {
    RoughnessOptions o = plain_options();
    change(o);
    try {
      const std::optional<CloudView> given(cloud), none;
      (void)roughness(cloud, with_after ? given : none, with_reference ? given : none, o, {});
      ADD_FAILURE() << option;
    } catch (const UsageError& e) {
      EXPECT_EQ(std::string(e.what()).rfind(option, 0), 0u) << e.what();
    }
  };
  refused("@s-filter", [](RoughnessOptions& o) { o.s_filter = -1; });
  refused("@s-filter", [](RoughnessOptions& o) { o.s_filter = 3, o.l_filter = 2; });
  refused("@s-filter", [](RoughnessOptions& o) { o.s_filter = 0.01; });
  refused("@l-filter", [](RoughnessOptions& o) { o.l_filter = 0.1; });
  refused("@l-filter", [](RoughnessOptions& o) { o.l_filter = std::nan(""); });
  refused("@l-filter", [](RoughnessOptions& o) { o.l_filter = 1e304; });
  refused("@margin", [](RoughnessOptions& o) { o.margin = 30; });
  refused("@degree", [](RoughnessOptions& o) { o.form = FormKind::polynomial, o.degree = 9; });
  refused("@filter-degree", [](RoughnessOptions& o) { o.filter_degree = 2; });
  refused("@filter", [](RoughnessOptions& o) { o.filter = MeanFilter::robust; });
  refused("@form", [](RoughnessOptions& o) { o.form = FormKind::reference; });
  refused(
      "@reference", [](RoughnessOptions&) {}, false, true);
  refused("@match", [](RoughnessOptions& o) { o.match = true; });
  refused("@pose", [](RoughnessOptions& o) { o.compare.pose.m[3] = 1; });
  refused("@wrinkle-depth", [](RoughnessOptions& o) { o.wrinkles.depth = -1; });
  refused("@wrinkle-length", [](RoughnessOptions& o) { o.wrinkles.length = -1; });
  Cloud feet = cloud;
  feet.unit = "m", feet.vertical_unit = "ft";
  EXPECT_THROW((void)roughness(feet, std::nullopt, std::nullopt, plain_options(), {}), InputError);
}

}  // namespace
}  // namespace isopach
