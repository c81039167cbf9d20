#include "isopach/simulate/scene.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "isopach/base/error.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/simulate/bump.hpp"

namespace isopach {
namespace {

using Surface = std::function<double(double, double)>;

struct Volumes {
  double area = 0, above = 0, below = 0;
};

/// Where a line y = const meets a convex polygon.
std::pair<double, double> chord(const Outline& polygon, double y) {
  double left = 1e300, right = -1e300;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point2 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
    if ((p.y <= y) == (q.y <= y)) continue;
    const double x = p.x + (q.x - p.x) * (y - p.y) / (q.y - p.y);
    left = std::min(left, x);
    right = std::max(right, x);
  }
  return {left, right};
}

/// Gauss's rule with two nodes on each of `n` pieces per axis: row by row over the chords of the footprint, rows split
/// at the corners. Independent of every closed form.
Volumes quadrature(const Surface& f1, const Surface& f2, const Outline& footprint, int n) {
  const double gauss[] = {0.5 - std::sqrt(1.0 / 12), 0.5 + std::sqrt(1.0 / 12)};
  std::vector<double> breaks;
  for (const Point2& p : footprint) breaks.push_back(p.y);
  std::sort(breaks.begin(), breaks.end());
  Sum area, above, below;
  const auto add_row = [&](double y, double dy) {
    const auto [left, right] = chord(footprint, y);
    const double dx = (right - left) / n;
    area.add((right - left) * dy);
    for (int c = 0; c < 2 * n; ++c) {
      const double x = left + (c / 2 + gauss[c % 2]) * dx;
      const double d = (f2(x, y) - f1(x, y)) * dx / 2 * dy;
      if (d > 0) above.add(d);
      if (d < 0) below.add(-d);
    }
  };
  for (std::size_t k = 1; k < breaks.size(); ++k) {
    const double height = breaks[k] - breaks[k - 1];
    const int rows = static_cast<int>(std::ceil(n * height / (breaks.back() - breaks.front())));
    for (int r = 0; r < 2 * rows; ++r)
      add_row(breaks[k - 1] + (r / 2 + gauss[r % 2]) * height / rows, height / rows / 2);
  }
  return {area.value(), above.value(), below.value()};
}

std::vector<std::string> variants(const std::string& name) {
  const std::vector<std::string> known = scene_variants(name);
  return known.empty() ? std::vector<std::string>{""} : known;
}

SceneOptions options(std::size_t a, std::size_t b, double noise = 0, const std::string& variant = "") {
  SceneOptions o;
  o.points_a = a;
  o.points_b = b;
  o.noise_a = o.noise_b = noise;
  o.variant = variant;
  return o;
}

void expect_relative(double value, double truth, double tolerance, const std::string& what) {
  EXPECT_NEAR(value, truth, tolerance * std::max(std::fabs(truth), 1.0)) << what;
}

TEST(Scene, NamesVariantsAndDefaults) {
  EXPECT_EQ(scene_names(), (std::vector<std::string>{"terrain", "face", "plane", "paraboloid", "cone", "relief", "skin",
                                                     "worst-case"}));
  EXPECT_EQ(scene_variants("plane"), (std::vector<std::string>{"lifted", "tilted"}));
  for (const std::string& name : scene_names()) {
    const Scene scene = make_scene(name, scene_defaults(name), Context{});
    EXPECT_EQ(scene.name, name);
    EXPECT_FALSE(scene.description.empty());
    const std::string unit = name == "face" || name == "skin" ? "mm" : "m";
    EXPECT_EQ(scene.truth.unit, unit);
    for (const Cloud* cloud : {&scene.a, &scene.b}) {
      EXPECT_EQ(cloud->unit, unit);
      EXPECT_EQ(cloud->vertical_unit, unit);
      EXPECT_EQ(cloud->format, "simulated");
      EXPECT_TRUE(cloud->path.empty() && cloud->attributes.empty() && cloud->faces.empty() && cloud->notes.empty());
    }
  }
}

TEST(Scene, TruthIsTheIntegralOfItsSurfaces) {
  for (const std::string& name : scene_names())
    for (const std::string& variant : variants(name)) {
      if (variant == "cliff") continue;  // its corners are a centimetre wide: below
      const Scene scene = make_scene(name, options(200, 300, 0, variant), Context{});
      const int pieces = name == "relief" ? 200
                         : name == "skin" ? 1600
                                          : 600;  // relief: 40 sines a height, d 60 m wide; skin: grooves
      const Volumes v =
          quadrature(scene_surface(name, variant, 1), scene_surface(name, variant, 2), scene.footprint, pieces);
      const std::string what = name + " " + variant;
      expect_relative(v.area, scene.truth.area, 1e-6, what);
      expect_relative(v.above, scene.truth.above, 1e-6, what);
      expect_relative(v.below, scene.truth.below, 1e-6, what);
      expect_relative(v.above - v.below, scene.truth.net, 1e-6, what);
      EXPECT_LE(scene.truth.error, variant == "rough" ? 1e-6 : 0) << what;
      EXPECT_EQ(scene.truth.above > 0, variant != "unchanged") << what;
    }
}

TEST(Scene, ReliefHasTheVolumesFoundByQuadratureElsewhere) {
  const Truth smooth = make_scene("relief", options(4, 4), Context{}).truth;
  EXPECT_EQ(smooth.above, 562500);
  EXPECT_EQ(smooth.below, 62500);
  const Truth rough = make_scene("relief", options(4, 4, 0, "rough"), Context{}).truth;
  EXPECT_NEAR(rough.above, 60318.578021, 1e-6);  // another program's Gauss rule, two orders agreeing
  EXPECT_NEAR(rough.below, 22619.466177, 1e-6);
  EXPECT_DOUBLE_EQ(rough.parts.at("mound") + rough.parts.at("pit"), rough.net);
  const Surface f1 = scene_surface("relief", "unchanged", 1), f2 = scene_surface("relief", "unchanged", 2);
  for (double x = 0; x <= 1000; x += 37) EXPECT_EQ(f1(x, 1000 - x / 2), f2(x, 1000 - x / 2));
}

TEST(Scene, CliffHasTheVolumesOfItsSection) {
  const Truth truth = make_scene("relief", options(4, 4, 0, "cliff"), Context{}).truth;
  EXPECT_NEAR(truth.above, 198602.667, 1e-3);  // computed elsewhere
  EXPECT_NEAR(truth.below, 148602.667, 1e-3);
  const Surface f1 = scene_surface("relief", "cliff", 1), f2 = scene_surface("relief", "cliff", 2);
  Sum above, below;
  const double step = 1e-4;
  for (int i = 0; i < 10'000'000; ++i) {
    const double x = (i + 0.5) * step, d = f2(x, 300) - f1(x, 300);
    (d > 0 ? above : below).add(std::fabs(d) * step * 1000);
  }
  expect_relative(above.value(), truth.above, 1e-8, "above");
  expect_relative(below.value(), truth.below, 1e-8, "below");
  EXPECT_NEAR(truth.net, 50000, 1e-9);
}

TEST(Scene, PartsOfTheTerrainAreTheirOwnIntegrals) {
  const Truth truth = make_scene("terrain", options(100, 100), Context{}).truth;
  const Surface f1 = scene_surface("terrain", "", 1), f2 = scene_surface("terrain", "", 2);
  const auto band = [&](double from, double to) {
    return quadrature(f1, f2, rectangle({412000, 5236000 + from}, {413000, 5236000 + to}), 500);
  };
  const Volumes pit = band(0, 300), landslide = band(300, 800), mound = band(800, 1000);
  expect_relative(-pit.below, truth.parts.at("pit"), 1e-6, "pit");
  expect_relative(mound.above, truth.parts.at("mound"), 1e-6, "mound");
  expect_relative(-landslide.below, truth.parts.at("landslide_scar"), 1e-6, "scar");
  expect_relative(landslide.above, truth.parts.at("landslide_deposit"), 1e-6, "deposit");
  EXPECT_EQ(pit.above + mound.below, 0);
  EXPECT_NEAR(truth.parts.at("landslide_deposit"), -1.25 * truth.parts.at("landslide_scar"), 1e-9);  // bulking
  EXPECT_NEAR(truth.parts.at("landslide_net"), truth.parts.at("landslide_deposit") + truth.parts.at("landslide_scar"),
              1e-9);
  EXPECT_EQ(truth.parts.size(), 5U);
}

TEST(Scene, ChangesOfTerrainAndFaceLieWellInside) {
  for (const std::string name : {"terrain", "face"}) {
    const Surface f1 = scene_surface(name, "", 1), f2 = scene_surface(name, "", 2);
    const Outline footprint = make_scene(name, options(100, 100), Context{}).footprint;
    Point2 centre{0, 0};
    for (const Point2& p : footprint)
      centre = {centre.x + p.x / static_cast<double>(footprint.size()),
                centre.y + p.y / static_cast<double>(footprint.size())};
    for (std::size_t i = 0; i < footprint.size(); ++i)
      for (double t = 0; t < 1; t += 0.002)
        for (double inwards = 0; inwards < 0.12; inwards += 0.02) {
          const Point2 p = footprint[i], q = footprint[(i + 1) % footprint.size()];
          const double x = p.x + t * (q.x - p.x), y = p.y + t * (q.y - p.y);
          const double mx = x + inwards * (centre.x - x), my = y + inwards * (centre.y - y);
          ASSERT_EQ(f1(mx, my), f2(mx, my)) << name << " " << mx << " " << my;
        }
  }
}

TEST(Scene, FaceIsSymmetricAndItsSwellingIsNot) {
  const Surface f1 = scene_surface("face", "", 1), f2 = scene_surface("face", "", 2);
  double swollen = 0;
  for (double x = 1; x < 60; x += 1)
    for (double y = -90; y < 90; y += 1) {
      EXPECT_NEAR(f1(x, y), f1(-x, y), 1e-12 * 150);
      swollen = std::max(swollen, f2(x, y) - f2(-x, y));
    }
  EXPECT_NEAR(swollen, 6, 0.05);
}

TEST(Scene, ReliefIsAsDescribed) {
  const Scene terrain = make_scene("terrain", options(20000, 20000), Context{});
  const auto [low, high] = std::minmax_element(terrain.a.points.begin(), terrain.a.points.end(),
                                               [](const Point3& p, const Point3& q) { return p.z < q.z; });
  EXPECT_NEAR(high->z - low->z, 60, 5);
  const Scene face = make_scene("face", options(20000, 20000), Context{});
  const auto tip = std::max_element(face.a.points.begin(), face.a.points.end(),
                                    [](const Point3& p, const Point3& q) { return p.z < q.z; });
  EXPECT_LT(std::hypot(tip->x, tip->y + 10), 5);  // the tip of the nose is nearest to the viewer
}

TEST(Scene, PointsWithoutNoiseLieOnTheSurface) {
  for (const std::string& name : scene_names())
    for (const std::string& variant : variants(name)) {
      const Scene scene = make_scene(name, options(3000, 5000, 0, variant), Context{});
      const double bound = name == "terrain" ? 0.0005 * (1 + 1e-9) : 0;
      for (const auto& [cloud, epoch] : {std::pair(&scene.a, 1), std::pair(&scene.b, 2)}) {
        const Surface f = scene_surface(name, variant, epoch);
        for (const Point3& p : cloud->points) {
          ASSERT_TRUE(is_finite(p));
          ASSERT_LE(std::fabs(p.z - f(p.x, p.y)), bound) << name << " " << p.x << " " << p.y;
        }
      }
    }
}

TEST(Scene, TerrainKeepsMillimetresInLargeCoordinates) {
  const Scene scene = make_scene("terrain", options(5000, 5000, 0.03), Context{});
  for (const Cloud* cloud : {&scene.a, &scene.b})
    for (const Point3& p : cloud->points) {
      EXPECT_TRUE(p.x >= 412000 && p.x <= 413000 && p.y >= 5236000 && p.y <= 5237000);
      for (const double v : {p.x, p.y, p.z}) EXPECT_EQ(v, std::round(v * 1000) / 1000);
    }
}

TEST(Scene, NoiseHasTheStatedDeviationAndNoBias) {
  for (const std::string& name : scene_names()) {
    SceneOptions o = options(20000, 20000);
    o.noise_a = 0.03;
    o.noise_b = 0.1;
    const Scene scene = make_scene(name, o, Context{}), clean = make_scene(name, options(20000, 20000), Context{});
    std::vector<double> residuals[2];
    for (int k = 0; k < 2; ++k) {
      const Cloud& cloud = k == 0 ? scene.a : scene.b;
      const Cloud& exact = k == 0 ? clean.a : clean.b;
      ASSERT_EQ(cloud.points.size(), exact.points.size());
      double sum = 0, squares = 0;
      for (std::size_t i = 0; i < cloud.points.size(); ++i) {
        ASSERT_EQ(cloud.points[i].x, exact.points[i].x);  // noise acts on heights alone
        ASSERT_EQ(cloud.points[i].y, exact.points[i].y);
        const double e = cloud.points[i].z - exact.points[i].z;
        residuals[k].push_back(e);
        sum += e;
        squares += e * e;
      }
      const double n = static_cast<double>(cloud.points.size()), sd = k == 0 ? o.noise_a : o.noise_b;
      EXPECT_LT(std::fabs(sum / n), 4 * sd / std::sqrt(n)) << name;
      EXPECT_NEAR(std::sqrt(squares / n), sd, 4 * sd / std::sqrt(2 * n)) << name;
    }
    double product = 0;  // the two scanners err independently
    const std::size_t n = std::min(residuals[0].size(), residuals[1].size());
    for (std::size_t i = 0; i < n; ++i) product += residuals[0][i] * residuals[1][i];
    EXPECT_LT(std::fabs(product / std::sqrt(static_cast<double>(n)) / (o.noise_a * o.noise_b)), 4) << name;
  }
}

TEST(Scene, HasAboutAsManyPointsAsAskedFor) {
  for (const std::string& name : scene_names()) {
    const Scene scene = make_scene(name, options(20000, 7000), Context{});
    EXPECT_NEAR(static_cast<double>(scene.a.points.size()), 20000, 200) << name;
    EXPECT_NEAR(static_cast<double>(scene.b.points.size()), 7000, 70) << name;
  }
}

TEST(Scene, SameBitsForAnyNumberOfThreads) {
  for (const std::string& name : scene_names()) {
    Context one, seven, other;
    one.threads = 1;
    seven.threads = 7;
    other.seed = 2;
    const SceneOptions o = options(20000, 30000, 0.01);
    const Scene first = make_scene(name, o, one), second = make_scene(name, o, seven),
                third = make_scene(name, o, other);
    EXPECT_EQ(first.a.points, second.a.points) << name;
    EXPECT_EQ(first.b.points, second.b.points) << name;
    EXPECT_NE(first.a.points, third.a.points) << name;
    EXPECT_NE(first.b.points, third.b.points) << name;
    EXPECT_EQ(first.truth.above, third.truth.above) << name;  // the truth does not depend on the seed
  }
}

TEST(Scene, SmallestScansAreAccepted) {
  for (const std::string& name : scene_names()) {
    const std::size_t least = name == "terrain" || name == "face" ? 100 : 4;
    const Scene scene = make_scene(name, options(least, least), Context{});
    EXPECT_GE(scene.a.points.size(), 4U) << name;
    EXPECT_GE(scene.b.points.size(), 4U) << name;
    EXPECT_THROW((void)make_scene(name, options(least - 1, least), Context{}), UsageError) << name;
    EXPECT_THROW((void)make_scene(name, options(least, least - 1), Context{}), UsageError) << name;
  }
}

template <class F>
std::string message_of(F&& f) {
  try {
    f();
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no UsageError";
}

TEST(Scene, WrongOptionsAreUsageErrorsThatSayWhatIsKnown) {
  const auto make = [](const std::string& name, const SceneOptions& o) {
    return message_of([&] { (void)make_scene(name, o, Context{}); });
  };
  for (const std::string& name : scene_names())
    EXPECT_NE(make("mountain", options(100, 100)).find(name), std::string::npos);
  EXPECT_NE(make("plane", options(100, 100, 0, "bent")).find("lifted, tilted"), std::string::npos);
  EXPECT_NE(make("cone", options(100, 100, 0, "bent")).find("no variants"), std::string::npos);
  EXPECT_NE(make("cone", options(100, 100, -0.1)).find("-0.1"), std::string::npos);
  EXPECT_NE(make("cone", options(100, 100, std::nan(""))).find("noise"), std::string::npos);
  EXPECT_NE(make("cone", options(100, 100, INFINITY)).find("noise"), std::string::npos);
  EXPECT_NE(make("cone", options(3, 100)).find("at least 4"), std::string::npos);
  EXPECT_NE(make("cone", options(100, max_nodes + 1)).find("too many"), std::string::npos);
  EXPECT_NE(message_of([] { (void)scene_surface("cone", "", 3); }).find("epoch"), std::string::npos);
  EXPECT_NE(message_of([] { (void)scene_surface("cone", "bent", 1); }).find("no variants"), std::string::npos);
  EXPECT_NE(message_of([] { (void)scene_variants("mountain"); }).find("terrain"), std::string::npos);
  EXPECT_NE(message_of([] { (void)scene_defaults("mountain"); }).find("terrain"), std::string::npos);
}

TEST(Scene, CanBeInterruptedAndReportsProgress) {
  std::atomic<bool> stop{false};
  std::vector<double> fractions;
  Context context;
  context.cancelled = &stop;
  context.progress = [&](std::string_view, double fraction) {
    fractions.push_back(fraction);
    stop = fraction >= 0.5;
  };
  EXPECT_THROW((void)make_scene("cone", options(100, 100), context), Interrupted);
  EXPECT_EQ(fractions, (std::vector<double>{0, 0.5}));
}

TEST(WorstCase, TreeOfTheZigzagCrossesTheStripOncePerEdge) {
  const Scene scene = make_scene("worst-case", options(31, 40), Context{});
  const Array<Point3>& a = scene.a.points;
  for (std::size_t i = 0; i + 1 < a.size(); ++i) {
    EXPECT_EQ(std::fabs(a[i].y), 0.5);
    EXPECT_EQ(a[i + 1].y, -a[i].y);
    const double step = std::hypot(a[i + 1].x - a[i].x, 1.0);
    for (std::size_t j = i + 2; j < a.size(); ++j)  // so the tree joins i and i + 1, and nothing else
      EXPECT_GT(std::hypot(a[j].x - a[i].x, a[j].y - a[i].y), step + 0.1);
  }
}

TEST(WorstCase, SecondTriangulationFillsTheStripWithLongEdges) {
  const Scene scene = make_scene("worst-case", options(31, 40), Context{});
  const Array<Point3>& b = scene.b.points;
  // Three nodes that follow one another in height, two of one column and one of the other, have an empty circle: so
  // they are a Delaunay triangle with two edges along the strip, and there are as many as nodes in the columns, less
  // two.
  for (std::size_t i = 4; i + 2 < b.size(); ++i) {
    const Point3 &p = b[i], &q = b[i + 1], &r = b[i + 2];
    EXPECT_EQ(q.x, -p.x);
    EXPECT_EQ(r.x, p.x);
    EXPECT_LT(std::fabs(q.y), 0.1);
    const double my = (p.y + r.y) / 2;  // centre (mx, my): as far from p as from q
    const double mx = (q.x * q.x + (q.y - my) * (q.y - my) - p.x * p.x - (p.y - my) * (p.y - my)) / (2 * (q.x - p.x));
    const double radius = std::hypot(p.x - mx, p.y - my);
    for (std::size_t j = 0; j < b.size(); ++j)
      if (j < i || j > i + 2) {
        EXPECT_GT(std::hypot(b[j].x - mx, b[j].y - my), radius) << i << " " << j;
      }
  }
  // The hull of the zigzag lies between the columns and inside the corners.
  for (const Point3& p : scene.a.points) EXPECT_LT(std::fabs(p.x), std::fabs(b[4].x));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_GT(std::min(std::fabs(b[i].x), std::fabs(b[i].y)), std::fabs(b[4].x));
}

TEST(WorstCase, FootprintIsTheHullOfTheZigzag) {
  for (const std::size_t n : {4U, 5U, 30U, 31U}) {
    const Scene scene = make_scene("worst-case", options(n, 10), Context{});
    EXPECT_NEAR(scene.truth.area, 0.8 * static_cast<double>(n - 2), 1e-12);
    for (const Point2& corner : scene.footprint)
      EXPECT_EQ(std::count_if(scene.a.points.begin(), scene.a.points.end(),
                              [&](const Point3& p) { return p.x == corner.x && p.y == corner.y; }),
                1);
    for (const Point3& p : scene.a.points) EXPECT_TRUE(contains(scene.footprint, {p.x, p.y}));
  }
}

TEST(Bump, BendAndSkewKeepTheVolume) {
  const Bump plain{{3, -2}, -7, 70, 50, {0.8, -0.6}, 0, 0};
  Bump shaped = plain;
  shaped.bend = 0.004;
  shaped.skew = -0.8;
  const Outline box = rectangle({-120, -120}, {120, 120});
  for (const Bump& bump : {plain, shaped}) {
    const Volumes v =
        quadrature([](double, double) { return 0.0; }, [&](double x, double y) { return bump.at(x, y); }, box, 300);
    EXPECT_NEAR(-v.below, bump.volume(), 1e-7 * v.below);
    EXPECT_EQ(v.above, 0);
  }
  EXPECT_NE(plain.at(20, 10), shaped.at(20, 10));
}

}  // namespace
}  // namespace isopach
