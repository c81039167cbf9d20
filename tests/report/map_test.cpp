#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/draw/palette.hpp"
#include "tests/report/sample_comparison.hpp"

namespace isopach {
namespace {

double flat(double, double) { return 0; }

/// A smaller picture than the default is drawn faster and has the same layout.
Image draw(const Comparison& c, MapOptions options = {}) {
  options.width = 640;
  return render_map(c, options, {});
}

TEST(Palette, IsWhiteAtZeroAndEquallyLightEitherSide) {
  for (const std::string& name : palettes()) {
    const Palette palette(name, false), flipped(name, true);
    EXPECT_EQ(palette(0).r, 1);
    EXPECT_EQ(palette(0).g, 1);
    EXPECT_EQ(palette(0).b, 1);
    double before = 1.001;
    for (int k = 1; k <= 100; ++k) {
      const double t = k / 100.0;
      const double above = lightness(palette(t)), below = lightness(palette(-t));
      EXPECT_NEAR(above, below, 0.004) << name << " " << t;
      EXPECT_LT(above, before) << name << " " << t;
      before = above;
      EXPECT_EQ(palette(t).r, flipped(-t).r);
      EXPECT_EQ(palette(t).b, flipped(-t).b);
    }
    EXPECT_EQ(palette(7).r, palette(1).r);
  }
}

TEST(Palette, DefaultsFollowTheField) {
  const Palette blue_above("blue-red", false);
  EXPECT_GT(blue_above(1).b, blue_above(1).r);
  EXPECT_GT(blue_above(-1).r, blue_above(-1).b);
  EXPECT_TRUE(paints_excess_red("mm"));
  EXPECT_FALSE(paints_excess_red("m"));
  EXPECT_FALSE(paints_excess_red("ft"));
  EXPECT_THROW(Palette("rainbow", false), UsageError);
}

/// Share of pixels that are clearly bluish / reddish.
struct Tint {
  double blue = 0, red = 0;
};
Tint tint(const Image& image) {
  Tint t;
  const double pixels = static_cast<double>(image.width) * image.height;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const int difference = int(image.rgb[i + 2]) - int(image.rgb[i]);
    if (difference > 60) t.blue += 1 / pixels;
    if (difference < -60) t.red += 1 / pixels;
  }
  return t;
}

TEST(Map, OppositeDifferencesGiveOppositeColoursOfEqualExtent) {
  const auto ramp = [](double x, double) { return x - 5; };
  const Tint t = tint(draw(sample::make({}, flat, ramp)));
  EXPECT_GT(t.blue, 0.1);
  EXPECT_NEAR(t.blue, t.red, 0.02);
}

TEST(Map, ColoursFollowUnitAndFlip) {
  const auto up = [](double x, double) { return x; };
  const Tint metres = tint(draw(sample::make({}, flat, up)));
  const Tint millimetres = tint(draw(sample::make({}, flat, up, nullptr, "mm")));
  MapOptions flipped;
  flipped.flip = true;
  const Tint metres_flipped = tint(draw(sample::make({}, flat, up), flipped));
  EXPECT_GT(metres.blue, 5 * metres.red);
  EXPECT_GT(millimetres.red, 5 * millimetres.blue);
  EXPECT_GT(metres_flipped.red, 5 * metres_flipped.blue);
}

TEST(Map, NoDifferenceIsWhite) {
  const auto hills = [](double x, double y) { return std::sin(x) * y; };
  const Comparison c = sample::make({}, hills, hills);
  EXPECT_TRUE(shows_no_difference(c));
  EXPECT_EQ(colour_limit(c), 1);
  // The bar alone is coloured (two thirds of its 30 × 640 pixels in 1600 × 1500).
  const Tint t = tint(draw(c));
  EXPECT_LT(t.blue, 0.008);
  EXPECT_LT(t.red, 0.008);
}

TEST(Map, LimitsAreThe99thPercentileInTwoDigits) {
  Comparison c = sample::make({}, flat, [](double x, double) { return x; });
  c.measures.difference.abs_percentiles[3] = 0.03712;
  EXPECT_DOUBLE_EQ(colour_limit(c), 0.038);
  c.measures.difference.abs_percentiles[3] = 120;
  EXPECT_DOUBLE_EQ(colour_limit(c), 120);
  c.measures.difference.abs_percentiles[3] = 0;  // less than 1 % of the area differs
  EXPECT_DOUBLE_EQ(colour_limit(c), 10);
}

TEST(Map, ColoursReachTheLargestDifferenceWhereItIsNoOutlier) {
  Comparison c = sample::make({}, flat, [](double x, double) { return x; });
  c.measures.difference.abs_percentiles[3] = 6.4;  // largest: 10
  EXPECT_DOUBLE_EQ(colour_limit(c), 10);
  c.measures.difference.abs_percentiles[3] = 6.1;
  EXPECT_DOUBLE_EQ(colour_limit(c), 6.1);
}

TEST(Map, ColoursReachBeyondTheLevelOfDetection) {
  Comparison c = sample::make({}, flat, [](double x, double) { return x; });
  c.uncertainty.lod = 2.5;  // largest |d|: 10
  EXPECT_DOUBLE_EQ(colour_limit(c), 10);
  c.uncertainty.lod = 8;
  EXPECT_DOUBLE_EQ(colour_limit(c), 16);
  c.uncertainty.lod = 123.4;  // all grey: the colours are those of differences that would be seen
  EXPECT_DOUBLE_EQ(colour_limit(c), 250);
}

TEST(Map, TheSamePixelsTwiceAndForAnyNumberOfThreads) {
  const Comparison c = sample::make(
      {40, 30, 10, 7}, [](double x, double y) { return std::sin(x * y); },
      [](double x, double y) { return std::sin(x * y) + x - y; }, [](double x, double) { return x < 8; });
  const Image first = draw(c);
  for (const int threads : {1, 2, 7}) {
    Image again;
    run_with_threads(threads, [&] { again = draw(c); });
    EXPECT_EQ(first.rgb, again.rgb) << threads;
  }
}

TEST(Map, AnyShapeOfSceneFits) {
  const auto wave = [](double x, double y) { return std::sin(x) - std::cos(y); };
  struct Shape {
    double width, height;
  };
  for (const Shape s : {Shape{2000, 100}, Shape{100, 2000}, Shape{1e-6, 1e-6}, Shape{1e7, 1}, Shape{1, 1e9}}) {
    const Image image = draw(sample::make({12, 12, s.width, s.height, {5e5, 5e6, 0}}, flat, wave));
    EXPECT_EQ(image.width, 640);
    EXPECT_GT(image.height, 140) << s.width;
    EXPECT_LT(image.height, 680) << s.width;
    EXPECT_GT(tint(image).blue, 0.0005) << s.width;
  }
  Comparison tiny = sample::make({2, 2, 1, 1}, flat, [](double x, double) { return x; });
  tiny.cells.triangulation.real = 1;
  EXPECT_GT(tint(draw(tiny)).blue, 0.02);
}

TEST(Map, WorksWithoutADomainAndWithoutCells) {
  const auto up = [](double, double) { return 1.0; };
  EXPECT_GT(draw(sample::make({}, flat, up, [](double, double) { return false; })).height, 120);
  EXPECT_GT(draw(Comparison{}).height, 120);
}

TEST(Map, FarOutliersDoNotShrinkTheDomain) {
  const auto up = [](double x, double) { return x; };
  // 1 % of the width is compared; it still fills most of the map.
  const Comparison c = sample::make({401, 11, 1000, 10}, flat, up, [](double x, double) { return x < 10; });
  EXPECT_GT(tint(draw(c)).blue, 0.15);
}

TEST(Map, NamesOfAnyBytesAndLengthAreDrawn) {
  Comparison c = sample::make({}, flat, [](double x, double) { return x - 5; });
  c.a.path = "bad\xff\xfe.laz";
  c.b.path = std::string(2000, 'w') + "é.laz";
  const Image image = draw(c);
  EXPECT_GT(tint(image).blue, 0.1);  // cairo refuses everything after an invalid string
  const Image plain = draw(sample::make({}, flat, [](double x, double) { return x - 5; }));
  EXPECT_EQ(image.height, plain.height);
}

TEST(Map, RefusesSizesAndPalettesThatMakeNoSense) {
  MapOptions narrow, unknown;
  narrow.width = 10;
  unknown.palette = "rainbow";
  const Comparison c = sample::make({}, flat, flat);
  EXPECT_THROW((void)render_map(c, narrow, {}), UsageError);
  EXPECT_THROW((void)render_map(c, unknown, {}), UsageError);
}

TEST(Map, IsWrittenAsPng) {
  const std::string path = testing::TempDir() + "isopach_map_test.png";
  write_map(path, sample::make({}, flat, [](double x, double) { return x; }), {}, {});
  std::ifstream in(path, std::ios::binary);
  std::string magic(8, ' ');
  in.read(magic.data(), 8);
  EXPECT_EQ(magic, "\x89PNG\r\n\x1a\n");
  std::filesystem::remove(path);
  EXPECT_THROW(write_map("/nonexistent-folder/map.png", sample::make({}, flat, flat), {}, {}), Error);
}

}  // namespace
}  // namespace isopach
