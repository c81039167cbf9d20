#include "isopach/io/file_set.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "isopach/io/write.hpp"
#include "tests/io/files.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class FileSet : public testing::Test {
 protected:
  [[nodiscard]] std::string file(const std::string& name) const { return folder_ / name; }

  void scan(const std::string& name, const std::string& unit = "m", const std::string& crs = "") const {
    fs::create_directories(fs::path(file(name)).parent_path());
    Cloud cloud;
    const double x = static_cast<double>(name.size());
    cloud.points = {{x, 0, 0}, {x + 1, 0, 1}, {x, 1, 2}};
    cloud.attributes = {{"classification", {2, 2, 6}}};
    cloud.unit = cloud.vertical_unit = unit, cloud.crs = crs;
    write_cloud(file(name), cloud, {});
  }
  [[nodiscard]] std::string list(const std::string& name, const std::string& text) const {
    test::write_file(file(name), text);
    return file(name);
  }
  /// Names of the files, as seen from the folder.
  [[nodiscard]] std::vector<std::string> names(const std::string& what) const {
    std::vector<std::string> found = files_of(what);
    for (std::string& path : found) path = fs::path(path).lexically_relative(folder_ / "").string();
    return found;
  }
  static void expect_error(const std::string& what, const std::string& part) {
    try {
      (void)files_of(what);
      ADD_FAILURE() << what << ": no error";
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(part), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }
  [[nodiscard]] static Json item(const Json& assets) {
    return {{"type", "Feature"}, {"stac_version", "1.0.0"}, {"id", "one"}, {"assets", assets}};
  }
  [[nodiscard]] static Json vpc(const std::vector<std::string>& hrefs) {
    Json all{{"type", "FeatureCollection"}, {"features", Json::array()}};
    for (const std::string& href : hrefs)
      all["features"].push_back(
          item({{"data", {{"href", href}, {"roles", {"data"}}}}, {"overview", {{"href", "o.laz"}}}}));
    return all;
  }

  test::TempFolder folder_;
};

using Names = std::vector<std::string>;

TEST_F(FileSet, AFileIsItself) {
  scan("a.ply");
  EXPECT_FALSE(is_file_set(file("a.ply")));
  EXPECT_EQ(names(file("a.ply")), Names{"a.ply"});
  EXPECT_EQ(files_of("no/such.las"), Names{"no/such.las"});  // whoever reads it says so
  test::write_file(file("[odd]*.ply"), "ply\n");
  EXPECT_FALSE(is_file_set(file("[odd]*.ply")));
}

TEST_F(FileSet, FolderSortedWithoutWhatIsNoScan) {
  for (const char* const name : {"t/b.ply", "t/a.las", "t/c.laz", "t/below/d.ply"}) scan(name);
  fs::rename(file("t/c.laz"), file("t/C.LAZ"));
  for (const char* const name : {"t/readme.txt", "t/table.csv", "t/report.pdf"})
    test::write_file(file(name), "no scan");
  EXPECT_TRUE(is_file_set(file("t")));
  EXPECT_EQ(names(file("t")), (Names{"t/C.LAZ", "t/a.las", "t/b.ply"}));
  fs::create_directory(file("empty"));
  expect_error(file("empty"), "no scan in this folder");
  test::write_file(file("t/result.json"), R"({"schema": "other/1"})");
  EXPECT_EQ(names(file("t")).size(), 3u);
  test::write_file(file("t/result.json"), R"({"schema": "isopach.compare/1", "outputs": ["b.ply"]})");
  expect_error(file("t"), "holds a result of isopach (result.json)");
}

TEST_F(FileSet, Pattern) {
  for (const char* const name : {"t/b1.ply", "t/b2.ply", "t/b10.ply", "t/a.las"}) scan(name);
  EXPECT_TRUE(is_file_set(file("t/b*.ply")));
  EXPECT_EQ(names(file("t/b*.ply")), (Names{"t/b1.ply", "t/b10.ply", "t/b2.ply"}));
  EXPECT_EQ(names(file("t/b[12].ply")), (Names{"t/b1.ply", "t/b2.ply"}));
  EXPECT_EQ(names(file("*/?.las")), Names{"t/a.las"});
  expect_error(file("t/c*.ply"), "no file has such a name");
}

TEST_F(FileSet, List) {
  for (const char* const name : {"t/b.ply", "t/a.las", "u/c.ply", "u/d.ply"}) scan(name);
  const std::string what = list("all.txt", "\xEF\xBB\xBF# two years\r\n\r\n  u/*.ply\r\nt/b.ply\n" + file("t/a.las"));
  EXPECT_TRUE(is_file_set(what));
  EXPECT_EQ(names(what), (Names{"t/a.las", "t/b.ply", "u/c.ply", "u/d.ply"}));
  EXPECT_EQ(names(list("t/up.txt", "../u\nb.ply\n")), (Names{"t/b.ply", "u/c.ply", "u/d.ply"}));
  expect_error(list("one.txt", "t/b.ply\nt/gone.ply\n"), "t/gone.ply: no such file");
  expect_error(list("two.txt", "t/b.ply\nt/../t/b.ply\n"), "named twice");
  expect_error(list("far.txt", "t/b.ply\nhttps://example.com/a.laz\n"),
               "https://example.com/a.laz: addresses are not read");
}

TEST_F(FileSet, OrderAndFilesDoNotDependOnHowTheyAreNamed) {
  for (const char* const name : {"t/b.ply", "t/a.las", "t/c.ply"}) scan(name);
  const Names by_folder = names(file("t"));
  EXPECT_EQ(names(file("t/*")), by_folder);
  EXPECT_EQ(names(list("l.txt", "t/c.ply\nt/b.ply\nt/a.las\n")), by_folder);
  EXPECT_EQ(names(list("l.vpc", vpc({"./t/b.ply", "t/../t/c.ply", file("t/a.las")}).dump())), by_folder);
}

TEST_F(FileSet, ListsThatContainThemselves) {
  scan("a.ply");
  (void)list("b.txt", "c.txt\n");
  (void)list("c.txt", "a.ply\nb.txt\n");
  expect_error(file("b.txt"), "contains itself");
  (void)list("d.txt", "a.ply\n");
  EXPECT_EQ(names(list("e.txt", "d.txt\n")), Names{"a.ply"});
}

TEST_F(FileSet, TextsOfPointsAreNoLists) {
  for (const char* const text :
       {"1 2 3\n4 5 6\n", "# a.las\n1 2 3\n", "x y z\n1 2 3\n", "3\n1 2 3\n", "X,Y,Z\n1,2,3\n", "", "\n\n"}) {
    const std::string path = list("points.txt", text);
    EXPECT_FALSE(is_file_set(path)) << text;
    EXPECT_EQ(files_of(path), Names{path});
  }
  fs::create_directory(file("3"));  // what a count names, too
  EXPECT_FALSE(is_file_set(list("points.txt", "3\n1 2 3\n")));
}

TEST_F(FileSet, VirtualPointCloud) {
  for (const char* const name : {"a.ply", "b b.ply"}) scan(name);
  EXPECT_EQ(names(list("v.vpc", vpc({"./a.ply", "b%20b.ply"}).dump(2))), (Names{"a.ply", "b b.ply"}));
  EXPECT_EQ(names(list("w.vpc", vpc({"file://" + file("a.ply")}).dump())), Names{"a.ply"});
  expect_error(list("x.vpc", vpc({"./a.ply", "s3://bucket/b.laz"}).dump()),
               "s3://bucket/b.laz: addresses are not read");
  expect_error(list("y.vpc", vpc({"./gone.laz"}).dump()), "gone.laz: no such file");
  expect_error(list("z.vpc", vpc({"a.ply", "./a.ply"}).dump()), "named twice");
}

TEST_F(FileSet, StacItemsAndCatalogues) {
  for (const char* const name : {"a.ply", "b.ply", "c.tif.ply"}) scan(name);
  EXPECT_EQ(
      names(list("i.json",
                 item({{"cloud", {{"href", "a.ply"}, {"roles", {"data"}}}}, {"other", {{"href", "b.ply"}}}}).dump())),
      Names{"a.ply"});
  EXPECT_EQ(names(list("j.json", item({{"thumb", {{"href", "t.png"}}}, {"other", {{"href", "b.ply"}}}}).dump())),
            Names{"b.ply"});
  const Json links = Json::array({{{"rel", "self"}, {"href", "c.json"}},
                                  {{"rel", "item"}, {"href", "./i.json"}},
                                  {{"rel", "item"}, {"href", "j.json"}}});
  EXPECT_EQ(names(list("c.json", Json{{"type", "Collection"}, {"stac_version", "1.0.0"}, {"links", links}}.dump())),
            (Names{"a.ply", "b.ply"}));
  expect_error(list("n.json", item({{"thumb", {{"href", "t.png"}}}}).dump()), "item one: no asset of it is a scan");
  // Polygons as GeoJSON, or any other JSON, are no catalogue: read_cloud says what they are.
  EXPECT_FALSE(is_file_set(list("p.json", R"({"type": "FeatureCollection", "features": []})")));
}

TEST_F(FileSet, HostileCatalogues) {
  const std::string deep(200000, '['), objects = [] {
    std::string text;
    for (int i = 0; i < 100000; ++i) text += R"({"a":)";
    return text;
  }();
  for (const std::string& text :
       {std::string(), deep, objects, std::string("{"), std::string("nothing"), std::string("[]"), std::string("7"),
        std::string(R"({"type": 3})"), std::string(R"({"type": "FeatureCollection", "features": 5})"),
        std::string(R"({"type": "FeatureCollection", "features": [1, null, {"assets": []}]})"),
        std::string(R"({"type": "Feature", "assets": {"data": {"href": ["a"]}}})"),
        std::string(R"({"type": "Feature", "assets": {"data": {"href": "a\u0000b.ply"}}})"),
        std::string(R"({"type": "Feature", "assets": {"data": {"href": "a\nb.ply"}}})"),
        std::string("{\"type\": \"Feature\", \"id\": \"\xFF\"}"),
        std::string(R"({"type": "Collection", "links": [{"rel": "item", "href": "v.vpc"}]})")}) {
    if (!text.empty()) expect_error(list("v.vpc", text), "v.vpc");
  }
}

TEST_F(FileSet, NumbersOfRandomDamageInACatalogue) {
  scan("a.ply");
  const std::string good = vpc({"./a.ply"}).dump();
  test::Random random(9);
  for (int i = 0; i < 2000; ++i) {
    std::string text = good;
    for (std::size_t k = 0; k <= random.below(3); ++k)
      text[random.below(text.size())] = static_cast<char>(random.below(256));
    try {
      (void)files_of(list("v.vpc", text));
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

TEST_F(FileSet, ReadAsOneCloud) {
  scan("t/b.ply"), scan("t/a.las"), scan("t/lang.ply");
  const Cloud all = read_set(files_of(file("t")), file("t"), test::read_all(), {});
  EXPECT_EQ(all.path, file("t"));
  EXPECT_EQ(all.format, "set");
  EXPECT_EQ(all.unit, "m");  // of the PLY files: a LAS file without CRS says none
  ASSERT_EQ(all.points.size(), 9u);
  EXPECT_EQ(all.points[3], (Point3{7, 0, 0}));
  ASSERT_EQ(all.attributes.size(), 1u);  // what only LAS has is left out, and a note says so
  EXPECT_EQ(all.attributes[0].name, "classification");
  EXPECT_EQ(all.attributes[0].values.size(), 9u);
  EXPECT_TRUE(std::any_of(all.notes.begin(), all.notes.end(),
                          [](const std::string& n) { return n.find("intensity") != std::string::npos; }));
  const Cloud one = read_set({file("t/b.ply")}, "set", {}, {});
  EXPECT_EQ(one.path, file("t/b.ply"));
  EXPECT_EQ(one.format, "ply");
}

TEST_F(FileSet, EqualNotesAreToldOnce) {
  EXPECT_EQ(join_notes({{"a.las", {"one", "two"}}}), (Names{"one", "two"}));
  EXPECT_EQ(join_notes({{"a.las", {"one"}}, {"b.xyz", {"b.xyz: two", "one"}}, {"c.xyz", {"c.xyz: two", "one"}}}),
            (Names{"a.las and 2 more: one", "b.xyz and 1 more: two"}));
  std::vector<FileNotes> many;
  for (int i = 0; i < 30; ++i) many.push_back({fmt::format("{}.las", i), {fmt::format("{} points", i)}});
  const Names joined = join_notes(many);
  ASSERT_EQ(joined.size(), 21u);
  EXPECT_EQ(joined.front(), "0.las: 0 points");
  EXPECT_EQ(joined.back(), "10 more notes on its files");
}

TEST_F(FileSet, ContradictingSystemsAreRefused) {
  scan("u/a.ply", "m"), scan("u/b.ply", "ft");
  const auto read = [&](const char* folder) { return read_set(files_of(file(folder)), file(folder), {}, {}); };
  test::expect_input_error([&] { (void)read("u"); }, file("u/b.ply"), file("u/a.ply") + " is m");
  scan("c/a.ply", "m", "EPSG:25832"), scan("c/b.ply", "m", "EPSG:25833");
  test::expect_input_error([&] { (void)read("c"); }, file("c/b.ply"), "its CRS is EPSG:25833");
  // Known beside not known is no contradiction, in either order.
  scan("k/a.ply", "unknown"), scan("k/b.ply", "m", "EPSG:25832"), scan("k/c.ply", "unknown");
  const Cloud known = read("k");
  EXPECT_EQ(known.unit, "m");
  EXPECT_EQ(known.crs, "EPSG:25832");
  scan("k/d.ply", "mm");
  test::expect_input_error([&] { (void)read("k"); }, file("k/d.ply"), "its unit is mm");
}

TEST_F(FileSet, ABrokenFileIsNamed) {
  scan("t/a.ply");
  test::write_file(file("t/b.las"), "no LAS file");
  test::expect_input_error([&] { (void)read_set(files_of(file("t")), file("t"), {}, {}); }, file("t/b.las"), "LASF");
}

}  // namespace
}  // namespace isopach
