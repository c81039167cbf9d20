// result.json of `isopach accuracy` against its schema; text, map and page say what it says; the verdict.
#include "isopach/report/accuracy.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/support/clouds.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;

Cloud part(std::size_t points, std::uint64_t seed, double lift, const char* path) {
  Cloud cloud = test::cloud_over(test::framed_square(points, seed),
                                 [&](const Point2& p) { return 0.2 * std::sin(5 * p.x) * std::cos(4 * p.y) + lift; });
  cloud.unit = cloud.vertical_unit = "mm";
  cloud.path = path;
  return cloud;
}

Accuracy sample(Align align, double within = 0) {
  AccuracyOptions o;
  o.align = align;
  o.within = within;
  if (within > 0) o.match.compare.project.crop = Box2{{0.1, 0.1}, {0.9, 0.9}};
  return accuracy(part(1500, 1, 0.02, "ma<de.ply"), part(3000, 2, 0, "truth.ply"), o, {});
}

const std::vector<AccuracyLimit> limits{{"bias", 0.5, false}, {"max", 0.001, false}, {"completeness", 0.5, true}};

TEST(AccuracyReport, JsonIsThatOfTheSchema) {
  std::ifstream file(test::source_folder() / "docs" / "schema" / "accuracy-1.json");
  const Json schema = Json::parse(file);
  for (const Accuracy& a : {sample(Align::none), sample(Align::rigid, 0.01), sample(Align::scale)}) {
    const Json json = Json::parse(accuracy_json(a, verdict(a, limits), {"pose.txt"}));
    for (const std::string& violation : test::SchemaCheck::violations(schema, json)) ADD_FAILURE() << violation;
    EXPECT_EQ(json["surface"]["bias"].get<double>(), a.comparison.measures.difference.mean);
    EXPECT_EQ(json["points"]["noise"].get<double>(), a.points.noise);
    EXPECT_EQ(json["alignment"]["scale"].get<double>(), a.scale);
    EXPECT_EQ(json["parameters"]["freedom"].empty(), a.options.align == Align::none);
  }
}

TEST(AccuracyReport, VerdictIsByEachLimit) {
  const Accuracy a = sample(Align::none);
  const std::vector<AccuracyCheck> checks = verdict(a, limits);
  ASSERT_EQ(checks.size(), 3u);
  EXPECT_TRUE(checks[0].passed);
  EXPECT_FALSE(checks[1].passed);
  EXPECT_TRUE(checks[2].passed);
  const std::string why = failed(a, checks);
  EXPECT_NE(why.find("max is "), std::string::npos) << why;
  EXPECT_NE(why.find("above 0.001000 mm"), std::string::npos) << why;
  EXPECT_EQ(why.find("bias"), std::string::npos) << why;
  EXPECT_FALSE(Json::parse(accuracy_json(a, checks, {}))["verdict"]["passed"].get<bool>());
  EXPECT_TRUE(failed(a, verdict(a, {limits[0]})).empty());
  EXPECT_TRUE(Json::parse(accuracy_json(a, {}, {}))["verdict"]["passed"].is_null());
  // What was not measured passes no limit.
  EXPECT_FALSE(verdict(a, {{"within", 0, true}})[0].passed);
  EXPECT_FALSE(verdict(a, {{"within", 1, false}})[0].passed);
}

TEST(AccuracyReport, TextMapAndPageSayTheSame) {
  Accuracy a = sample(Align::rigid, 0.01);
  a.warnings = {"leave @border hull out"};
  a.matching->reason = "stopped after 3 steps (@max-iterations)";
  const std::vector<AccuracyCheck> checks = verdict(a, limits);
  const std::string text = accuracy_text(a, checks);
  for (const char* word : {"against truth.ply: bias", "noise", "within 0.01000 mm", "NOT passed", "hausdorff",
                           "stopped after 3 steps (--max-iterations)", "warning: leave --border hull out"})
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  const auto folder = std::filesystem::temp_directory_path() / "isopach-accuracy-report";
  std::filesystem::create_directories(folder);
  const std::string map = (folder / "map.png").string(), page = (folder / "report.html").string();
  MapOptions look;
  look.width = 500;
  write_accuracy_map(map, a, look, {});
  write_accuracy_html(page, a, map, accuracy_json(a, checks, {}), look, {});
  std::stringstream html;
  html << std::ifstream(page).rdbuf();
  for (const char* word :
       {"Accuracy of ma&lt;de.ply", "data-key=\"surface.bias\"", "data-key=\"verdict.checks.1.value\"",
        "data:image/png;base64,", "not passed", "Options in force", "stopped after 3 steps (--max-iterations)",
        "<li>leave --border hull out</li>"})
    EXPECT_NE(html.str().find(word), std::string::npos) << word;
  EXPECT_EQ(html.str().find("ma<de"), std::string::npos);
}

}  // namespace
}  // namespace isopach
