// result.json of `isopach sequence` against its schema, the summary, the table, the page.
#include "isopach/report/sequence.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "isopach/io/read.hpp"
#include "isopach/simulate/chewing.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

using Json = nlohmann::ordered_json;

/// Five frames, one of them broken.
const SequenceResult& sample() {
  static const SequenceResult r = [] {
    ChewingOptions o;
    o.frames = 5, o.points = 3000, o.frames_a_cycle = 12;
    const Chewing chewing(o, 4);
    const FrameSource source{5, [](std::size_t k) { return "frame<" + std::to_string(k) + ">.ply"; },
                             [&](std::size_t k) {
                               if (k == 3) throw InputError("frame<3>.ply: broken & bent (@crop)");
                               return chewing.frame(k);
                             }};
    SequenceOptions options;
    options.rate = 15;
    return sequence(source, options, {});
  }();
  return r;
}

TEST(SequenceReport, JsonIsThatOfTheSchema) {
  std::ifstream file(test::source_folder() / "docs" / "schema" / "sequence-1.json");
  const Json schema = Json::parse(file);
  SequenceResult without = sample();
  without.hinge.reset();
  without.options.follow = Point3{1, 2, 3};
  for (const SequenceResult& r : {sample(), without})
    for (const std::string& violation :
         test::SchemaCheck::violations(schema, Json::parse(sequence_json(r, {"motion.csv"}))))
      ADD_FAILURE() << violation;
}

TEST(SequenceReport, JsonHoldsTheNumbers) {
  const SequenceResult& r = sample();
  const Json json = Json::parse(sequence_json(r, {"motion.csv"}));
  EXPECT_EQ(json["inputs"]["frames"], 5);
  EXPECT_EQ(json["inputs"]["used"], 4);
  EXPECT_EQ(json["frames"][3]["skipped"], "frame<3>.ply: broken & bent (--crop)");
  EXPECT_TRUE(json["frames"][3]["motion"].is_null());
  EXPECT_EQ(json["frames"][2]["motion"][1][3].get<double>(), r.frames[2].motion.m[7]);
  EXPECT_EQ(json["frames"][2]["head"][0][0].get<double>(), r.frames[2].head.m[0]);
  EXPECT_EQ(json["frames"][4]["excursion"].get<double>(), r.frames[4].excursion);
  EXPECT_EQ(json["parts"]["moving"].get<std::size_t>(), r.points_moving);
  EXPECT_EQ(json["hinge"]["direction"][0].get<double>(), r.hinge->direction.x);
  EXPECT_EQ(json["parameters"]["rate"], 15.0);
  EXPECT_EQ(json["warnings"].size(), 1u);
}

TEST(SequenceReport, TextHasUnitsAndWarnings) {
  const std::string text = sequence_text(sample());
  for (const char* word :
       {"4 of 5 frames", " mm", "degrees", "hinge axis", "warning: frame 3", "broken & bent (--crop)"})
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
}

TEST(SequenceReport, TableHasOneLineAFrame) {
  const std::string csv = sequence_csv(sample());
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 4);
  std::istringstream lines(csv);
  std::string head, row;
  std::getline(lines, head);
  while (std::getline(lines, row))
    EXPECT_EQ(std::count(row.begin(), row.end(), ','), std::count(head.begin(), head.end(), ','));
}

TEST(SequenceReport, PageIsWholeAndOffline) {
  const SequenceResult& r = sample();
  const std::string json = sequence_json(r, {}), page = sequence_html(r, json, Context{});
  for (const char* word :
       {"Opening", "Excursion", "Path of the point", "Path of the hinge axis", "The motion", "animation-delay",
        "skipped: frame&lt;3&gt;.ply: broken &amp; bent (--crop)", "data-key=\"widest_deg\""})
    EXPECT_NE(page.find(word), std::string::npos) << word;
  const std::string rest = page.substr(0, page.find("<script type=\"application/json\" id=\"view-data\">"));
  EXPECT_LT(rest.size(), page.size()) << "what follows is the view";
  for (const char* word : {"http://", "https://", "<script>", "nan", "inf\""})
    EXPECT_EQ(rest.find(word), std::string::npos) << word;
  std::size_t groups = 0;
  for (std::size_t i = page.find("<g class=\"turn"); i != std::string::npos; i = page.find("<g class=\"turn", i + 1))
    ++groups;
  EXPECT_EQ(groups, 4u) << "one a frame that was used";
  SequenceResult without = r;
  without.hinge.reset();
  const std::string json2 = sequence_json(without, {});
  EXPECT_EQ(sequence_html(without, json2, Context{}).find("Path of the hinge"), std::string::npos);
}

TEST(SequenceReport, PartsAsPoints) {
  const SequenceResult& r = sample();
  const std::string path = (std::filesystem::temp_directory_path() / "isopach_sequence_parts.ply").string();
  write_parts(path, r, {});
  ReadOptions wanted;
  wanted.all_attributes = true;
  const Cloud cloud = read_cloud(path, wanted, {});
  std::filesystem::remove(path);
  ASSERT_EQ(cloud.points.size(), r.points.size());
  EXPECT_EQ(cloud.points[5], r.points[5]);
  const auto& part = cloud.find_attribute("part")->values;
  EXPECT_EQ(static_cast<std::size_t>(std::count(part.begin(), part.end(), 1.0)), r.points_moving);
  EXPECT_EQ(cloud.find_attribute("blend")->values[7], r.blend[7]);
}

}  // namespace
}  // namespace isopach
