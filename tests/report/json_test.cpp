// result.json: valid against its schema, keys in order, nothing that is not JSON, the same bytes twice.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "isopach/report/report.hpp"
#include "tests/report/sample_comparison.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;

Comparison hills() {
  return sample::make(
      {30, 20, 29, 19, {512300, 5405100, 0}}, [](double x, double) { return 0.1 * x; },
      [](double x, double y) { return 0.1 * x + std::sin(x / 3) * std::cos(y / 4) - 0.1; },
      [](double x, double) { return x < 20; });
}

Json schema() {
  const auto path = test::source_folder() / "docs/schema/compare-1.json";
  std::ifstream in(path);
  EXPECT_TRUE(in.good()) << path;
  return Json::parse(in);
}

std::string violations(const Json& value) {
  std::string all;
  for (const std::string& v : test::SchemaCheck::violations(schema(), value)) all += v + "\n";
  return all;
}

std::vector<std::string> keys(const Json& object) {
  std::vector<std::string> out;
  for (const auto& [key, unused] : object.items()) out.push_back(key);
  return out;
}

TEST(ComparisonJson, IsValidAgainstItsSchema) {
  Comparison c = hills();
  EXPECT_EQ(violations(Json::parse(comparison_json(c, {"difference.png"}))), "");
  c.options.project.classes = {2, 8};
  c.options.project.crop = Box2{{0, 0}, {5, 5}};
  c.a.crs = "EPSG:25832";
  c.detail = DetailMeasure{true, 0.25, -0.1, 20, 7, 3};
  c.options.measure = MeasureKind::dV;
  c.options.weight = {WeightSource::Kind::attribute, WeightSource::Scan::b, "intensity"};
  c.weighted = WeightedMeasures{3, 2, 1, 1, 0.5, 0, 0};
  c.options.measure = MeasureKind::currents;
  c.options.currents.sigma = 2;
  c.currents = CurrentsComparison{{2, 16, 25, 18, 5, 1e-6, 1e-6, 1e-6, 4e-6, true}, 100, 90};
  c.options.surface = Surface::both;
  c.overlay = c.measures;
  EXPECT_EQ(violations(Json::parse(comparison_json(c, {}))), "");
}

TEST(ComparisonJson, TheSchemaCheckCanFail) {
  const Json good = Json::parse(comparison_json(hills(), {}));
  const std::vector<std::pair<std::string, Json>> spoilt{{"/schema", "other/1"},
                                                         {"/volume/net", "12"},
                                                         {"/volume/above", -1.0},
                                                         {"/inputs/0/points", 1.5},
                                                         {"/inputs/0/role", "C"},
                                                         {"/outputs", Json::array({1})},
                                                         {"/pose/matrix/3", Json::array({1, 2, 3})},
                                                         {"/timing_s/total", "1 s"},
                                                         {"/domain/extra", 1}};
  for (const auto& [pointer, value] : spoilt) {
    Json bad = good;
    bad[Json::json_pointer(pointer)] = value;
    EXPECT_NE(violations(bad), "") << pointer;
  }
  for (const std::string& key : keys(good)) {
    Json bad = good;
    bad.erase(key);
    EXPECT_NE(violations(bad), "") << key;
  }
  EXPECT_FALSE(test::SchemaCheck::violations(Json{{"pattern", "x"}}, "x").empty());
}

TEST(ComparisonJson, SpellsTheOptionsOfWarningsAndNothingElse) {
  Comparison c = hills();
  EXPECT_EQ(Json::parse(comparison_json(c, {}))["warnings"], Json::array());
  c.warnings = {"leave @border hull out", "user@host: a note"};
  c.a.path = "@mask";
  const Json j = Json::parse(comparison_json(c, {"@mask"}));
  EXPECT_EQ(j["warnings"], Json::array({"leave --border hull out", "user@host: a note"}));
  EXPECT_EQ(j["inputs"][0]["path"], "@mask");
  EXPECT_EQ(j["outputs"][0], "@mask");
}

TEST(ComparisonJson, KeysAreInTheOrderOfTheContract) {
  const Json j = Json::parse(comparison_json(hills(), {}));
  const std::vector<std::string> order{
      "schema",       "tool",        "inputs", "parameters", "pose",    "matched",    "verdict",
      "domain",       "measure",     "volume", "surfaces",   "budget",  "difference", "triangulations",
      "localisation", "uncertainty", "border", "folds",      "outputs", "warnings",   "timing_s"};
  EXPECT_EQ(keys(j), order);
  EXPECT_EQ(keys(j["volume"]), (std::vector<std::string>{"above", "below", "net", "absolute"}));
  EXPECT_EQ(keys(j["measure"]),
            (std::vector<std::string>{"rho", "rho_dv", "detail", "error_estimate", "weight", "currents"}));
  const std::vector<std::string> input = keys(j["inputs"][0]);
  EXPECT_EQ(std::vector<std::string>(input.begin(), input.begin() + 8),
            (std::vector<std::string>{"role", "path", "points", "nodes", "duplicates", "unit", "crs", "bounds"}));
}

TEST(ComparisonJson, TimingSumsStagesOfOneNameAndKeepsOthersAfter) {
  const Json t = Json::parse(comparison_json(hills(), {}))["timing_s"];
  EXPECT_EQ(keys(t), (std::vector<std::string>{"read", "delaunay", "spanning_tree", "localise", "merge", "measure",
                                               "write", "total", "project"}));
  EXPECT_EQ(t["read"], 0.75);
  EXPECT_EQ(t["project"], 0.125);
  EXPECT_EQ(t["merge"], 0.0);
  EXPECT_EQ(t["total"], 1.5);
}

TEST(ComparisonJson, NumbersComeBackBitForBit) {
  const Comparison c = hills();
  const Json j = Json::parse(comparison_json(c, {}));
  EXPECT_EQ(j["volume"]["above"].get<double>(), c.measures.volume.above);
  EXPECT_EQ(j["volume"]["net"].get<double>(), c.measures.volume.net);
  EXPECT_EQ(j["difference"]["abs_percentiles"]["95"].get<double>(), c.measures.difference.abs_percentiles[2]);
  EXPECT_EQ(j["difference"]["histogram"]["areas"].get<std::vector<double>>(), c.measures.difference.histogram.areas);
  EXPECT_EQ(j["inputs"][1]["bounds"]["min"][1].get<double>(), 5405100.0);
  EXPECT_TRUE(j["inputs"][0]["points"].is_number_integer());
  EXPECT_EQ(j["inputs"][0]["points"].get<std::size_t>(), c.a.points);
}

TEST(ComparisonJson, WhatIsNotKnownIsNull) {
  Comparison c = hills();
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  c.detail.reset();
  c.measures.error_estimate = nan;
  c.a.layered_share = infinity;
  c.b.bounds = Box3{};  // empty: infinite
  const std::string text = comparison_json(c, {});
  const Json j = Json::parse(text);
  EXPECT_TRUE(j["measure"]["rho_dv"].is_null());
  EXPECT_TRUE(j["measure"]["error_estimate"].is_null());
  EXPECT_TRUE(j["inputs"][0]["layered_share"].is_null());
  EXPECT_TRUE(j["inputs"][0]["crs"].is_null());
  EXPECT_TRUE(j["inputs"][1]["bounds"]["max"][2].is_null());
  EXPECT_TRUE(j["uncertainty"]["sigma_net"].is_null());
  for (const char* word : {"nan", "NaN", "inf", "Infinity"}) EXPECT_EQ(text.find(word), std::string::npos) << word;
}

TEST(ComparisonJson, EveryOptionInForceIsThere) {
  Comparison c = hills();
  c.options.domain = DomainKind::hull;
  c.options.project.duplicates = DuplicatePolicy::median;
  c.options.project.direction.kind = Direction::Kind::axis_y;
  c.options.project.classes = {2};
  c.options.project.crop = Box2{{1, 2}, {3, 4}};
  c.options.min_coverage = 0.5;
  c.options.locate = LocateMethod::order;
  c.options.allow_crs = true;
  c.options.check_layers = false;
  c.options.pose.m[3] = 7.5;
  c.frame.rotation = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  c.unit = c.a.vertical_unit = "mm";
  const Json j = Json::parse(comparison_json(c, {"a.png", "b.ply"}));
  const Json& p = j["parameters"];
  EXPECT_EQ(p["domain"], "hull");
  EXPECT_EQ(p["duplicates"], "median");
  EXPECT_EQ(p["direction"], Json::array({0.0, 1.0, 0.0}));
  EXPECT_EQ(p["direction_rule"], "y");
  EXPECT_EQ(p["class"], Json::array({2}));
  EXPECT_EQ(p["crop"], Json::array({1.0, 2.0, 3.0, 4.0}));
  EXPECT_EQ(p["min_coverage"], 0.5);
  EXPECT_EQ(p["locate"], "order");
  EXPECT_EQ(j["localisation"]["method"], "order");
  EXPECT_EQ(p["allow_crs"], true);
  EXPECT_EQ(p["check_layers"], false);
  EXPECT_EQ(p["unit"], "mm");
  EXPECT_EQ(p["height_unit"], "mm");
  EXPECT_EQ(j["pose"]["matrix"][0][3], 7.5);
  EXPECT_EQ(j["outputs"], Json::array({"a.png", "b.ply"}));
}

TEST(ComparisonJson, TheSameComparisonGivesTheSameBytes) {
  EXPECT_EQ(comparison_json(hills(), {"x"}), comparison_json(hills(), {"x"}));
}

TEST(ComparisonJson, FileNamesOfAnyBytesAreWritten) {
  Comparison c = hills();
  c.a.path = "bad\xff\xfename \"quoted\" \n.laz";
  const Json j = Json::parse(comparison_json(c, {}));
  EXPECT_NE(j["inputs"][0]["path"].get<std::string>().find("name \"quoted\" \n.laz"), std::string::npos);
}

}  // namespace
}  // namespace isopach
