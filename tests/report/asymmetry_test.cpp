// result.json of `isopach asymmetry` against its schema, and the pages.
#include "isopach/report/asymmetry.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "isopach/report/draw/map.hpp"
#include "tests/apps/mean_faces.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;

Asymmetry sample(const AsymmetryOptions& options = {}) {
  static const Bump bump = test::cheek(6);
  test::FaceScan scan;
  scan.points = 3000;
  scan.added = [](double x, double y) { return bump.at(x, y); };
  return asymmetry(test::mean_face_scan(scan), options, {});
}

TEST(AsymmetryReport, JsonIsThatOfTheSchema) {
  std::ifstream file(test::source_folder() / "docs" / "schema" / "asymmetry-1.json");
  const Json schema = Json::parse(file);
  AsymmetryOptions options;
  options.across = Point3{-1, 0, 0};
  options.compare.project.crop = Box2{{-70, -80}, {70, 80}};
  options.parts = FaceParts::halves;
  options.overlap = 0.9;
  AsymmetryOptions given = options;
  given.orientation = FaceOrientation::given;
  options.stable = {StablePart::forehead, StablePart::nose};
  for (const Asymmetry& a : {sample(), sample(options), sample(given)}) {
    const Json json = Json::parse(asymmetry_json(a, {"pose.txt"}));
    for (const std::string& violation : test::SchemaCheck::violations(schema, json)) ADD_FAILURE() << violation;
    EXPECT_EQ(json["index"]["percent"].get<double>(), a.index.percent);
    EXPECT_EQ(json["plane"]["offset"].get<double>(), a.plane.offset);
    EXPECT_EQ(json["regions"][1]["volume"]["net"].get<double>(), a.regions[1].volume.net);
    EXPECT_EQ(json["plane"]["positive_side"], a.plane.normal.x > 0 ? "+x" : "-x");
  }
}

TEST(AsymmetryReport, TextMapAndPageSayTheSame) {
  Asymmetry a = sample();
  a.warnings = {"leave @border hull out"};
  a.reason = "stopped after 3 steps (@max-iterations)";
  EXPECT_EQ(Json::parse(asymmetry_json(a, {}))["fit"]["reason"], "stopped after 3 steps (--max-iterations)");
  const std::string text = asymmetry_text(a);
  for (const char* word : {"asymmetry index", "the patient's left side stands out", "R is the patient's right", "plane",
                           "upper third", "mm", "warning: leave --border hull out"})
    EXPECT_NE(text.find(word), std::string::npos) << word;
  const auto folder = std::filesystem::temp_directory_path() / "isopach-asymmetry-report";
  std::filesystem::create_directories(folder);
  const std::string map = (folder / "map.png").string(), page = (folder / "report.html").string();
  MapOptions look;
  look.width = 500;
  write_asymmetry_map(map, a, look, {});
  write_asymmetry_html(page, a, map, asymmetry_json(a, {}), look, {});
  std::stringstream html;
  html << std::ifstream(page).rdbuf();
  for (const char* word : {"Asymmetry of face.ply", "data-key=\"index.percent\"", "data-key=\"regions.3.directional\"",
                           "data:image/png;base64", "The symmetry plane", "<li>leave --border hull out</li>"})
    EXPECT_NE(html.str().find(word), std::string::npos) << word;
  std::filesystem::remove_all(folder);
}

/// Sides were named by axes of the file ("+x side"), and the index had digits far below its floor ("0.000132 %").
TEST(AsymmetryReport, WithoutAFaceSidesAreThoseOfThePicture) {
  test::FaceScan scan;
  scan.points = 3000;
  AsymmetryOptions options;
  options.orientation = FaceOrientation::given;
  Asymmetry a = asymmetry(test::mean_face_scan(scan), options, {});
  a.pose = FacePose{};  // as where no face is found
  a.index.percent = 0.000132, a.index.floor = 0.15;
  a.comparison.noise_floor->rho = 0.25, a.comparison.noise_floor->debiased_rho = 0.0002;
  a.regions.front().directional = -1.23456;
  const std::string text = asymmetry_text(a), json = asymmetry_json(a, {});
  const auto path = (std::filesystem::temp_directory_path() / "isopach-asymmetry-unknown.html").string();
  write_asymmetry_html(path, a, "", json, {}, {});
  std::stringstream html;
  html << std::ifstream(path).rdbuf();
  std::filesystem::remove(path);
  for (const std::string& told : {text, html.str().substr(0, html.str().find("Everything, exactly"))}) {
    for (const char* word : {"the side on the left of the picture stands out by 1.23", "less than 0.01",
                             "Which side is the patient", "those of the picture"})
      EXPECT_NE(told.find(word), std::string::npos) << word << "\n" << told;
    for (const char* word : {"+x side", "-x side", " 0.000132", ">0.000132", " 0.0002 ", ">0.0002<"})
      EXPECT_EQ(told.find(word), std::string::npos) << word << "\n" << told;
  }
  EXPECT_NE(json.find("0.000132"), std::string::npos) << "result.json has all digits";
}

}  // namespace
}  // namespace isopach
