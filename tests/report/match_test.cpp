// result.json of `isopach match` against its schema, the summary, pose.txt.
#include "isopach/report/match.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>

#include "isopach/io/read.hpp"
#include "isopach/match/match.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/formulas.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;

double hills(const Point2& p) { return 0.1 * std::sin(7 * p.x) * std::cos(9 * p.y) + 0.05 * p.x; }

Cloud moving_scan() {
  Cloud cloud = test::shifted(test::cloud_over(test::framed_square(700, 2), hills), {0.02, 0.01, 0.3});
  cloud.path = "after.ply";
  cloud.unit = "mm";
  return cloud;
}

Matching sample(MatchOptions options = {}) {
  Cloud fixed = test::cloud_over(test::framed_square(600, 1), hills);
  fixed.path = "before.ply";
  fixed.unit = "mm";
  return match(moving_scan(), fixed, options, {});
}

TEST(MatchReport, JsonIsThatOfTheSchema) {
  std::ifstream file(test::source_folder() / "docs" / "schema" / "match-1.json");
  const Json schema = Json::parse(file);
  MatchOptions options;
  options.compare.project.crop = Box2{{-1, -1}, {2, 2}};
  options.overlap = 0.9;
  options.freedom.scale = true;
  MatchOptions pose_only;
  pose_only.judge = false;
  pose_only.compare.weight = test::weight_by("1 + x");
  for (const Matching& m : {sample(), sample(options), sample(pose_only)}) {
    const Json json = Json::parse(match_json(m, {"pose.txt"}));
    for (const std::string& violation : test::SchemaCheck::violations(schema, json)) ADD_FAILURE() << violation;
  }
}

TEST(MatchReport, JsonHoldsTheNumbers) {
  const Matching m = sample();
  const Json json = Json::parse(match_json(m, {"pose.txt"}));
  EXPECT_EQ(json["objective"], "measure");
  EXPECT_EQ(json["pose"]["matrix"][1][3].get<double>(), m.pose.m[7]);
  EXPECT_EQ(json["after"]["rho"].get<double>(), m.after.rho);
  EXPECT_EQ(json["before"]["coverage"].get<double>(), m.before.coverage);
  EXPECT_EQ(json["covariance"][4][4].get<double>(), m.covariance[28]);
  EXPECT_EQ(json["history"].size(), m.history.size());
  EXPECT_EQ(json["parameters"]["overlap"], "auto");
  EXPECT_EQ(json["parameters"]["freedom"].size(), 6u);
  EXPECT_EQ(json["inputs"][0]["path"], "after.ply");
  EXPECT_EQ(json["inputs"][1]["path"], "before.ply");
  // The local matrix does the same as the one in input coordinates, about its origin.
  const Json& local = json["pose"]["local"];
  const Point3 p{0.3, 0.4, 0.5}, moved = m.pose.apply(p);
  double x = local["origin"][0].get<double>() + local["matrix"][0][3].get<double>();
  x += local["matrix"][0][0].get<double>() * (p.x - local["origin"][0].get<double>());
  x += local["matrix"][0][1].get<double>() * (p.y - local["origin"][1].get<double>());
  x += local["matrix"][0][2].get<double>() * (p.z - local["origin"][2].get<double>());
  EXPECT_NEAR(x, moved.x, 1e-14);
}

TEST(MatchReport, PoseTextIsTheExactMatrix) {
  const Matching m = sample();
  std::istringstream text(pose_text(m.pose));
  for (const double expected : m.pose.m) {
    double value = 0;
    text >> value;
    EXPECT_EQ(value, expected);
  }
  const std::string all = text.str();
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 4);
}

TEST(MatchReport, TextHasUnitsAndWarnings) {
  Matching m = sample();
  m.warnings = {"mind the gap: leave @border hull out"};
  m.reason = "stopped after 3 steps (@max-iterations)";
  const std::string text = match_text(m);
  for (const char* word :
       {"after.ply on before.ply", " mm", "rotation", "degrees", "converged",
        "stopped after 3 steps (--max-iterations)", "warning: mind the gap: leave --border hull out"})
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  m.converged = false;
  EXPECT_NE(match_text(m).find("NOT converged"), std::string::npos);
}

// Every number shown with a key is that of result.json.
TEST(MatchReport, PageHoldsTheNumbers) {
  MatchOptions pose_only;
  pose_only.judge = false;
  for (Matching m : {sample(), sample(pose_only)}) {
    m.moving.path = "<after>.ply";
    m.weak_directions = {"shift along x is weakly held: leave it out of @freedom"};
    m.reason = "stopped after 3 steps (@max-iterations)";
    m.warnings = {"leave @border hull out"};
    const std::string path = (std::filesystem::temp_directory_path() / "isopach_match_report.html").string();
    const std::string json = match_json(m, {"report.html"});
    write_match_html(path, m, {}, json, {});
    std::ifstream in(path);
    const std::string page{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    std::filesystem::remove(path);
    const Json all = Json::parse(json);
    const std::regex datum("data-key=\"([^\"]*)\"[^>]* value=\"([^\"]*)\"");
    std::set<std::string> keys;
    for (std::sregex_iterator i(page.begin(), page.end(), datum), end; i != end; ++i) {
      std::string pointer = "/" + (*i)[1].str();
      std::replace(pointer.begin(), pointer.end(), '.', '/');
      EXPECT_EQ(all.at(Json::json_pointer(pointer)).dump(), (*i)[2].str());
      keys.insert((*i)[1]);
    }
    for (const char* key : {"pose.angle_deg", "pose.matrix.0.3", "pose.local.matrix.2.3", "overlap", "stable_points"})
      EXPECT_TRUE(keys.count(key)) << key;
    EXPECT_EQ(keys.count("after.rho"), m.options.judge ? 1u : 0u);
    for (const char* word : {"&lt;after&gt;.ply", " mm", "shift along x is weakly held: leave it out of --freedom",
                             "turn about z", "stopped after 3 steps (--max-iterations)", "leave --border hull out"})
      EXPECT_NE(page.find(word), std::string::npos) << word;
    EXPECT_EQ(all["reason"], "stopped after 3 steps (--max-iterations)");
    EXPECT_EQ(all["weak_directions"][0], "shift along x is weakly held: leave it out of --freedom");
    EXPECT_EQ(all["warnings"], Json::array({"leave --border hull out"}));
    EXPECT_EQ(page.find("<polyline") != std::string::npos, m.history.size() > 1);  // one state is no curve
    EXPECT_EQ(page.find("n/a"), std::string::npos);
    EXPECT_EQ(page.find("<after>"), std::string::npos);
  }
}

TEST(MatchReport, MovedPointsAndStableMask) {
  const Matching m = sample();
  const Cloud moving = moving_scan();
  const std::string path = (std::filesystem::temp_directory_path() / "isopach_match_moved.ply").string();
  write_moved(path, moving, m, {});
  ReadOptions wanted;
  wanted.all_attributes = true;
  const Cloud moved = read_cloud(path, wanted, {});
  std::filesystem::remove(path);
  ASSERT_EQ(moved.points.size(), moving.points.size());
  EXPECT_EQ(moved.points[17], m.pose.apply(moving.points[17]));
  ASSERT_NE(moved.find_attribute("stable"), nullptr);
  double stable = 0;
  for (const double s : moved.find_attribute("stable")->values) stable += s;
  EXPECT_GT(stable, 400);
}

}  // namespace
}  // namespace isopach
