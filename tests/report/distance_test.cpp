// result.json of `isopach distance` against its schema, the summary, the files.
#include "isopach/report/distance.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "isopach/io/read.hpp"
#include "tests/support/clouds.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;

Distances sample(const DistanceMeasures& measures) {
  const auto level = [](double z) { return [z](const Point2& p) { return z + 0.1 * p.x; }; };
  Cloud a = test::cloud_over(test::framed_square(300, 1), level(0)),
        b = test::cloud_over(test::framed_square(300, 2), level(0.5));
  a.unit = b.unit = "mm";
  a.path = "before.ply", b.path = "after.ply";
  DistanceOptions o;
  o.measures = measures;
  o.m3c2 = {0.4, 0.4, 1, 0.01};
  return distance(a, b, std::nullopt, o, {});
}

Json schema() {
  std::ifstream file(test::source_folder() / "docs" / "schema" / "distance-1.json");
  return Json::parse(file);
}

TEST(DistanceReport, JsonIsThatOfTheSchema) {
  for (const DistanceMeasures& m : {DistanceMeasures{true, true, true, true, true, true, true}, DistanceMeasures{true},
                                    DistanceMeasures{false, false, false, false, false, false, true}}) {
    const Json json = Json::parse(distance_json(sample(m), {"result.json"}));
    for (const std::string& violation : test::SchemaCheck::violations(schema(), json)) ADD_FAILURE() << violation;
    EXPECT_EQ(json["c2s"].is_null(), !m.c2s);
    EXPECT_EQ(json["hausdorff"].is_null(), !m.hausdorff);
    EXPECT_EQ(json["m3c2"].is_null(), !m.m3c2);
    EXPECT_EQ(json["parameters"]["normal_scale"].is_null(), !m.m3c2);
  }
}

TEST(DistanceReport, JsonHoldsTheNumbers) {
  const Distances d = sample({true, true, true, true, true, true, true});
  const Json json = Json::parse(distance_json(d, {"x.ply"}));
  EXPECT_EQ(json["vertical"]["a_to_b"]["signed_mean"].get<double>(), d.vertical->a_to_b.signed_mean);
  EXPECT_EQ(json["c2c"]["b_to_a"]["p95"].get<double>(), d.c2c->b_to_a.p95);
  EXPECT_EQ(json["surface"]["a_to_b"]["rms"].get<double>(), d.surface->a_to_b.rms);
  EXPECT_EQ(json["hausdorff"]["upper"].get<double>(), std::max(d.hausdorff->a_to_b.upper, d.hausdorff->b_to_a.upper));
  EXPECT_EQ(json["m3c2"]["significant"].get<std::size_t>(), d.m3c2->significant);
  EXPECT_EQ(json["outputs"][0], "x.ply");
  EXPECT_EQ(json["parameters"]["measure"], "c2c,c2s,normal,vertical,surface,hausdorff,m3c2");
}

TEST(DistanceReport, TextHasUnitsAndWarnings) {
  Distances d = sample({true, true, true, true, true, true, true});
  d.warnings = {"look out: leave @border hull out"};
  EXPECT_EQ(Json::parse(distance_json(d, {}))["warnings"][0], "look out: leave --border hull out");
  const std::string text = distance_text(d);
  for (const char* part : {"before.ply", "c2c", "c2s", "normal", "vertical", "surface", "Hausdorff", "m3c2", " mm",
                           "warning: look out: leave --border hull out"})
    EXPECT_NE(text.find(part), std::string::npos) << part;
  EXPECT_EQ(distance_text(sample({true})).find("Hausdorff"), std::string::npos);
}

TEST(DistanceReport, FilesHoldTheFields) {
  const Distances d = sample({true, false, false, true, false, false, true});
  const auto folder = std::filesystem::temp_directory_path() / "isopach-distance-report-test";
  std::filesystem::create_directories(folder);
  Cloud a = test::cloud_over(test::framed_square(300, 1), [](const Point2& p) { return 0.1 * p.x; });
  ReadOptions all;
  all.all_attributes = true;
  for (const char* end : {"ply", "csv", "las"}) {
    const std::string path = (folder / (std::string("points.") + end)).string();
    write_distance_points(path, a, d.fields_a, {});
    const Cloud back = read_cloud(path, all, {});
    ASSERT_NE(back.find_attribute("vertical"), nullptr) << end;
    for (std::size_t i = 0; i < a.points.size(); ++i)
      EXPECT_EQ(back.find_attribute("vertical")->values[i], d.fields_a[1].values[i]);
    const std::string cores = (folder / (std::string("cores.") + end)).string();
    write_core_points(cores, d, {});
    const Cloud core = read_cloud(cores, all, {});
    for (const char* name : {"distance", "lod", "significant", "sigma1", "sigma2", "n1", "n2", "nx", "ny", "nz"})
      EXPECT_NE(core.find_attribute(name), nullptr) << end << ' ' << name;
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace isopach
