#include "isopach/io/ply.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "isopach/base/parallel.hpp"
#include "tests/io/files.hpp"

namespace isopach {
namespace {

using test::bytes_of;
using test::expect_input_error;
using test::read_all;

Cloud parse(const std::string& text, const ReadOptions& options = read_all()) {
  return parse_ply(bytes_of(text), "scan.ply", options, Context{});
}

void expect_error(const std::string& text, const std::string& part) {
  expect_input_error([&] { (void)parse(text); }, "scan.ply", part);
}

template <class T>
std::string raw(T value, bool big = false) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof(T));
  if (big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

const char* const square_header =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

void expect_square(const Cloud& cloud) {
  ASSERT_EQ(cloud.points.size(), 4u);
  EXPECT_EQ(cloud.points[2], (Point3{1, 1, 0.5}));
  ASSERT_EQ(cloud.faces.size(), 2u);
  EXPECT_EQ(cloud.faces[0], (std::array<Index, 3>{0, 1, 2}));
  EXPECT_EQ(cloud.faces[1], (std::array<Index, 3>{0, 2, 3}));
}

TEST(PlyTest, Ascii) {
  const std::string body = "0 0 0\n1 0 0\n1 1 0.5\n0 1 0\n4 0 1 2 3\n";
  expect_square(parse(std::string("ply\nformat ascii 1.0\n") + square_header + body));
  std::string crlf = std::string("ply\nformat ascii 1.0\ncomment x\nobj_info y\n") + square_header + "\n" + body;
  for (std::size_t i = 0; (i = crlf.find('\n', i)) != std::string::npos; i += 2) crlf.insert(i, "\r");
  expect_square(parse(crlf));
}

TEST(PlyTest, BinaryOfBothByteOrders) {
  for (const bool big : {false, true}) {
    std::string text = fmt::format("ply\nformat binary_{}_endian 1.0\n", big ? "big" : "little") + square_header;
    for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, .5f, 0.f, 1.f, 0.f}) text += raw(value, big);
    text += raw<std::uint8_t>(4);
    for (const int corner : {0, 1, 2, 3}) text += raw(corner, big);
    expect_square(parse(text));
    const std::size_t body = text.find("end_header") + 11;
    for (std::size_t cut = text.size() - 1; cut > body; cut -= 5) expect_error(text.substr(0, cut), "incomplete");
    ReadOptions points_only;
    EXPECT_TRUE(parse(text, points_only).faces.empty());
    EXPECT_EQ(parse(text.substr(0, text.size() - 3), points_only).points.size(), 4u);  // faces are not even looked at
  }
}

TEST(PlyTest, BodyMayStartWithALineEndByte) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar a\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n";
  text += raw<std::uint8_t>('\n') + raw(1.f) + raw(2.f) + raw(3.f);
  EXPECT_EQ(parse(text).points[0], (Point3{1, 2, 3}));
}

TEST(PlyTest, EveryScalarTypeInAnyOrder) {
  for (const bool big : {false, true}) {
    std::string text = fmt::format("ply\nformat binary_{}_endian 1.0\nelement vertex 1\n", big ? "big" : "little") +
                       "property char a\nproperty uint8 b\nproperty int16 z\nproperty ushort c\nproperty int y\n"
                       "property uint32 d\nproperty float e\nproperty double x\nproperty uint64 f\nend_header\n";
    text += raw<std::int8_t>(-5) + raw<std::uint8_t>(250) + raw<std::int16_t>(-3000, big) +
            raw<std::uint16_t>(60000, big) + raw<std::int32_t>(-70000, big) + raw<std::uint32_t>(4000000000u, big) +
            raw(0.25f, big) + raw(1e-300, big) + raw<std::uint64_t>(1ull << 40, big);
    const Cloud cloud = parse(text);
    ASSERT_EQ(cloud.points.size(), 1u);
    EXPECT_EQ(cloud.points[0], (Point3{1e-300, -70000, -3000}));
    const double expected[] = {-5, 250, 60000, 4000000000.0, 0.25, 1099511627776.0};
    ASSERT_EQ(cloud.attributes.size(), 6u);
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_EQ(cloud.attributes[i].values[0], expected[i]) << cloud.attributes[i].name;
  }
}

TEST(PlyTest, ListsAndUnknownElementsAreSteppedOver) {
  const std::string header =
      "element marker 2\nproperty list ushort double weights\nproperty char kind\n"
      "element vertex 2\nproperty double x\nproperty list uchar short neighbours\nproperty double y\nproperty double "
      "z\n"
      "element edge 1\nproperty int a\nproperty int b\nend_header\n";
  std::string binary = "ply\nformat binary_little_endian 1.0\n" + header;
  binary +=
      raw<std::uint16_t>(2) + raw(1.0) + raw(2.0) + raw<std::int8_t>(1) + raw<std::uint16_t>(0) + raw<std::int8_t>(2);
  binary += raw(1.0) + raw<std::uint8_t>(3) + raw<std::int16_t>(7) + raw<std::int16_t>(8) + raw<std::int16_t>(9) +
            raw(2.0) + raw(3.0);
  binary += raw(4.0) + raw<std::uint8_t>(0) + raw(5.0) + raw(6.0);
  const std::string ascii = "ply\nformat ascii 1.0\n" + header + "2 1 2 1\n0 2\n1 3 7 8 9 2 3\n4 0 5 6\n0 1\n";
  for (const std::string& text : {binary, ascii}) {
    const Cloud cloud = parse(text);
    ASSERT_EQ(cloud.points.size(), 2u);
    EXPECT_EQ(cloud.points[0], (Point3{1, 2, 3}));
    EXPECT_EQ(cloud.points[1], (Point3{4, 5, 6}));
  }
}

TEST(PlyTest, FacesBeforeVertices) {
  const Cloud cloud = parse(
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\n"
      "element vertex 3\nproperty double x\nproperty double y\nproperty double z\nend_header\n3 2 1 0\n0 0 0\n1 0 0\n0 "
      "1 0\n");
  ASSERT_EQ(cloud.faces.size(), 1u);
  EXPECT_EQ(cloud.faces[0], (std::array<Index, 3>{2, 1, 0}));
}

TEST(PlyTest, UnitAndNamesFromTheHeader) {
  const Cloud cloud = parse(
      "ply\nformat ascii 1.0\ncomment unit: mm\ncomment crs: EPSG:25832\nelement vertex 1\nproperty double X\nproperty "
      "double Y\n"
      "property double Z\nproperty float scalar_Classification\nproperty uchar red\nend_header\n1 2 3 4 5\n",
      ReadOptions{});
  EXPECT_EQ(cloud.unit, "mm");
  EXPECT_EQ(cloud.vertical_unit, "mm");
  EXPECT_EQ(cloud.crs, "EPSG:25832");
  ASSERT_EQ(cloud.attributes.size(), 1u);
  EXPECT_EQ(cloud.attributes[0].name, "classification");
}

std::string ascii_points(const std::string& count, const std::string& body) {
  return "ply\nformat ascii 1.0\nelement vertex " + count +
         "\nproperty double x\nproperty double y\nproperty double z\nend_header\n" + body;
}

TEST(PlyTest, DamagedFiles) {
  expect_error(ascii_points("2", "1 2 3\n"), "incomplete");
  expect_error(ascii_points("2", "1.25 2.25 3\n4 5\n"), "line 9");
  expect_error(ascii_points("2", "1 2 3\n4 5 six\n"), "line 9");
  expect_error(ascii_points("0", ""), "no points");
  expect_error(ascii_points("18446744073709551615", "1 2 3\n"), "incomplete");
  expect_error(ascii_points("-1", "1 2 3\n"), "line 3");
  expect_error("ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\nend_header\n1 2\n",
               "no x, y and z");
  expect_error("ply\nformat ascii 1.0\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n",
               "no element");
  expect_error("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n", "line 4");
  expect_error("ply\nformat morse 1.0\nend_header\n", "morse");
  expect_error("ply\nelement vertex 1\nproperty int x\nend_header\n", "format");
  expect_error("plywood\n", "not a PLY file");
  expect_error("ply\nformat ascii 1.0\nelement vertex 3\n", "end_header");
  for (const std::string corner : {"-1", "3", "0.5", "nan"})
    expect_error(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\nelement "
        "face 1\n"
        "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 " +
            corner + "\n",
        "names vertex");
}

TEST(PlyTest, ManyRowsDoNotDependOnThreads) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 100000\nproperty uchar a\nproperty double x\nproperty "
      "float y\n"
      "property double z\nend_header\n";
  for (int i = 0; i < 100000; ++i)
    text += raw(static_cast<std::uint8_t>(i)) + raw(i + 0.001) + raw(static_cast<float>(-i)) + raw(1.0 / (i + 1));
  const Cloud cloud = parse(text);
  for (std::size_t i = 0; i < 100000; i += 37) {
    EXPECT_EQ(cloud.points[i],
              (Point3{static_cast<double>(i) + 0.001, -static_cast<double>(i), 1.0 / static_cast<double>(i + 1)}));
    EXPECT_EQ(cloud.attributes[0].values[i], static_cast<double>(i % 256));
  }
  for (const int threads : {1, 2, 7}) {
    Cloud again;
    run_with_threads(threads, [&] { again = parse(text); });
    test::expect_same(cloud, again);
  }
}

}  // namespace
}  // namespace isopach
