#include "isopach/io/obj.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/io/files.hpp"

namespace isopach {
namespace {

using test::bytes_of;
using test::read_all;

Cloud parse(const std::string& text, const ReadOptions& options = read_all()) {
  return parse_obj(bytes_of(text), "scan.obj", options, Context{});
}

void expect_error(const std::string& text, const std::string& part) {
  test::expect_input_error([&] { (void)parse(text); }, "scan.obj", part);
}

TEST(ObjTest, VerticesAndFaces) {
  const Cloud cloud = parse(
      "# made by hand\nmtllib a.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\r\n  v  1 1 0.5\nvn 0 0 1\nvt 0 0\nv 0 1 0 # "
      "corner\n"
      "g f faces\nf 1/1/1 2//1 3/1 4\nf -4 -3 -2\nl 1 2\n");
  ASSERT_EQ(cloud.points.size(), 4u);
  EXPECT_EQ(cloud.points[2], (Point3{1, 1, 0.5}));
  ASSERT_EQ(cloud.faces.size(), 3u);
  EXPECT_EQ(cloud.faces[1], (std::array<Index, 3>{0, 2, 3}));
  EXPECT_EQ(cloud.faces[2], (std::array<Index, 3>{0, 1, 2}));
  EXPECT_TRUE(parse("v 0 0 0\nf 1 2 3\n", ReadOptions{}).faces.empty());  // not asked for, not looked at
}

TEST(ObjTest, LinesGoOn) {
  const Cloud cloud = parse("v 1 \\\n2 \\\n3\nv 4 5 6\nv 7 8 9\nf 1 2 \\\r\n3\n");
  ASSERT_EQ(cloud.points.size(), 3u);
  EXPECT_EQ(cloud.points[0], (Point3{1, 2, 3}));
  EXPECT_EQ(cloud.faces.size(), 1u);
}

TEST(ObjTest, ColoursOfSomeVertices) {
  const Cloud cloud = parse("v 0 0 0\nv 1 0 0 0.25 0.5 0.75\nv 0 1 0\n");
  ASSERT_EQ(cloud.attributes.size(), 3u);
  const Attribute* const green = cloud.find_attribute("green");
  ASSERT_NE(green, nullptr);
  EXPECT_TRUE(std::isnan(green->values[0]) && std::isnan(green->values[2]));
  EXPECT_EQ(green->values[1], 0.5);
  EXPECT_TRUE(parse("v 1 0 0 0.25 0.5 0.75\n", ReadOptions{}).attributes.empty());
}

TEST(ObjTest, FaceBeforeItsVertices) { EXPECT_EQ(parse("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").faces.size(), 1u); }

TEST(ObjTest, DamagedFiles) {
  expect_error("# nothing\no empty\n", "no points");
  expect_error("v 1 2 3\nv 4 5\n", "line 2");
  expect_error("v 1 2 3\nv 4 5 six\n", "line 2");
  expect_error("v 1 2 3\nf 1 1 0\n", "line 2");
  expect_error("v 1 2 3\nf 1 1 -2\n", "line 2");
  expect_error("v 1 2 3\nf 1 1 x\n", "line 2");
  expect_error("v 1 2 3\nf 1 1 2\n", "names vertex 2");
  expect_error(std::string("\xFE\xFF\0v", 4), "UTF-16");
}

}  // namespace
}  // namespace isopach
