#include <cmath>
#include <sstream>

#include <gtest/gtest.h>

#include "isopach/report/page/text.hpp"
#include "tests/report/sample_comparison.hpp"

namespace isopach {
namespace {

Comparison lifted() {
  return sample::make(
      {}, [](double, double) { return 0; }, [](double, double) { return 0.25; });
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

bool has_line(const std::string& text, const std::string& label, const std::string& rest) {
  for (const std::string& line : lines(text))
    if (line.find(label) != std::string::npos && line.find(rest) != std::string::npos) return true;
  return false;
}

TEST(Text, GivesTheNumbersWithTheirUnits) {
  const std::string text = comparison_text(lifted(), std::nullopt);
  EXPECT_EQ(lines(text)[0], "B lies on average 0.2500 m above A: 25.00 m³ gained and 0 m³ lost on 100.0 m².");
  EXPECT_TRUE(has_line(text, "  net ", "+25.00 m³"));
  EXPECT_TRUE(has_line(text, "mean |d| (rho)", "0.2500 m"));
  EXPECT_TRUE(has_line(text, "area compared", "100.0 % of the area"));
  EXPECT_TRUE(has_line(text, "  B ", "after.laz: 400 points"));
  EXPECT_LE(lines(text).size(), 16u);
  EXPECT_EQ(text.back(), '\n');
}

TEST(Text, WarningsComeLast) {
  Comparison c = lifted();
  c.warnings = {"first", "leave @border hull out"};
  const auto all = lines(comparison_text(c, std::nullopt));
  EXPECT_EQ(all[all.size() - 2], "warning: first");
  EXPECT_EQ(all.back(), "warning: leave --border hull out");
}

TEST(Text, ShowsTheTruthWhereItIsKnown) {
  Truth truth;
  truth.above = truth.net = 20;
  const std::string text = comparison_text(lifted(), truth);
  EXPECT_TRUE(has_line(text, "true net", "off by +5.0, +25 %"));
  EXPECT_TRUE(has_line(text, "true lost", "off by 0"));
}

TEST(Text, ShowsTheTruthBesideWhatIsLeftWithoutTheNoiseFloor) {
  Comparison c = lifted();
  c.noise_floor.emplace();
  c.noise_floor->debiased.above = 21;
  Truth truth;
  truth.above = truth.net = 20;
  EXPECT_TRUE(has_line(comparison_text(c, truth), "true gained",
                       "off by +5.0, +25 %; without the noise floor 21.00, off by +1.0, +5.0 %"));
}

TEST(Text, CountsWhatWasDropped) {
  Comparison c = lifted();
  c.a.cleaning.duplicates = 12345;
  c.a.nodata = 7;
  EXPECT_TRUE(has_line(comparison_text(c, std::nullopt), "  A ", "12 345 duplicates merged, 7 no data"));
}

TEST(Text, UnknownUnitsAreSaidSo) {
  Comparison c = lifted();
  c.unit = "unknown";
  const std::string text = comparison_text(c, std::nullopt);
  EXPECT_TRUE(has_line(text, "units", "unknown (as in the files)"));
  EXPECT_TRUE(has_line(text, "  net ", "units³"));
  EXPECT_EQ(text.find(" m³"), std::string::npos);
}

}  // namespace
}  // namespace isopach
