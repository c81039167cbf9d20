// result.json of `isopach combine` against its schema, the summary, the page, the model.
#include "isopach/report/combine.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "isopach/apps/face_pose.hpp"
#include "isopach/io/read.hpp"
#include "isopach/simulate/face_and_jaw.hpp"
#include "tests/apps/mean_faces.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;

const Combination& sample() {
  static const Combination c = [] {
    FaceAndJawOptions o;
    o.points = 8000;
    const FaceAndJaw s = make_face_and_jaw(o, 6);
    CombineOptions options;
    options.start_face = s.face_reference;
    options.start_jaw = s.jaw_reference;
    Combination made = combine(s.face, s.jaw, s.reference, options, {});
    made.warnings.emplace_back("mind <the> gap (@unit)");
    return made;
  }();
  return c;
}

Cloud part_of(const Combination& c, CombinedPart part) {
  Cloud cloud;
  for (std::size_t i = 0; i < c.points.size(); ++i)
    if (c.part[i] == part) cloud.points.push_back(c.points[i]);
  return cloud;
}

TEST(CombineReport, JsonIsThatOfTheSchemaAndHoldsTheNumbers) {
  std::ifstream file(test::source_folder() / "docs" / "schema" / "combine-1.json");
  const Json schema = Json::parse(file);
  const Combination& c = sample();
  const Json json = Json::parse(combine_json(c, {"combined.ply"}));
  for (const std::string& violation : test::SchemaCheck::violations(schema, json)) ADD_FAILURE() << violation;
  Combination without = c;
  without.options.start_face.reset();
  for (const std::string& violation : test::SchemaCheck::violations(schema, Json::parse(combine_json(without, {}))))
    ADD_FAILURE() << violation;
  EXPECT_EQ(json["pose"]["matrix"][0][3].get<double>(), c.face_jaw.m[3]);
  EXPECT_EQ(json["jaw"]["share"].get<double>(), c.jaw.share);
  EXPECT_EQ(json["uncertainty"]["covariance"][5][5].get<double>(), c.covariance[35]);
  EXPECT_EQ(json["parts"]["reference_in_jaw"].get<std::size_t>(), c.counts[3]);
}

TEST(CombineReport, TextAndPage) {
  const Combination& c = sample();
  const std::string text = combine_text(c);
  for (const char* word : {"face.ply with jaw.ply", " mm", "jaw to face", "warning: mind <the> gap (--unit)"})
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  const std::string json = combine_json(c, {}), page = combine_html(c, json, Context{});
  for (const char* word :
       {"mind &lt;the&gt; gap (--unit)", "From jaw to face", "<svg", "data-key=\"uncertainty.sigma_middle\""})
    EXPECT_NE(page.find(word), std::string::npos) << word;
  const std::string rest = page.substr(0, page.find("<script type=\"application/json\" id=\"view-data\">"));
  EXPECT_LT(rest.size(), page.size()) << "what follows is the view";
  for (const char* word : {"http://", "https://", "<script>"}) EXPECT_EQ(rest.find(word), std::string::npos) << word;
}

/// A face that lies on its side, looking along -x: its pictures are upright, and the first is seen from the front.
TEST(CombineReport, PicturesOfAFaceStandUpright) {
  Combination c = sample();
  EXPECT_EQ(combine_html(c, combine_json(c, {}), Context{}).find("R on the left") != std::string::npos,
            find_face(part_of(c, CombinedPart::face), {}, {}).found());
  test::FaceScan scan;
  scan.points = 3000;
  const Cloud upright = test::mean_face_scan(scan);
  c.points.clear();
  for (const Point3& p : upright.points) c.points.push_back({-p.z, -p.x, p.y});
  c.part.assign(c.points.size(), CombinedPart::face);
  c.counts = {c.points.size(), 0, 0, 0};
  const FacePose pose = find_face(part_of(c, CombinedPart::face), {}, {});
  ASSERT_TRUE(pose.found());
  EXPECT_LT(pose.front.x, -0.95);
  const std::string page = combine_html(c, combine_json(c, {}), Context{});
  for (const char* word : {"from the front, R on the left", "the front on the right", "patient&#39;s left"})
    EXPECT_NE(page.find(word), std::string::npos) << word;
  EXPECT_EQ(page.find("along z of the face scan"), std::string::npos);
}

TEST(CombineReport, ModelWithParts) {
  const Combination& c = sample();
  const std::string path = (std::filesystem::temp_directory_path() / "isopach_combined.ply").string();
  write_combined(path, c, {});
  ReadOptions wanted;
  wanted.all_attributes = true;
  const Cloud cloud = read_cloud(path, wanted, {});
  std::filesystem::remove(path);
  ASSERT_EQ(cloud.points.size(), c.points.size());
  EXPECT_EQ(cloud.points.back(), c.points.back());
  const auto& part = cloud.find_attribute("part")->values;
  EXPECT_EQ(static_cast<std::size_t>(std::count(part.begin(), part.end(), 3.0)), c.counts[3]);
}

}  // namespace
}  // namespace isopach
