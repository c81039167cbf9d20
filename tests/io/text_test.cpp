#include "isopach/io/text.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "isopach/base/parallel.hpp"
#include "tests/io/files.hpp"

namespace isopach {
namespace {

using test::bytes_of;
using test::expect_input_error;
using test::read_all;

Cloud parse(const std::string& text, const ReadOptions& options = read_all()) {
  return parse_text(bytes_of(text), "scan.xyz", options, Context{});
}

void expect_error(const std::string& text, const std::string& part) {
  expect_input_error([&] { (void)parse(text); }, "scan.xyz", part);
}

void expect_two_points(const std::string& text) {
  SCOPED_TRACE(text);
  const Cloud cloud = parse(text);
  ASSERT_EQ(cloud.points.size(), 2u);
  EXPECT_EQ(cloud.points[0], (Point3{1.5, -2, 3}));
  EXPECT_EQ(cloud.points[1], (Point3{4, 5.25, -6e3}));
}

TEST(TextTest, SeparatorsAndLineEnds) {
  expect_two_points("1.5 -2 3\n4 5.25 -6e3\n");
  expect_two_points("1.5 -2 3\n4 5.25 -6e3");
  expect_two_points("  1.5   -2\t3  \r\n\r\n4 5.25 -6E+3\r\n\r\n");
  expect_two_points("1.5,-2,3\n4,5.25,-6e3\n");
  expect_two_points("1.5, -2 ,3,\n 4,5.25, -6e3 ,\n");
  expect_two_points("1.5\t-2\t3\n4\t5.25\t-6e3\n");
  expect_two_points("1.5;-2;3\n4;5.25;-6e3\n");
  expect_two_points("\"1.5\";\"-2\";\"3\"\n\"4\";\"5.25\";\"-6e3\"\n");
  expect_two_points("+1.5 -2.0 +3\n4. 5.25 -6000\n");
  expect_two_points(
      "\xEF\xBB\xBF"
      "1.5 -2 3\n4 5.25 -6e3\n");
}

TEST(TextTest, DecimalCommasBetweenSemicolonsOrTabsAreNoted) {
  for (const std::string text : {"x;y;z\n1,5;-2;3\n4;5,25;-6e3\n", "1,5\t-2,0\t3,0\n4,0\t5,25\t-6000\n"}) {
    expect_two_points(text);
    ASSERT_EQ(parse(text).notes.size(), 1u);
    EXPECT_NE(parse(text).notes[0].find("decimal commas"), std::string::npos);
  }
  EXPECT_TRUE(parse("1.5;2;3\n").notes.empty());
  expect_error("1,5 2,5 3,5\n", "line 1");  // the comma would separate: ambiguous, so refused
}

TEST(TextTest, CommentsAndHeaders) {
  expect_two_points("# made by hand\n% x\n! y\n// z\n1.5 -2 3\n# between\n4 5.25 -6e3\n");
  expect_two_points("X Y Z\n1.5 -2 3\n4 5.25 -6e3\n");
  expect_two_points("z,Y,\"X\"\n3,-2,1.5\n-6e3,5.25,4\n");
  expect_two_points("id;Northing;Easting;Height\nA;-2;1.5;3\nB 2;5.25;4;-6e3\n");
  expect_two_points("//X Y Z\n2\n1.5 -2 3\n4 5.25 -6e3\n");
  expect_two_points("# id x y z\n7 1.5 -2 3\n8 4 5.25 -6e3\n");
  expect_two_points("name,x,y,z\n\"a, b\",1.5,-2,3\n\"c\",4,5.25,-6e3\n");
}

TEST(TextTest, CommentThatDoesNotFitTheColumnsNamesNothing) {
  expect_two_points("# z up, x east, y north\n1.5 -2 3\n4 5.25 -6e3\n");
}

TEST(TextTest, HeaderShorterThanTheLinesIsNoted) {
  expect_two_points("x y z\n1.5 -2 3 0\n4 5.25 -6e3 0\n");
  EXPECT_EQ(parse("x y z\n1 2 3 4\n").notes.size(), 1u);
  EXPECT_TRUE(parse("x y z\n1 2 3\n").notes.empty());
}

TEST(TextTest, ColumnsOfTextAreNoAttributes) {
  const Cloud cloud = parse("name,x,y,z,q\nA,1,2,3,4\nB,5,6,7,8\n");
  ASSERT_EQ(cloud.attributes.size(), 1u);
  EXPECT_EQ(cloud.attributes[0].name, "q");
}

TEST(TextTest, AttributesByNameAndByDefault) {
  const std::string text = "x,y,z,GpsTime,Classification,Red\n1,2,3,4,5,6\n7,8,9,10,11,12\n";
  const Cloud all = parse(text);
  ASSERT_EQ(all.attributes.size(), 3u);
  EXPECT_EQ(all.attributes[0].name, "gps_time");
  EXPECT_EQ(all.find_attribute("red")->values[1], 12);
  const Cloud usual = parse(text, ReadOptions{});
  ASSERT_EQ(usual.attributes.size(), 1u);
  EXPECT_EQ(usual.attributes[0].name, "classification");
  EXPECT_EQ(usual.attributes[0].values[0], 5);
  const Cloud unnamed = parse("1 2 3 4 5\n");
  ASSERT_EQ(unnamed.attributes.size(), 2u);
  EXPECT_EQ(unnamed.attributes[1].name, "column_5");
  EXPECT_EQ(unnamed.attributes[1].values[0], 5);
}

TEST(TextTest, UnitsInTheHeader) {
  EXPECT_EQ(parse("x [mm],y [mm],z [mm]\n1,2,3\n").unit, "mm");
  EXPECT_EQ(parse("X(m);Y(m);Z(ft)\n1;2;3\n").vertical_unit, "ft");
  EXPECT_EQ(parse("lon,lat,height\n1,2,3\n").unit, "deg");
  EXPECT_EQ(parse("lon,lat,height\n1,2,3\n").vertical_unit, "unknown");
  EXPECT_EQ(parse("1 2 3\n").unit, "unknown");
}

TEST(TextTest, NotANumberIsKept) {
  const Cloud cloud = parse("1 2 nan\nNaN inf -INF\n1.#QNAN -1.#IND 1.#INF\n");
  ASSERT_EQ(cloud.points.size(), 3u);
  EXPECT_TRUE(std::isnan(cloud.points[0].z));
  EXPECT_TRUE(std::isnan(cloud.points[1].x));
  EXPECT_EQ(cloud.points[1].y, INFINITY);
  EXPECT_EQ(cloud.points[1].z, -INFINITY);
  EXPECT_TRUE(std::isnan(cloud.points[2].x) && std::isnan(cloud.points[2].y));
  EXPECT_EQ(cloud.points[2].z, INFINITY);
}

TEST(TextTest, PtsCountsItsPoints) {
  const Cloud cloud = parse("2\n1.5 -2 3 -7 10 20 30\n4 5.25 -6e3 8 40 50 60\n");
  ASSERT_EQ(cloud.points.size(), 2u);
  EXPECT_TRUE(cloud.notes.empty());
  EXPECT_EQ(cloud.find_attribute("intensity")->values[0], -7);
  EXPECT_EQ(cloud.find_attribute("blue")->values[1], 60);
  EXPECT_EQ(parse("3\n1 2 3\n4 5 6\n").notes.size(), 1u);
}

std::string ptx_scan(const std::string& pose, const std::string& points, int columns, int rows) {
  return fmt::format("{}\n{}\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n{}{}", columns, rows, pose, points);
}

TEST(TextTest, PtxPosesAreAppliedAndEmptyDirectionsLeftOut) {
  // A quarter turn about z (x -> y) and a shift by (100, 200, 300); points are row vectors in PTX.
  const std::string turn = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n100 200 300 1\n";
  const std::string still = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  const std::string text =
      ptx_scan(turn, "1 0 0 0.5\n0 0 0 0.5\n0 2 5 0.25\n0 0 0 0\n", 2, 2) + ptx_scan(still, "7 8 9 1\n", 1, 1);
  ASSERT_TRUE(is_ptx(bytes_of(text)));
  const Cloud cloud = parse(text);
  ASSERT_EQ(cloud.points.size(), 3u);
  EXPECT_EQ(cloud.points[0], (Point3{100, 201, 300}));
  EXPECT_EQ(cloud.points[1], (Point3{98, 200, 305}));
  EXPECT_EQ(cloud.points[2], (Point3{7, 8, 9}));
  EXPECT_EQ(cloud.nodata, 2u);
  EXPECT_EQ(cloud.find_attribute("intensity")->values[1], 0.25);
  expect_error(ptx_scan(still, "1 2 3 4\n", 2, 2), "fewer points");
  expect_error(ptx_scan(still, "1 2 3 4\n", 99999, 99999), "correct the header");
}

TEST(TextTest, BadLinesAreNamed) {
  expect_error("1 2 3\n4 5 6\n7 8 nine\n", "line 3");
  expect_error("1 2 3\n4 5\n", "line 2");
  expect_error("1,2,3\n4,,6\n", "line 2");
  expect_error("1 2 3\n4 5 6abc\n", "line 2");
  expect_error("x y z\n1 2 3\n1.0D+3 2 3\n", "line 3");
  expect_error("# one\n\n1 2\n", "line 3");
  expect_error("id,a,b\n1,2,3\n", "line 1");
  expect_error("1 2 3\r4 5 6\r", "CR alone");
  expect_error(std::string("\xFF\xFE"
                           "1\0 \0",
                           6),
               "UTF-16");
}

TEST(TextTest, NoPointsIsAnError) {
  for (const char* const text : {"x,y,z\n", "# nothing\n", "\n\n", "5\n", "x y z\n# 1 2 3\n"})
    expect_error(text, "no points");
}

// Many chunks: the first bad line is named, whatever thread meets it; results do not depend on the number of threads.
TEST(TextTest, ManyChunks) {
  std::string text = "x y z\n";
  for (int i = 0; i < 200000; ++i) text += fmt::format("{}.{:03} {} {}\n", 500000 + i, i % 1000, -i, 0.001 * i);
  const Cloud cloud = parse(text);
  ASSERT_EQ(cloud.points.size(), 200000u);
  for (std::size_t i = 0; i < 200000; i += 997) {
    EXPECT_EQ(cloud.points[i].x, std::strtod(fmt::format("{}.{:03}", 500000 + i, i % 1000).c_str(), nullptr));
    EXPECT_EQ(cloud.points[i].y, -static_cast<double>(i));
  }
  for (const int threads : {1, 2, 7}) {
    Cloud again;
    run_with_threads(threads, [&] { again = parse(text); });
    test::expect_same(cloud, again);
  }
  std::string broken = text;
  for (const std::size_t line : {150000u, 90000u, 199999u})
    broken[broken.find(fmt::format("{}.", 500000 + line - 2))] = 'x';
  expect_error(broken, "line 90000:");
}

TEST(TextTest, NearestDoubleLikeTheCLibrary) {
  std::string text;
  std::vector<std::string> numbers;
  for (std::uint64_t i = 1; i <= 3000; ++i)
    numbers.push_back(fmt::format("{}.{:03}", 5400000 + i * 7919 % 100000, i * 104729 % 1000));
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    text += numbers[i] + ' ' + numbers[i + 1] + ' ' + numbers[i + 2] + '\n';
  const Cloud cloud = parse(text);
  ASSERT_EQ(cloud.points.size(), 1000u);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    EXPECT_EQ(cloud.points[i].x, std::strtod(numbers[3 * i].c_str(), nullptr));
    EXPECT_EQ(cloud.points[i].y, std::strtod(numbers[3 * i + 1].c_str(), nullptr));
    EXPECT_EQ(cloud.points[i].z, std::strtod(numbers[3 * i + 2].c_str(), nullptr));
  }
}

TEST(TextTest, NumbersBeyondTheRange) {
  const Cloud cloud = parse("1e999 -1e999 1e-999\n");
  EXPECT_EQ(cloud.points[0].x, INFINITY);
  EXPECT_EQ(cloud.points[0].y, -INFINITY);
  EXPECT_EQ(cloud.points[0].z, 0);
}

}  // namespace
}  // namespace isopach
