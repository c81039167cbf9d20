// The short report: its words, and both of its forms.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>

#include <gtest/gtest.h>

#include "isopach/base/error.hpp"
#include "isopach/report/draw/canvas.hpp"
#include "isopach/report/draw/map.hpp"
#include "isopach/report/short_report.hpp"
#include "tests/report/sample_comparison.hpp"

namespace isopach {
namespace {

Comparison ramp() {
  return sample::make(
      {30, 20, 29, 19, {512300, 5405100, 0}}, [](double x, double) { return 0.1 * x; },
      [](double x, double y) { return 0.1 * x + 0.2 * (y - 9); });
}

Comparison with_sigma(Comparison c) {
  c.uncertainty.lod = 0.5;
  c.uncertainty.sigma = VolumeTriple{3.0, 2.0, 2.5};
  c.uncertainty.deviations = 1.96;
  c.uncertainty.detected = Detected{};
  c.options.uncertainty.model = UncertaintyModel::independent;
  return c;
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  std::filesystem::remove(path);
  return bytes;
}

const ShortRow& row(const ShortReport& r, const std::string& key) {
  for (const ShortRow& x : r.numbers)
    if (x.key == key) return x;
  throw std::runtime_error(key);
}

TEST(ShortReport, VolumesHaveTheirInterval) {
  const Comparison c = with_sigma(ramp());
  const ShortReport r = short_report(c, {}, nullptr);
  EXPECT_EQ(row(r, "volume.net").plus_minus, "± 5.9");
  EXPECT_EQ(row(r, "volume.net").unit, "m³");
  EXPECT_FALSE(row(r, "volume.above").plus_minus.empty());
  EXPECT_TRUE(row(r, "difference.max_above").plus_minus.empty()) << "of a single place";
  EXPECT_NE(r.meaning[0].find("95\u00a0%"), std::string::npos);
  EXPECT_NE(r.meaning[1].find("level of detection"), std::string::npos);
}

TEST(ShortReport, WithoutErrorsNoneIsClaimed) {
  const ShortReport r = short_report(ramp(), {}, nullptr);
  for (const ShortRow& x : r.numbers) EXPECT_TRUE(x.plus_minus.empty()) << x.key;
  EXPECT_NE(r.meaning[0].find("No error"), std::string::npos);
}

TEST(ShortReport, LongListsAreCutAndSaidSo) {
  Comparison c = ramp();
  c.changes.emplace();
  for (int k = 0; k < 25; ++k) {
    Change& x = c.changes->list.emplace_back();
    x.volume = 100 - k, x.area = 10, x.mean = 1, x.largest = 2;
  }
  for (int k = 0; k < 9; ++k) c.warnings.push_back("something to know");
  const ShortReport r = short_report(c, {}, nullptr);
  ASSERT_EQ(r.tables.size(), 1u);
  EXPECT_EQ(r.tables[0].rows.size(), short_rows);
  EXPECT_EQ(r.tables[0].left_out, 25 - short_rows);
  EXPECT_EQ(r.cautions.size(), short_cautions);
  EXPECT_EQ(r.more_cautions, 9 - short_cautions);
}

TEST(ShortReport, PdfHasTwoPagesAndTheSameBytes) {
  Comparison c = with_sigma(ramp());
  c.a.path = "bad\xff.laz";
  for (int k = 0; k < 9; ++k) c.warnings.push_back(std::string(900, 'w') + " something to know");
  MapOptions look;
  look.author = "A. Surveyor", look.date = "2026-01-02";
  const std::string path = testing::TempDir() + "isopach_short_test.pdf";
  std::string first;
  for (int k = 0; k < 2; ++k) {
    write_pdf(path, c, look, nullptr, true, {});
    const std::string bytes = bytes_of(path);
    EXPECT_TRUE(first.empty() || bytes == first);
    first = bytes;
  }
  const std::regex page("/Type /Page\\b(?!s)");
  EXPECT_EQ(std::distance(std::sregex_iterator(first.begin(), first.end(), page), {}), 2);
}

TEST(ShortReport, PageHasNoScriptAndEscapesNames) {
  Comparison c = ramp();
  c.b.path = "<script>x</script>.laz";
  const std::string path = testing::TempDir() + "isopach_short_test.html";
  write_short_html(path, c, comparison_json(c, {}), {"", std::nullopt, {}, nullptr}, {});
  const std::string page = bytes_of(path);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_NE(page.find("The numbers"), std::string::npos);
}

TEST(MapRange, IsTheLimitOfEveryMap) {
  const Comparison c = ramp();
  MapOptions look;
  EXPECT_EQ(colour_limit(c, look), colour_limit(c));
  look.range = 7;
  EXPECT_EQ(colour_limit(c, look), 7);
}

TEST(MapExtent, GivesEqualFramesAndRefusesWhatShowsNothing) {
  MapOptions look;
  look.width = 500;
  look.extent = Box2{{512290, 5405090}, {512350, 5405130}};
  const Comparison whole = ramp();
  const Comparison part = sample::make(
      {30, 20, 12, 19, {512310, 5405100, 0}}, [](double, double) { return 0; }, [](double x, double) { return x; });
  EXPECT_EQ(render_map(whole, look, {}).height, render_map(part, look, {}).height);
  look.extent = Box2{{0, 0}, {10, 10}};
  EXPECT_THROW((void)render_map(whole, look, {}), UsageError);
  look.extent = Box2{{512290, 5405090}, {512350, 5405090.5}};
  EXPECT_THROW((void)render_map(whole, look, {}), UsageError);
  Comparison turned = ramp();
  turned.frame.rotation = {0, 1, 0, 0, 0, 1, 1, 0, 0};
  look.extent = Box2{{512290, 5405090}, {512350, 5405130}};
  EXPECT_THROW((void)render_map(turned, look, {}), UsageError);
}

TEST(Logo, IsDecodedOnWhite) {
  Image image;
  image.width = 3, image.height = 2;
  image.rgb.assign(18, 128);
  const std::string bytes = png_of(image);
  const Logo logo = logo_of(bytes + "behind it", "logo.png");
  EXPECT_EQ(logo.image->rgb, image.rgb);
  EXPECT_EQ(logo.png, bytes);
  for (std::size_t n = 0; n + 40 < bytes.size(); ++n)
    EXPECT_THROW((void)logo_of(bytes.substr(0, n), "logo.png"), InputError) << n;
  EXPECT_THROW((void)logo_of(std::string(largest_logo + 1, ' '), "logo.png"), InputError);
}

}  // namespace
}  // namespace isopach
