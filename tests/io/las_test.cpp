#include "isopach/io/las.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>

#include "isopach/base/parallel.hpp"
#include "isopach/io/las_format.hpp"
#include "isopach/io/laz.hpp"
#include "tests/io/files.hpp"
#include "tests/support/random.hpp"
#include "tests/support/shared_data.hpp"

namespace isopach {
namespace {

namespace fs = std::filesystem;

fs::path shared_data(const std::string& relative) { return test::shared_data(relative).value_or(relative); }

#define SKIP_IF_ABSENT(path) \
  if (!fs::exists(path)) GTEST_SKIP() << "shared data absent: " << (path)

class LasTest : public testing::Test {
 protected:
  [[nodiscard]] std::string file(const std::string& name) const { return folder_ / name; }
  test::TempFolder folder_;
};

Cloud read(const fs::path& path) { return read_las(path.string(), test::read_all(), {}); }

bool same_bits(const Array<double>& a, const Array<double>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

void expect_equal(const Cloud& a, const Cloud& b) {
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_TRUE(std::equal(a.points.begin(), a.points.end(), b.points.begin()));
  ASSERT_EQ(a.attributes.size(), b.attributes.size());
  for (std::size_t k = 0; k < a.attributes.size(); ++k) {
    EXPECT_EQ(a.attributes[k].name, b.attributes[k].name);
    EXPECT_TRUE(same_bits(a.attributes[k].values, b.attributes[k].values)) << a.attributes[k].name;
  }
  EXPECT_EQ(a.crs, b.crs);
  EXPECT_EQ(a.unit, b.unit);
  EXPECT_EQ(a.vertical_unit, b.vertical_unit);
}

// A made file: every raw number is known.
Cloud known_cloud() {
  Cloud cloud;
  for (int i = 0; i < 500; ++i) cloud.points.push_back({470000 + 0.001 * i, 4600000.25 - 0.5 * i, std::sqrt(i)});
  cloud.attributes.push_back({"classification", {}});
  cloud.attributes.push_back({"intensity", {}});
  cloud.attributes.push_back({"gps_time", {}});
  cloud.attributes.push_back({"Planarity", {}});
  for (int i = 0; i < 500; ++i) {
    cloud.attributes[0].values.push_back(i % 256);
    cloud.attributes[1].values.push_back(i * 131);
    cloud.attributes[2].values.push_back(1e5 + i / 7.0);
    cloud.attributes[3].values.push_back(i == 3 ? std::numeric_limits<double>::quiet_NaN() : 1.0 / (i + 1));
  }
  cloud.crs = "EPSG:26910";
  return cloud;
}

struct Expected {
  const char* path;
  std::size_t points;
  Point3 min, max;  // to the four decimals of the list they come from
};

// Counts and bounds found by independent readers (laspy, laszip compiled to WebAssembly, numpy).
class LasFixture : public testing::TestWithParam<Expected> {};

TEST_P(LasFixture, HasThePointsOthersFound) {
  const Expected& expected = GetParam();
  const fs::path path = shared_data(expected.path);
  SKIP_IF_ABSENT(path);
  const Cloud cloud = read(path);
  ASSERT_EQ(cloud.points.size(), expected.points);
  Box3 box;
  for (const Point3& p : cloud.points) box.add(p);
  const double step = 0.51e-3;
  EXPECT_NEAR(box.min.x, expected.min.x, step);
  EXPECT_NEAR(box.min.y, expected.min.y, step);
  EXPECT_NEAR(box.min.z, expected.min.z, step);
  EXPECT_NEAR(box.max.x, expected.max.x, step);
  EXPECT_NEAR(box.max.y, expected.max.y, step);
  EXPECT_NEAR(box.max.z, expected.max.z, step);
}

constexpr Point3 autzen_min{635619.85, 848899.7, 406.59}, autzen_max{638982.55, 853535.43, 586.38};
INSTANTIATE_TEST_SUITE_P(
    Shared, LasFixture,
    testing::Values(
        Expected{
            "formats/lasr/Example.las", 30, {339002.889, 5248000.001, 973.145}, {339015.116, 5248001.244, 978.345}},
        Expected{
            "formats/lasr/Example.laz", 30, {339002.889, 5248000.001, 973.145}, {339015.116, 5248001.244, 978.345}},
        Expected{"formats/lasr/example.copc.laz",
                 30,
                 {339002.889, 5248000.001, 973.145},
                 {339015.116, 5248001.244, 978.345}},
        Expected{"formats/lasr/extra_byte.las", 62, {286299.189, 580699.582, 20.124}, {286318.741, 580701.586, 41.419}},
        Expected{"formats/pdal-las/1.2-with-color.las", 1065, autzen_min, autzen_max},
        Expected{"formats/pdal-las/1.2-with-color.copc.laz", 1065, autzen_min, autzen_max},
        Expected{"formats/pdal-las/simple-laszip-compressor-version-1.2r0.laz", 1065, autzen_min, autzen_max},
        Expected{"formats/pdal-las/liblas-generated.laz", 1065, autzen_min, autzen_max},
        Expected{"formats/pdal-las/epsg_4326.las", 5380, {-94.6835, 31.0367, 39.081}, {-94.6606, 31.0473, 78.119}},
        Expected{"formats/pdal-las/test1_4.las",
                 1000,
                 {1694038.4456, 1816492.7063, 5592.7499},
                 {1694539.677, 1816497.9763, 5599.0697}},
        Expected{"formats/pdal-las/1.2-empty-geotiff-vlrs.las",
                 43,
                 {-25.7918, -15.9695, -13.1125},
                 {211.0852, 81.4608, 3.2833}},
        Expected{"santacruz/blanca_strip8706_120m.las",
                 77522,
                 {238991.07, 3765134.76, 245.01},
                 {239111.05, 3765254.75, 311.94}},
        Expected{"santacruz/blanca_strip8707_120m.las",
                 167868,
                 {238991.07, 3765134.76, 244.92},
                 {239111.05, 3765254.75, 311.84}}),
    [](const auto& test) {
      std::string name = test.param.path;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
      return name;
    });

TEST_F(LasTest, CompressedEqualsPlain) {
  SKIP_IF_ABSENT(shared_data("formats"));
  for (const char* stem :
       {"lasr/Example", "laspy/1_4_w_evlr", "lazperf/point10-1.0", "loadersgl-las/pdrf10-1.4",
        "loadersgl-las/pdrf4-1.3", "loadersgl-las/pdrf5-1.3", "loadersgl-las/pdrf6-1.4", "loadersgl-las/pdrf8-1.4",
        "loadersgl-las/pdrf9-1.5", "loadersgl-ripple/ripple", "pdal-las/simple"}) {
    SCOPED_TRACE(stem);
    const std::string path = (shared_data("formats") / stem).string();
    const Cloud plain = read(path + ".las"), compressed = read(path + ".laz");
    EXPECT_EQ(plain.format, "las");
    EXPECT_EQ(compressed.format, "laz");
    expect_equal(plain, compressed);
    run_with_threads(1, [&] { expect_equal(plain, read(path + ".laz")); });
    run_with_threads(7, [&] { expect_equal(plain, read(path + ".laz")); });
  }
}

// A plain file of point format 1, whose compressed form comes in regular chunks of 50 000 points.
void write_plain_format_1(const std::string& path, std::size_t points) {
  std::string bytes(227, '\0');
  std::memcpy(bytes.data(), "LASF", 4);
  bytes[24] = 1, bytes[25] = 2, bytes[104] = 1;
  const auto put = [&](std::size_t at, auto value) { std::memcpy(bytes.data() + at, &value, sizeof value); };
  put(94, std::uint16_t{227}), put(96, std::uint32_t{227}), put(105, std::uint16_t{28});
  put(107, static_cast<std::uint32_t>(points));
  for (std::size_t i = 0; i < 3; ++i) put(131 + 8 * i, 0.001);
  bytes.resize(227 + 28 * points);
  test::Random random(9);
  for (std::size_t i = 0; i < points; ++i) {
    const std::size_t at = 227 + 28 * i;
    put(at, static_cast<std::int32_t>(20 * i + random.below(50)));
    put(at + 4, static_cast<std::int32_t>(random.below(1000000)));
    put(at + 8, static_cast<std::int32_t>(random.below(3000)));
    bytes[at + 14] = 9, bytes[at + 15] = static_cast<char>(random.below(8));
    put(at + 20, 1e5 + 0.01 * static_cast<double>(i));
  }
  test::write_file(path, bytes);
}

TEST_F(LasTest, RegularChunksGiveTheSamePointsForAnyThreads) {
  for (const std::size_t points : {1ul, 50000ul, 50001ul, 549999ul, 1230000ul}) {
    SCOPED_TRACE(points);
    write_plain_format_1(file("plain.las"), points);
    compress_las(file("plain.las"), file("chunks.laz"), points, {});
    const Cloud plain = read(file("plain.las"));
    for (const int threads : {1, 2, 7})
      run_with_threads(threads, [&] { expect_equal(plain, read(file("chunks.laz"))); });
  }
}

TEST_F(LasTest, LayeredChunksGiveTheSamePointsForAnyThreads) {
  Cloud cloud;
  test::Random random(4);
  for (int i = 0; i < 720000; ++i) cloud.points.push_back({0.001 * i, 0.01 * random.below(5000), 0.5});
  write_las(file("a.las"), cloud, {});
  write_las(file("a.laz"), cloud, {});
  const Cloud plain = read(file("a.las"));
  for (const int threads : {1, 2, 7}) run_with_threads(threads, [&] { expect_equal(plain, read(file("a.laz"))); });
}

// A table that is damaged leads to the points of one thread or to an error, never to other points.
TEST_F(LasTest, ADamagedTableOfChunksIsNotBelieved) {
  write_plain_format_1(file("plain.las"), 620000);
  compress_las(file("plain.las"), file("chunks.laz"), 620000, {});
  const Cloud plain = read(file("plain.las"));
  const std::string good = test::file_content(file("chunks.laz"));
  const auto table =
      static_cast<std::size_t>(get_le<std::int64_t>(good.data() + parse_las(good, "chunks.laz").points_at));
  for (std::size_t at = table + 4; at < good.size(); ++at) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x15);
    test::write_file(file("bad.laz"), bytes);
    run_with_threads(2, [&] {
      try {
        expect_equal(plain, read(file("bad.laz")));
      } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("bad.laz"), std::string::npos);
      }
    });
  }
}

TEST_F(LasTest, EveryPointOfALargeCompressedFileIsRead) {
  const fs::path path = shared_data("lasr-bcts/bcts_2.laz");
  SKIP_IF_ABSENT(path);
  const Cloud cloud = read_las(path.string(), {}, {});
  const std::string bytes = test::file_content(path);
  const LasFile header = parse_las(bytes, "bcts_2.laz");
  EXPECT_EQ(cloud.points.size(), header.count);
  // The bounds in the header were written by another program.
  Box3 box;
  for (const Point3& p : cloud.points) box.add(p);
  EXPECT_NEAR(box.max.x, get_le<double>(bytes.data() + 179), 1e-6);
  EXPECT_NEAR(box.min.x, get_le<double>(bytes.data() + 187), 1e-6);
  EXPECT_NEAR(box.max.z, get_le<double>(bytes.data() + 211), 1e-6);
  EXPECT_EQ(cloud.crs, "EPSG:3005+5713");
  EXPECT_EQ(cloud.unit, "m");
  EXPECT_EQ(cloud.vertical_unit, "m");
}

TEST_F(LasTest, UnitsComeFromTheCrsOrStayUnknown) {
  SKIP_IF_ABSENT(shared_data("formats"));
  const auto expect = [](const char* path, const char* crs, const char* unit, const char* vertical) {
    SCOPED_TRACE(path);
    const Cloud cloud = read(shared_data(path));
    EXPECT_EQ(cloud.crs, crs);
    EXPECT_EQ(cloud.unit, unit);
    EXPECT_EQ(cloud.vertical_unit, vertical);
  };
  expect("formats/lasr/Example.las", "EPSG:26917", "m", "m");                          // keys, vertical unit alone
  expect("formats/pdal-las/epsg_4326.las", "EPSG:4326", "deg", "unknown");             // keys, geographic
  expect("formats/laspy/autzen_geo_proj.las", "EPSG:2994", "ft", "unknown");           // keys, feet
  expect("formats/pdal-las/test1_4.las", "EPSG:2903", "us-ft", "unknown");             // text, survey feet
  expect("formats/pdal-las/1.2-with-color.copc.laz", "EPSG:2991+6360", "m", "us-ft");  // text, both parts
  expect("formats/lasr/nocrs.las", "", "unknown", "unknown");
}

TEST_F(LasTest, AttributesAreThoseAskedFor) {
  const std::string path = file("a.laz");
  write_las(path, known_cloud(), {});
  ReadOptions options;
  EXPECT_EQ(read_las(path, options, {}).attributes.size(), 1u);
  EXPECT_NE(read_las(path, options, {}).find_attribute("classification"), nullptr);
  options.attributes = {"planarity", "intensity"};
  const Cloud two = read_las(path, options, {});
  EXPECT_EQ(two.attributes.size(), 2u);
  EXPECT_NE(two.find_attribute("planarity"), nullptr);
  options.attributes = {};
  EXPECT_TRUE(read_las(path, options, {}).attributes.empty());
}

TEST_F(LasTest, RoundTripKeepsEverythingWithinTheStatedError) {
  const Cloud cloud = known_cloud();
  for (const char* name : {"a.las", "a.laz"}) {
    write_las(file(name), cloud, {});
    const Cloud again = read(file(name));
    ASSERT_EQ(again.points.size(), cloud.points.size());
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      EXPECT_NEAR(again.points[i].x, cloud.points[i].x, 2e-10);  // multiples of 0.001: exact but for rounding
      EXPECT_NEAR(again.points[i].y, cloud.points[i].y, 2e-9);
      EXPECT_NEAR(again.points[i].z, cloud.points[i].z, 0.5e-8 + 1e-15);  // irrational: the finest step that fits
    }
    for (const char* attribute : {"classification", "intensity", "gps_time"})
      EXPECT_TRUE(same_bits(again.find_attribute(attribute)->values, cloud.find_attribute(attribute)->values))
          << attribute;
    EXPECT_TRUE(same_bits(again.find_attribute("planarity")->values, cloud.find_attribute("Planarity")->values));
    EXPECT_EQ(again.crs, "EPSG:26910");
    EXPECT_EQ(again.unit, "m");
    EXPECT_EQ(again.vertical_unit, "unknown");
  }
  EXPECT_LT(fs::file_size(file("a.laz")), fs::file_size(file("a.las")));
  EXPECT_EQ(folder_.files(), 2u) << "nothing is left beside the files";
}

TEST_F(LasTest, ErrorOfCoordinatesStaysBelowHalfAStep) {
  Cloud cloud;
  for (int i = 0; i < 1000; ++i) cloud.points.push_back({400000.0 / 1000 * i + 1.0 / 3, -2e2 / 7 * i, 1e-5 * i / 3});
  write_las(file("wide.las"), cloud, {});
  const Cloud again = read(file("wide.las"));
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    EXPECT_NEAR(again.points[i].x, cloud.points[i].x, 0.5e-4 + 1e-10);
    EXPECT_NEAR(again.points[i].y, cloud.points[i].y, 0.5e-4 + 1e-10);
    EXPECT_NEAR(again.points[i].z, cloud.points[i].z, 0.5e-9 + 1e-15);
  }
  cloud.points.push_back({1e7, 0, 0});
  EXPECT_THROW(write_las(file("wider.las"), cloud, {}), InputError);
  cloud.points.back().x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_las(file("nan.las"), cloud, {}), InputError);
  EXPECT_FALSE(fs::exists(file("wider.las")));
}

TEST_F(LasTest, ValuesThatAColumnCannotHoldGoToExtraBytes) {
  Cloud cloud;
  cloud.points = {{0, 0, 0}, {1, 0, 0}};
  cloud.attributes.push_back({"classification", {2.5, 300}});
  for (const char* colour : {"red", "green", "blue"}) cloud.attributes.push_back({colour, {0, 65535}});
  write_las(file("a.las"), cloud, {});
  const Cloud again = read(file("a.las"));
  EXPECT_EQ(again.find_attribute("classification_2")->values, (Array<double>{2.5, 300}));
  EXPECT_EQ(again.find_attribute("red")->values, (Array<double>{0, 65535}));
  EXPECT_EQ(again.find_attribute("red_2"), nullptr);
}

TEST_F(LasTest, FieldsAreAddedAndThePointsStayTheSame) {
  SKIP_IF_ABSENT(shared_data("formats"));
  for (const char* name :
       {"lasr/Example.las", "lasr/Example.laz", "lasr/example.copc.laz", "lasr/extra_byte.las", "laspy/1_4_w_evlr.las",
        "laspy/extra.laz", "laspy/append-bug.laz", "laspy/fullwave.laz", "loadersgl-las/pdrf10-1.4.las",
        "loadersgl-las/pdrf5-1.3.laz", "loadersgl-las/pdrf9-1.5.las", "pdal-las/1.2-with-color.las"}) {
    SCOPED_TRACE(name);
    const fs::path source = shared_data(std::string("formats/") + name);
    const Cloud before = read(source);
    std::vector<Attribute> fields = {{"dz_signed", {}}, {"dz_abs", {}}};
    for (std::size_t i = 0; i < before.points.size(); ++i) {
      fields[0].values.push_back(-1.0 / static_cast<double>(i + 1));
      fields[1].values.push_back(1.0 / static_cast<double>(i + 1));
    }
    for (const char* target : {"out.las", "out.laz"}) {
      SCOPED_TRACE(target);
      write_las_with_fields(before, file(target), fields, {});
      Cloud after = read(file(target));
      EXPECT_EQ(after.format, std::string(target).substr(4));
      ASSERT_EQ(after.attributes.size(), before.attributes.size() + 2);
      for (std::size_t k = 0; k < 2; ++k) {
        const Attribute& added = after.attributes[before.attributes.size() + k];
        EXPECT_EQ(added.name, fields[k].name);
        EXPECT_TRUE(same_bits(added.values, fields[k].values));
      }
      after.attributes.resize(before.attributes.size());
      expect_equal(before, after);
      const std::string bytes = test::file_content(file(target));
      const std::string old = test::file_content(source.string());
      const std::size_t extended = parse_las(old, "old").extended.size(),
                        copc = std::strstr(name, "copc") != nullptr ? 1 : 0;
      EXPECT_EQ(parse_las(bytes, target).extended.size(), extended - copc);
    }
  }
}

TEST_F(LasTest, FieldsMustFitTheSource) {
  write_las(file("a.las"), known_cloud(), {});
  const std::vector<Attribute> few = {{"dz", {1, 2, 3}}};
  EXPECT_THROW(write_las_with_fields(read(file("a.las")), file("b.las"), few, {}), InputError);
  std::vector<Attribute> long_name = {{std::string(33, 'x'), {}}};
  long_name[0].values.resize(500, 0);
  EXPECT_THROW(write_las_with_fields(read(file("a.las")), file("b.las"), long_name, {}), UsageError);
  EXPECT_FALSE(fs::exists(file("b.las")));
  // Twice the same name: the second is told apart.
  std::vector<Attribute> dz = {{"dz", {}}};
  dz[0].values.resize(500, 1);
  write_las_with_fields(read(file("a.las")), file("b.las"), dz, {});
  dz[0].values.assign(500, 2);
  write_las_with_fields(read(file("b.las")), file("b.las"), dz, {});
  EXPECT_EQ(read(file("b.las")).find_attribute("dz")->values[0], 1);
  EXPECT_EQ(read(file("b.las")).find_attribute("dz_2")->values[0], 2);
}

// A run takes minutes; what another program wrote meanwhile under the same name must not get the values of other
// points.
TEST_F(LasTest, FieldsDoNotGoToPointsOfAnotherFile) {
  Cloud cloud = known_cloud();
  write_las(file("a.las"), cloud, {});
  const Cloud before = read(file("a.las"));
  std::swap(cloud.points[3], cloud.points[4]);
  write_las(file("a.las"), cloud, {});
  std::vector<Attribute> dz = {{"dz", {}}};
  dz[0].values.resize(500, 1);
  EXPECT_THROW(write_las_with_fields(before, file("b.las"), dz, {}), InputError);
  cloud.points.pop_back();
  cloud.attributes.clear();
  write_las(file("a.las"), cloud, {});
  EXPECT_THROW(write_las_with_fields(before, file("b.las"), dz, {}), InputError);
  EXPECT_FALSE(fs::exists(file("b.las")));
  EXPECT_NO_THROW(write_las_with_fields(read(file("a.las")), file("b.las"), {}, {}));
}

TEST_F(LasTest, WithheldPointsAreKeptAndCounted) {
  Cloud cloud = known_cloud();
  cloud.attributes.push_back({"withheld", {}});
  for (int i = 0; i < 500; ++i) cloud.attributes.back().values.push_back(i % 5 == 0 ? 1 : 0);
  write_las(file("a.laz"), cloud, {});
  const Cloud again = read(file("a.laz"));
  EXPECT_EQ(again.points.size(), 500u);
  ASSERT_EQ(again.notes.size(), 1u);
  EXPECT_NE(again.notes[0].find("100 of 500"), std::string::npos) << again.notes[0];
}

// One line, with the name of the file.
void expect_error(const fs::path& path) {
  try {
    const Cloud cloud = read(path);
    ADD_FAILURE() << path << " was read: " << cloud.points.size() << " points";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find(path.string()), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST_F(LasTest, BadHeadersAreRefused) {
  write_las(file("good.las"), known_cloud(), {});
  const std::string good = test::file_content(file("good.las"));
  const auto bad = [&](const char* name, std::size_t at, auto value) {
    SCOPED_TRACE(name);
    std::string bytes = good;
    std::memcpy(bytes.data() + at, &value, sizeof value);
    test::write_file(file(name), bytes);
    expect_error(file(name));
  };
  bad("magic.las", 0, 'X');
  bad("version.las", 25, '\x06');
  bad("header-size.las", 94, std::uint16_t{100});
  bad("offset.las", 96, std::uint32_t{0xFFFFFFF0});
  bad("format.las", 104, '\x0B');
  bad("record-length.las", 105, std::uint16_t{5});
  bad("count.las", 247, std::uint64_t{501});
  bad("huge-count.las", 247, ~std::uint64_t{0});
  bad("no-points.las", 247, std::uint64_t{0});
  bad("scale.las", 131, 0.0);
  bad("offset-nan.las", 155, std::numeric_limits<double>::quiet_NaN());
  bad("compressed-without-record.las", 104, '\x86');
}

TEST_F(LasTest, AHugeCountInACompressedFileTakesNoMemory) {
  write_las(file("good.laz"), known_cloud(), {});
  std::string bytes = test::file_content(file("good.laz"));
  const std::uint64_t huge = std::uint64_t{1} << 60;
  std::memcpy(bytes.data() + 247, &huge, sizeof huge);
  test::write_file(file("huge.laz"), bytes);
  expect_error(file("huge.laz"));
}

TEST_F(LasTest, FilesKnownToBeBrokenAreRefused) {
  SKIP_IF_ABSENT(shared_data("formats"));
  expect_error(shared_data("formats/pdal-las/1.2-no-points.las"));
  expect_error(shared_data("formats/lazperf/no-points-1.3.laz"));
}

// Every truncation, and every flip before `end`, either reads, or fails with a message that names the file; nothing
// crashes or hangs.
void mutate(const fs::path& source, const fs::path& scratch, std::size_t end = ~std::size_t{0}) {
  const std::string good = test::file_content(source.string());
  end = std::min(end, good.size());
  test::Random random(1);
  for (int i = 0; i < 150; ++i) {
    std::string bytes = good;
    if (i % 3 == 0) bytes.resize(random.below(good.size()));
    const std::size_t flips = i % 3 == 0 ? 0 : 1 + random.below(4),
                      reach = i % 3 == 1 ? std::min<std::size_t>(end, 600) : end;
    for (std::size_t k = 0; k < flips; ++k) bytes[random.below(reach)] = static_cast<char>(random.below(256));
    test::write_file(scratch, bytes);
    try {
      const Cloud cloud = read(scratch);
      EXPECT_FALSE(cloud.points.empty());
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(scratch.string()), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }
}

TEST_F(LasTest, DamagedPlainFilesReadOrSayWhy) {
  write_las(file("good.las"), known_cloud(), {});
  mutate(file("good.las"), file("bad.las"));
}

TEST_F(LasTest, DamagedCompressedFilesReadOrSayWhy) {
  write_las(file("good.laz"), known_cloud(), {});
  const std::string good = test::file_content(file("good.laz"));
  // Cut anywhere, changed before the points: what LASzip makes of damaged codes is not ours (laz.hpp).
  mutate(file("good.laz"), file("bad.laz"), parse_las(good, "good.laz").points_at);
}

TEST_F(LasTest, DamagedFixturesReadOrSayWhy) {
  SKIP_IF_ABSENT(shared_data("formats"));
  for (const char* name : {"lasr/Example.las", "lasr/Example.laz", "lasr/example.copc.laz", "lasr/extra_byte.las",
                           "lazperf/point10-1.0.laz", "pdal-las/spec_3.las"}) {
    SCOPED_TRACE(name);
    const fs::path source = shared_data(std::string("formats/") + name);
    const std::string good = test::file_content(source.string());
    const LasFile las = parse_las(good, name);
    mutate(source, file("bad.laz"), las.compressed ? las.points_at : good.size());
  }
}

}  // namespace
}  // namespace isopach
