// result.json of `isopach roughness` against its schema; the page, the summary and the table against result.json.
#include "isopach/report/roughness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>

#include "isopach/io/read.hpp"
#include "tests/io/files.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;

Cloud groove(std::uint64_t seed, double depth) {
  Cloud cloud = test::cloud_over(test::framed_square(3000, seed), [&](const Point2& p) {
    return 0.2 * p.x + 0.002 * std::sin(40 * p.x) -
           (std::fabs(p.y - 0.5) < 0.04 && std::fabs(p.x - 0.5) < 0.3 ? depth : 0);
  });
  cloud.unit = cloud.vertical_unit = "mm";
  cloud.path = depth > 0.05 ? "be<fore.ply" : "after.ply";
  return cloud;
}

Roughness sample(bool after, bool reference, bool match = false) {
  RoughnessOptions o;
  o.l_filter = after ? 0.6 : 0;
  o.margin = 0.1;
  o.wrinkles = {0.02, 0.3};
  o.compare.check_layers = false;
  o.match = match;
  const Cloud scan = groove(1, 0.1), second = groove(2, 0.04);
  Cloud plane = test::cloud_over(test::framed_square(200, 3), [](const Point2& p) { return 0.2 * p.x; });
  plane.unit = "mm";
  if (reference) o.form = FormKind::reference;
  const auto given = [](bool wanted, const Cloud& cloud) {
    return wanted ? std::optional<CloudView>(cloud) : std::nullopt;
  };
  return roughness(scan, given(after, second), given(reference, plane), o, {});
}

Json schema() {
  std::ifstream file(test::source_folder() / "docs" / "schema" / "roughness-1.json");
  return Json::parse(file);
}

TEST(RoughnessReport, JsonIsThatOfTheSchema) {
  for (const bool after : {false, true})
    for (const bool reference : {false, true}) {
      const Json json = Json::parse(roughness_json(sample(after, reference), {"result.json"}));
      for (const std::string& violation : test::SchemaCheck::violations(schema(), json)) ADD_FAILURE() << violation;
      EXPECT_EQ(json["after"].is_null(), !after);
      EXPECT_EQ(json["change"].is_null(), !after);
      EXPECT_EQ(json["reference_pose"].is_null(), !reference);
      EXPECT_EQ(json["inputs"].size(), 1u + after + reference);
    }
}

TEST(RoughnessReport, JsonHoldsTheNumbers) {
  const Roughness r = sample(true, false);
  const Json json = Json::parse(roughness_json(r, {"x.ply"}));
  EXPECT_EQ(json["scan"]["parameters"]["sa"].get<double>(), r.scan.parameters.sa);
  EXPECT_EQ(json["after"]["parameters"]["sdr"].get<double>(), r.after->parameters.sdr);
  EXPECT_EQ(json["change"]["parameters"]["sq"].get<double>(), r.after->parameters.sq / r.scan.parameters.sq - 1);
  EXPECT_EQ(json["parameters"]["l_filter"].get<double>(), 0.6);
  ASSERT_EQ(r.scan.wrinkles.all.size(), 1u);
  EXPECT_EQ(json["scan"]["wrinkles"]["list"][0]["depth"].get<double>(), r.scan.wrinkles.all[0].depth);
  EXPECT_EQ(json["change"]["wrinkles"][0]["depth"].get<double>(), r.wrinkles_after[0].depth);
  EXPECT_LT(json["change"]["wrinkles"][0]["depth_change"].get<double>(), -0.4);
  EXPECT_EQ(json["outputs"][0], "x.ply");
}

TEST(RoughnessReport, TextHasUnitsChangesAndWarnings) {
  Roughness r = sample(true, false);
  r.warnings = {"look out: leave @border hull out"};
  const std::string text = roughness_text(r);
  for (const char* part : {"be<fore.ply", "after.ply", "Sa", "Sku", "Sdr", " mm", " -> ", "wrinkles", "depth",
                           "removed: a plane", "warning: look out: leave --border hull out"})
    EXPECT_NE(text.find(part), std::string::npos) << part;
  EXPECT_EQ(roughness_text(sample(false, false)).find(" -> "), std::string::npos);
}

TEST(RoughnessReport, TableHasALineAWrinkle) {
  const Roughness r = sample(true, false);
  const std::string csv = wrinkles_csv(r);
  EXPECT_EQ(csv.rfind("number,depth,mean_depth,length,width,area,volume,x,y,z,depth_after,mean_depth_after\n1,", 0),
            0u);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2);
  const double depth = std::stod(csv.substr(csv.find("\n1,") + 3));
  EXPECT_EQ(depth, r.scan.wrinkles.all[0].depth);
}

TEST(RoughnessReport, PageHasTheNumbersOfTheJson) {
  Roughness r = sample(true, false);
  r.warnings = {"look out: leave @border hull out"};
  const test::TempFolder folder;
  const std::string map = folder / "map.png", lines = folder / "lines.png";
  MapOptions look;
  look.width = 400;
  write_roughness_map(map, r, r.scan, look, {});
  write_wrinkle_map(lines, r, r.scan, look, {});
  const std::string json = roughness_json(r, {}), path = folder / "report.html";
  write_roughness_html(path, r, {{map, "Roughness"}, {lines, "Wrinkles"}}, json, look, {});
  std::ifstream file(path);
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(page.find("be&lt;fore.ply"), std::string::npos);
  EXPECT_NE(page.find("<li>look out: leave --border hull out</li>"), std::string::npos);
  const Json result = Json::parse(json);
  std::size_t found = 0;
  const std::regex datum("data-key=\"([^\"]*)\"[^>]*value=\"([^\"]*)\"");
  for (std::sregex_iterator i(page.begin(), page.end(), datum), end; i != end; ++i, ++found) {
    std::string pointer = "/" + (*i)[1].str();
    std::replace(pointer.begin(), pointer.end(), '.', '/');
    EXPECT_EQ(result.at(Json::json_pointer(pointer)).dump(), (*i)[2].str()) << pointer;
  }
  EXPECT_GT(found, 40u);
  std::size_t pictures = 0;
  for (std::size_t at = 0; (at = page.find("data:image/png;base64,", at)) != std::string::npos; ++at) ++pictures;
  EXPECT_EQ(pictures, 2u);
}

TEST(RoughnessReport, PointsHoldTheFields) {
  const Roughness r = sample(false, false);
  const test::TempFolder folder;
  const std::string path = folder / "points.csv";
  write_roughness_points(path, groove(1, 0.1), r.scan, {});
  ReadOptions all;
  all.all_attributes = true;
  const Cloud back = read_cloud(path, all, {});
  for (const char* name : {"waviness", "roughness", "valley", "wrinkle"}) {
    ASSERT_NE(back.find_attribute(name), nullptr) << name;
    EXPECT_EQ(back.find_attribute(name)->values.size(), r.scan.fields[0].values.size());
  }
}

}  // namespace
}  // namespace isopach
