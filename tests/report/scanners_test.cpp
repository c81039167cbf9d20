// result.json of `isopach scanners` against its schema; text, map and page say what it says.
#include "isopach/report/scanners.hpp"

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

Cloud scan(std::size_t points, std::uint64_t seed, const char* path) {
  Cloud cloud = test::cloud_over(test::framed_square(points, seed), [](const Point2& p) {
    return 0.2 * std::sin(5 * p.x) * std::cos(4 * p.y) + 0.01 * std::sin(60 * p.x) * std::sin(60 * p.y);
  });
  cloud.unit = cloud.vertical_unit = "mm";
  cloud.path = path;
  return cloud;
}

Scanners sample(bool align) {
  ScannersOptions o;
  o.align = align;
  return scanners(scan(4000, 1, "fi<ne.ply"), scan(150, 2, "coarse.ply"), scan(6000, 3, "truth.ply"), o, {});
}

TEST(ScannersReport, JsonIsThatOfTheSchema) {
  std::ifstream file(test::source_folder() / "docs" / "schema" / "scanners-1.json");
  const Json schema = Json::parse(file);
  for (const bool align : {false, true}) {
    const Scanners s = sample(align);
    const Json json = Json::parse(scanners_json(s, {"report.html"}));
    for (const std::string& violation : test::SchemaCheck::violations(schema, json)) ADD_FAILURE() << violation;
    EXPECT_EQ(json["scanners"][1]["noise"].get<double>(), s.scan[1].spot.noise);
    EXPECT_EQ(json["between"]["rho_dv"].get<double>(), s.rho_dv);
    EXPECT_EQ(json["detail"].size(), s.detail.size());
    EXPECT_EQ(json["parameters"]["freedom"].empty(), !align);
  }
}

TEST(ScannersReport, TextMapAndPageSayTheSame) {
  Scanners s = sample(false);
  s.warnings = {"leave @border hull out"};
  const std::string text = scanners_text(s);
  for (const char* word :
       {"A resolves finer detail than B", "B - A", "rho_dV", "seen by", "mm", "warning: leave --border hull out"})
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  const auto folder = std::filesystem::temp_directory_path() / "isopach-scanners-report";
  std::filesystem::create_directories(folder);
  const std::string map = (folder / "map.png").string(), page = (folder / "report.html").string();
  MapOptions look;
  look.width = 500;
  write_scanners_map(map, s, look, {});
  write_scanners_html(page, s, map, scanners_json(s, {}), look, {});
  std::stringstream html;
  html << std::ifstream(page).rdbuf();
  for (const char* word :
       {"Scanners of truth.ply", "fi&lt;ne.ply", "data-key=\"scanners.1.noise\"", "data-key=\"detail.0.gain.1\"",
        "data:image/png;base64,", "Options in force", "<li>leave --border hull out</li>"})
    EXPECT_NE(html.str().find(word), std::string::npos) << word;
  EXPECT_EQ(html.str().find("fi<ne"), std::string::npos);
}

}  // namespace
}  // namespace isopach
