#include "isopach/io/stl.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/io/files.hpp"

namespace isopach {
namespace {

using test::bytes_of;
using test::read_all;

Cloud parse(const std::string& text) { return parse_stl(bytes_of(text), "scan.stl", read_all(), Context{}); }

void expect_error(const std::string& text, const std::string& part) {
  test::expect_input_error([&] { (void)parse(text); }, "scan.stl", part);
}

std::string facet(const std::string& a, const std::string& b, const std::string& c) {
  return "facet normal 0 0 1\n outer loop\n  vertex " + a + "\n  vertex " + b + "\n  vertex " + c +
         "\n endloop\nendfacet\n";
}

std::string binary(const std::string& header, std::uint32_t announced,
                   const std::vector<std::array<float, 9>>& facets) {
  std::string text = header;
  text.resize(80, ' ');
  text.append(reinterpret_cast<const char*>(&announced), 4);
  for (const auto& corners : facets) {
    text.append(12, '\0');
    text.append(reinterpret_cast<const char*>(corners.data()), sizeof corners);
    text.append(2, '\0');
  }
  return text;
}

const std::vector<std::array<float, 9>> square = {{0, 0, 0, 1, 0, 0, 1, 1, 0.5f}, {0, -0.f, 0, 1, 1, 0.5f, 0, 1, 0}};

void expect_square(const Cloud& cloud) {
  ASSERT_EQ(cloud.points.size(), 4u);
  EXPECT_EQ(cloud.points[2], (Point3{1, 1, 0.5}));
  EXPECT_EQ(cloud.points[3], (Point3{0, 1, 0}));
  ASSERT_EQ(cloud.faces.size(), 2u);
  EXPECT_EQ(cloud.faces[1], (std::array<Index, 3>{0, 2, 3}));
}

TEST(StlTest, AsciiOfSeveralSolids) {
  expect_square(parse("solid a\n" + facet("0 0 0", "1 0 0", "1 1 0.5") + "endsolid a\nsolid b\n" +
                      facet("0 -0 0", "1e0 1 .5", "0 1 0") + "endsolid\n"));
}

TEST(StlTest, BinaryEvenIfItBeginsWithSolid) {
  expect_square(parse(binary("made by hand", 2, square)));
  const std::string solid = binary("solid but binary", 2, square);
  EXPECT_TRUE(is_stl(bytes_of(solid), solid.size()));
  expect_square(parse(solid));
}

TEST(StlTest, ManyTrianglesShareTheirCorners) {
  const int side = 60;  // a grid of 61 × 61 points
  std::vector<std::array<float, 9>> facets;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const auto x = static_cast<float>(i), y = static_cast<float>(j);
      facets.push_back({x, y, x * y, x + 1, y, (x + 1) * y, x + 1, y + 1, (x + 1) * (y + 1)});
      facets.push_back({x, y, x * y, x + 1, y + 1, (x + 1) * (y + 1), x, y + 1, x * (y + 1)});
    }
  const Cloud cloud = parse(binary("", static_cast<std::uint32_t>(facets.size()), facets));
  EXPECT_EQ(cloud.points.size(), 61u * 61u);
  ASSERT_EQ(cloud.faces.size(), facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(cloud.points[cloud.faces[i][k]],
                (Point3{facets[i][3 * k], facets[i][3 * k + 1], facets[i][3 * k + 2]}));
}

TEST(StlTest, NotANumberIsOnePointToo) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(parse(binary("", 1, {{nan, 0, 0, nan, 0, 0, 1, 0, 0}})).points.size(), 2u);
}

TEST(StlTest, DamagedFiles) {
  expect_error("solid empty\nendsolid empty\n", "no triangles");
  expect_error("solid a\n" + facet("0 0 0", "1 0 0", "1 1"), "line 6");
  expect_error("solid a\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 1 1\nendloop\n", "line 6");
  expect_error("solid a\nfacet\nouter loop\nvertex 0 0 0\n", "incomplete");
  expect_error(binary("", 3, square), "incomplete");
  expect_error(binary("", 0xFFFFFFFFu, square), "incomplete");
  expect_error(binary("", 0, {}), "no triangles");
  expect_error("short", "too short");
  EXPECT_EQ(parse(binary("", 1, square)).notes.size(), 1u);
}

}  // namespace
}  // namespace isopach
