// report.html: one file, nothing fetched, names escaped, and every number equal to result.json.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "isopach/report/report.hpp"
#include "isopach/version.hpp"
#include "tests/report/sample_comparison.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;

Comparison hills() {
  Comparison c = sample::make(
      {30, 20, 29, 19, {512300, 5405100, 0}}, [](double x, double) { return 0.1 * x; },
      [](double x, double y) { return 0.1 * x + 3 * std::sin(x / 3) * std::cos(y / 4) - 0.1; },
      [](double x, double) { return x < 20; });
  c.a.points = 1234567;
  c.a.cleaning.duplicates = 12;
  return c;
}

/// Without the view, whose script and data tests/report/thin_test.cpp and tests/viewer look at.
std::string page(const Comparison& c, const std::string& map = "", const std::optional<Truth>& truth = std::nullopt) {
  const std::string path = testing::TempDir() + "isopach_html_test.html";
  MapOptions look;
  look.vertices = 0;
  write_html(path, c, comparison_json(c, {"result.json"}), {map, truth, look, nullptr}, {});
  std::ifstream in(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  std::filesystem::remove(path);
  return text;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t i = 0; (i = text.find(from, i)) != std::string::npos; i += to.size())
    text.replace(i, from.size(), to);
  return text;
}

/// Reads back what people see: "−1 234.5", "1.2×10⁻⁷".
double people_number(std::string text) {
  text = replaced(replaced(replaced(text, "\u202f", ""), "−", "-"), "×10", "e");
  const char* raised[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  for (int k = 0; k < 10; ++k) text = replaced(text, raised[k], std::to_string(k));
  return std::stod(replaced(text, "⁻", "-"));
}

Json at(const Json& json, std::string key) { return json.at(Json::json_pointer("/" + replaced(key, ".", "/"))); }

TEST(Html, EveryNumberEqualsTheJson) {
  for (const double lift : {0.0, 1e-9, 1e7}) {
    Comparison c = hills();
    for (double& z : c.cells.z2) z += lift;
    sample::fill_measures(c);
    const Json json = Json::parse(comparison_json(c, {"result.json"}));
    const std::string html = page(c);
    const std::regex datum(
        "<data data-key=\"([^\"]+)\"( data-percent)? value=\"([^\"]*)\" title=\"([^\"]*)\">([^<]*)</data>");
    std::set<std::string> seen;
    for (std::sregex_iterator i(html.begin(), html.end(), datum), end; i != end; ++i) {
      const std::smatch& m = *i;
      const Json exact = at(json, m[1]);
      EXPECT_EQ(m[3], exact.dump()) << m[1];
      EXPECT_EQ(m[4], exact.dump()) << m[1];
      seen.insert(m[1]);
      if (!exact.is_number()) continue;
      const double factor = m[2].matched ? 100 : 1, expected = factor * exact.get<double>(),
                   shown = people_number(m[5]);
      const bool unsigned_in_words = m[1] == "difference.mean";  // "0.1 m below A"
      const double tolerance = m[2].matched ? 0.0501 : 6e-4 * std::fabs(expected);
      EXPECT_TRUE(std::fabs(shown - expected) <= tolerance ||
                  (unsigned_in_words && std::fabs(shown - std::fabs(expected)) <= tolerance))
          << m[1] << ": " << m[5] << " for " << expected;
    }
    for (const char* key : {"volume", "domain", "measure", "triangulations", "timing_s"})
      for (const auto& [name, value] : json[key].items())
        EXPECT_TRUE(value.is_null() || seen.count(key + ("." + name)) || (name == "error_estimate" && value == 0.0))
            << key << "." << name;  // an integral in closed form has no error to tell of
    for (const char* name : {"mean", "rms", "std", "median", "nmad", "max_above", "max_below", "abs_percentiles.50",
                             "abs_percentiles.90", "abs_percentiles.95", "abs_percentiles.99"})
      EXPECT_TRUE(seen.count(std::string("difference.") + name)) << name;
    EXPECT_TRUE(seen.count("inputs.0.points") && seen.count("inputs.1.bounds.max.2"));
  }
}

TEST(Html, HoldsTheWholeJson) {
  const Comparison c = hills();
  const std::string html = page(c), open = "<script type=\"application/json\" id=\"result\">";
  const std::size_t begin = html.find(open);
  ASSERT_NE(begin, std::string::npos);
  const std::size_t from = begin + open.size();
  EXPECT_EQ(Json::parse(html.substr(from, html.find("</script>", from) - from)),
            Json::parse(comparison_json(c, {"result.json"})));
}

TEST(Html, NamesAreEscapedEverywhere) {
  Comparison c = hills();
  c.a.path = "</script><script>alert('1')</script>&\"x\".laz";
  c.b.path = "b\xff<img src=x onerror=y>.laz";
  c.warnings = {"<b>bold</b> & more"};
  c.a.crs = "PROJCS[\"<i>\"]";
  const std::string html = page(c);
  for (const char* bad : {"<script>", "<img src=x", "<b>bold", "<i>"})
    EXPECT_EQ(html.find(bad), std::string::npos) << bad;
  EXPECT_NE(html.find("&lt;b&gt;bold&lt;/b&gt; &amp; more"), std::string::npos);
  EXPECT_EQ(html.find('\xff'), std::string::npos);
}

TEST(Html, OptionsAreSpelledAsAtTheCommandLine) {
  Comparison c = hills();
  c.warnings = {"leave @border hull out"};
  c.options.unit = "m";
  const std::string html = page(c);
  EXPECT_NE(html.find("<li>leave --border hull out</li>"), std::string::npos);
  EXPECT_NE(html.find(" (as --unit says; in the file: "), std::string::npos);
  for (const char* bad : {"@border", "@unit"}) EXPECT_EQ(html.find(bad), std::string::npos) << bad;
}

TEST(Html, FetchesNothingAndRunsNothing) {
  const std::string html = page(hills());
  for (const char* bad :
       {"http://", "https://", "src=\"//", "@import", "url(", "<link", "onload", "onclick", "<script>"})
    EXPECT_EQ(html.find(bad), std::string::npos) << bad;
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
}

TEST(Html, EmbedsTheMap) {
  const std::string path = testing::TempDir() + "isopach_html_test.png";
  for (const char* bytes : {"M", "Ma", "Man", "Many"}) std::ofstream(path, std::ios::binary) << bytes;
  const std::pair<const char*, const char*> known[] = {{"M", "base64,TQ==\""},
                                                       {"Ma", "base64,TWE=\""},
                                                       {"Man", "base64,TWFu\""},
                                                       {"\xff\xfe\xfd\xfc", "base64,//79/A==\""}};
  for (const auto& [bytes, text] : known) {
    std::ofstream(path, std::ios::binary) << bytes;
    EXPECT_NE(page(hills(), path).find(text), std::string::npos) << text;
  }
  std::filesystem::remove(path);
  EXPECT_THROW((void)page(hills(), path), InputError);
  EXPECT_EQ(page(hills()).find("<img"), std::string::npos);
}

TEST(Html, ShowsTheTruthWhereItIsKnown) {
  Truth truth;
  truth.above = 100;
  truth.below = 50;
  truth.net = 50;
  truth.area = 380;
  truth.parts = {{"big_mound", 12.5}};
  const std::string with = page(hills(), "", truth), without = page(hills());
  EXPECT_NE(with.find("Against the known truth"), std::string::npos);
  EXPECT_NE(with.find("big mound 12.50"), std::string::npos);
  EXPECT_EQ(without.find("Against the known truth"), std::string::npos);
}

TEST(Html, SaysWhenUnitsAreUnknown) {
  Comparison c = hills();
  EXPECT_EQ(page(c).find("units unknown"), std::string::npos);
  c.unit = "unknown";
  EXPECT_NE(page(c).find("units unknown (as in the files)"), std::string::npos);
}

TEST(Html, SaysTheSignRuleAndTheVersion) {
  const std::string html = page(hills());
  EXPECT_NE(html.find("d = B − A, positive where B lies above A"), std::string::npos);
  EXPECT_NE(html.find("isopach " + std::string(version)), std::string::npos);
}

TEST(Html, TheSameBytesTwice) { EXPECT_EQ(page(hills()), page(hills())); }

TEST(Html, WritesAPageWhenNothingDiffersAndWhenNothingIsKnown) {
  const auto flat = [](double, double) { return 0.0; };
  EXPECT_NE(page(sample::make({}, flat, flat)).find("do not differ"), std::string::npos);
  Comparison c = hills();
  c.measures.difference.histogram = {};
  c.measures.error_estimate = std::nan("");
  const std::string html = page(c);  // what is not known has no row
  EXPECT_EQ(html.find(">nan<"), std::string::npos);
  EXPECT_EQ(html.find("error of the integral"), std::string::npos);
}

}  // namespace
}  // namespace isopach
