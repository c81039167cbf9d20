#include "isopach/io/pcd.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/io/files.hpp"

namespace isopach {
namespace {

using test::bytes_of;
using test::read_all;

Cloud parse(const std::string& text, const ReadOptions& options = read_all()) {
  return parse_pcd(bytes_of(text), "scan.pcd", options, Context{});
}

void expect_error(const std::string& text, const std::string& part) {
  test::expect_input_error([&] { (void)parse(text); }, "scan.pcd", part);
}

template <class T>
std::string raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof(T)};
}

std::string header(const std::string& data, int points, const std::string& viewpoint = "0 0 0 1 0 0 0") {
  return fmt::format(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS Intensity X _ Z y histogram\nSIZE 2 8 1 4 4 1\nTYPE U F U F I I\nCOUNT 1 1 3 1 "
      "1 2\n"
      "WIDTH {0}\nHEIGHT 1\nVIEWPOINT {1}\nPOINTS {0}\nDATA {2}\n",
      points, viewpoint, data);
}

void expect_two(const Cloud& cloud) {
  ASSERT_EQ(cloud.points.size(), 2u);
  EXPECT_EQ(cloud.points[0], (Point3{1e-300, -70000, 0.25}));
  EXPECT_EQ(cloud.points[1], (Point3{2.5, 80000, -0.5}));
  ASSERT_EQ(cloud.attributes.size(), 3u);
  EXPECT_EQ(cloud.find_attribute("intensity")->values[1], 65535);
  EXPECT_EQ(cloud.find_attribute("histogram_0")->values[0], -1);
  EXPECT_EQ(cloud.find_attribute("histogram_1")->values[1], 4);
}

// LZF with literals only: a valid stream of any bytes.
std::string store(const std::string& bytes) {
  std::string result;
  for (std::size_t i = 0; i < bytes.size(); i += 32) {
    const std::string part = bytes.substr(i, 32);
    result += static_cast<char>(part.size() - 1);
    result += part;
  }
  return result;
}

TEST(PcdTest, AsciiBinaryAndCompressed) {
  expect_two(parse(header("ascii", 2) + "7 1e-300 0 0 0 0.25 -70000 -1 2\n65535 2.5 0 0 0 -0.5 80000 3 4"));
  expect_two(parse(header("ascii", 2) + "7,1e-300,0,0,0,0.25,-70000,-1,2\n65535,2.5,0,0,0,-0.5,80000,3,4\n"));
  const std::string pad(3, '\xAA');
  expect_two(parse(header("binary", 2) + raw<std::uint16_t>(7) + raw(1e-300) + pad + raw(0.25f) + raw(-70000) +
                   raw<std::int8_t>(-1) + raw<std::int8_t>(2) + raw<std::uint16_t>(65535) + raw(2.5) + pad +
                   raw(-0.5f) + raw(80000) + raw<std::int8_t>(3) + raw<std::int8_t>(4)));
  const std::string fields = raw<std::uint16_t>(7) + raw<std::uint16_t>(65535) + raw(1e-300) + raw(2.5) + pad + pad +
                             raw(0.25f) + raw(-0.5f) + raw(-70000) + raw(80000) + raw<std::int8_t>(-1) +
                             raw<std::int8_t>(2) + raw<std::int8_t>(3) + raw<std::int8_t>(4);
  const std::string packed = store(fields);
  const std::string compressed = header("binary_compressed", 2) + raw(static_cast<std::uint32_t>(packed.size())) +
                                 raw(static_cast<std::uint32_t>(fields.size())) + packed;
  expect_two(parse(compressed));
  for (std::size_t cut = 1; cut < packed.size() + 8; ++cut)
    expect_error(compressed.substr(0, compressed.size() - cut), "incomplete");
}

TEST(PcdTest, LzfReferences) {
  const auto decode = [](const std::string& input, std::size_t size) {
    std::string output(size, '?');
    return decode_lzf(bytes_of(input), {output.data(), output.size()}) ? output : "damaged";
  };
  EXPECT_EQ(decode(std::string("\x02"
                               "abc"
                               "\x20\x02",
                               6),
                   6),
            "abcabc");  // three back, three long
  EXPECT_EQ(decode(std::string("\x00"
                               "a"
                               "\xE0\x01\x00",
                               5),
                   11),
            "aaaaaaaaaaa");  // overlaps itself, long form: 7 + 1 + 2
  EXPECT_EQ(decode(std::string("\x00"
                               "a"
                               "\x20\x01",
                               4),
                   4),
            "damaged");  // before the start
  EXPECT_EQ(decode(std::string("\x05"
                               "ab",
                               3),
                   6),
            "damaged");
  EXPECT_EQ(decode(std::string("\x00"
                               "a",
                               2),
                   2),
            "damaged");  // too few
  EXPECT_EQ(decode(std::string("\x01"
                               "ab",
                               3),
                   1),
            "damaged");  // too many
  EXPECT_EQ(decode("\xE0", 9), "damaged");
}

TEST(PcdTest, ViewpointIsNoted) {
  EXPECT_TRUE(parse(header("ascii", 1) + "7 1 0 0 0 2 3 1 2\n").notes.empty());
  EXPECT_EQ(parse(header("ascii", 1, "1 2 3 1 0 0 0") + "7 1 0 0 0 2 3 1 2\n").notes.size(), 1u);
}

TEST(PcdTest, RecognisedByItsContent) {
  EXPECT_TRUE(is_pcd(bytes_of("# .PCD v.7 - Point Cloud Data file format\n")));
  EXPECT_TRUE(is_pcd(bytes_of("# made by hand\nVERSION .7\nFIELDS x y z\n")));
  EXPECT_FALSE(is_pcd(bytes_of("1 2 3\n# .PCD\n")));
  EXPECT_FALSE(is_pcd(bytes_of("VERSION 2\nx y z\n")));
}

TEST(PcdTest, DamagedFiles) {
  const std::string whole = header("ascii", 2) + "7 1 0 0 0 2 3 1 2\n7 1 0 0 0 2 3 1 2\n";
  expect_error(whole.substr(0, whole.find("DATA")), "no DATA line");
  expect_error(whole.substr(0, whole.size() - 18), "incomplete");
  expect_error(header("ascii", 0), "no points");
  expect_error(header("ascii", 1000000000) + "1\n", "incomplete");
  expect_error(header("binary", 2) + "too short", "incomplete");
  expect_error(header("zipped", 1) + std::string(100, '\0'), "zipped");
  expect_error("VERSION 0.7\nDATA ascii\n1 2 3\n", "FIELDS");
  expect_error("VERSION 0.7\nFIELDS x y\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n", "no x, y and z");
  expect_error("VERSION 0.7\nFIELDS x y z\nSIZE 4 4\nDATA ascii\n1 2 3\n", "line 3");
  expect_error("VERSION 0.7\nFIELDS x y z\nSIZE 4 3 4\nPOINTS 1\nDATA ascii\n1 2 3 4 5 6\n", "field");
  expect_error("VERSION 0.7\nFIELDS x y z\nPOINTS 2\nDATA ascii\n1 2 3\n4 five 6\n", "line 6");
}

}  // namespace
}  // namespace isopach
