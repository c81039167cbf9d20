#include "isopach/io/polygons.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "isopach/base/error.hpp"
#include "tests/support/polygons.hpp"

namespace isopach {
namespace {

class Files : public testing::Test {
 protected:
  Files()
      : folder_(std::filesystem::temp_directory_path() /
                ("isopach-polygons-" + std::to_string(std::hash<const void*>()(this)) + "-" +
                 testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder_);
  }
  ~Files() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  std::string geojson(const std::string& features, const std::string& more = "") {
    return write("p.geojson", "{\"type\":\"FeatureCollection\"," + more + "\"features\":[" + features + "]}");
  }
  static std::string feature(const std::string& type, const std::string& coordinates,
                             const std::string& properties = "{}") {
    return "{\"type\":\"Feature\",\"properties\":" + properties + ",\"geometry\":{\"type\":\"" + type +
           "\",\"coordinates\":" + coordinates + "}}";
  }
  static std::string message(const std::string& path) {
    try {
      (void)read_polygons(path);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

double area(const std::vector<Edge>& edges) {
  const auto parts = trapezoids(edges);
  if (!parts) return -1;
  double sum = 0;
  for (const Trapezoid& t : *parts) sum += area_of(t);
  return sum;
}

TEST_F(Files, NamesHolesAndParts) {
  const PolygonSet f = read_polygons(geojson(
      feature("Polygon", "[[[0,0],[4,0],[4,4],[0,4],[0,0]],[[1,1],[2,1],[2,2],[1,1]]]", "{\"name\":\"pit\"}") + "," +
      feature("MultiPolygon", "[[[[10,0],[11,0],[11,1],[10,0]]],[[[20,0],[22,0],[22,2],[20,0]]]]", "{\"id\":7}") + "," +
      feature("Polygon", "[[[0,0,5],[1,0,5],[1,1,5],[0,0,5]]]")));
  ASSERT_EQ(f.polygons.size(), 3u);
  EXPECT_EQ(f.polygons[0].name, "pit");
  EXPECT_EQ(f.polygons[1].name, "7");
  EXPECT_EQ(f.polygons[2].name, "3");
  EXPECT_EQ(f.polygons[0].rings.size(), 2u);
  EXPECT_EQ(f.polygons[0].rings[0].size(), 4u);
  EXPECT_EQ(area(edges_of(f.polygons[0])), 15.5);
  EXPECT_EQ(area(edges_of(f.polygons[1])), 2.5);
  EXPECT_TRUE(f.crs.empty());  // nothing said, nothing assumed
  EXPECT_TRUE(f.notes.empty());
}

TEST_F(Files, CrsIsReadWhereItIsSaid) {
  const std::string one = feature("Polygon", "[[[0,0],[4,0],[4,4],[0,0]]]");
  EXPECT_EQ(read_polygons(geojson(one,
                                  "\"crs\":{\"type\":\"name\",\"properties\":{\"name\":"
                                  "\"urn:ogc:def:crs:EPSG::32633\"}},"))
                .crs,
            "EPSG:32633");
}

TEST_F(Files, OtherFormats) {
  const std::string wkt = write("p.csv", "name,WKT\nfield,\"POLYGON((0 0,3 0,3 3,0 3,0 0))\"\n");
  const PolygonSet f = read_polygons(wkt);
  ASSERT_EQ(f.polygons.size(), 1u);
  EXPECT_EQ(f.polygons[0].name, "field");
  EXPECT_EQ(area(edges_of(f.polygons[0])), 9);
}

TEST_F(Files, WhatIsWrongIsSaidInOneLine) {
  EXPECT_NE(message((folder_ / "none.geojson").string()).find("no such file"), std::string::npos);
  EXPECT_NE(message(write("e.geojson", "")).find("the file is empty"), std::string::npos);
  EXPECT_NE(message(write("t.txt", "1 2 3\n4 5 6\n")).find("use GeoJSON"), std::string::npos);
  EXPECT_NE(message(geojson("")).find("no feature"), std::string::npos);
  EXPECT_NE(message(geojson(feature("Point", "[1,2]"))).find("no polygon"), std::string::npos);
  EXPECT_NE(message(geojson(feature("Polygon", "[[[0,0],[1,0],[0,0]]]", "{\"name\":\"thin\"}"))).find("'thin'"),
            std::string::npos);
  EXPECT_NE(message(geojson(feature("Polygon", "[[[0,0],[1e999,0],[1,1],[0,0]]]"))).find("no number"),
            std::string::npos);
  for (const std::string& m : {message(geojson("")), message(write("t.txt", "x"))})
    EXPECT_EQ(m.find('\n'), std::string::npos);
}

TEST_F(Files, MendableIsMendedWithANote) {
  const PolygonSet open = read_polygons(geojson(feature("Polygon", "[[[0,0],[4,0],[4,4],[0,4]]]")));
  EXPECT_EQ(area(edges_of(open.polygons[0])), 16);
  ASSERT_EQ(open.notes.size(), 1u);
  EXPECT_NE(open.notes[0].find("closed"), std::string::npos);
  const PolygonSet mixed =
      read_polygons(geojson(feature("Point", "[1,2]") + "," + feature("Polygon", "[[[0,0],[4,0],[4,4],[0,0]]]")));
  ASSERT_EQ(mixed.notes.size(), 1u);
  EXPECT_NE(mixed.notes[0].find("1 of 2 features"), std::string::npos);
}

TEST(Mended, BowTiesOverlapsAndDoubledSides) {
  const auto mended_area = [](const test::Rings& rings) {
    const auto m = mended({"p", rings});
    return m ? area(edges_of(*m)) : -1;
  };
  EXPECT_NEAR(mended_area({{{0, 0}, {2, 2}, {2, 0}, {0, 2}}}), 2, 1e-12);
  EXPECT_NEAR(mended_area({{{0, 0}, {2, 0}, {2, 2}, {0, 2}}, {{1, 2}, {3, 2}, {3, 4}, {1, 4}}}), 8, 1e-12);
  EXPECT_NEAR(mended_area({{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, {{1, -1}, {2, -1}, {2, 1}, {1, 1}}}), 16 - 1 + 1, 1e-12);
  EXPECT_EQ(mended_area({{{0, 0}, {1, 1}, {2, 2}}}), -1);  // no area
}

TEST(Mended, RandomTanglesBecomeRegions) {
  const RandomStream random(5, 5);
  for (std::uint64_t round = 0; round < 150; ++round) {
    test::Ring ring;
    for (std::uint64_t k = 0; k < 12; ++k)
      ring.push_back({random.uniform(round * 100 + 2 * k), random.uniform(round * 100 + 2 * k + 1)});
    const auto m = mended({"p", {ring}});
    ASSERT_TRUE(m);
    EXPECT_GT(area(edges_of(*m)), 0) << round;
  }
}

TEST_F(Files, MaskIsItsPixels) {
  // Row 0 on top. Corners that touch, a hole, a cell without data.
  const std::string path = write("m.asc",
                                 "ncols 4\nnrows 3\nxllcorner 10\nyllcorner 20\ncellsize 2\nNODATA_value -9\n"
                                 "1 1 1 0\n5 0 1 -9\n1 1 1 1\n");
  const Mask mask = read_mask(path, {});
  EXPECT_EQ(area(mask.edges), 9 * 4);
  const auto parts = trapezoids(mask.edges);
  ASSERT_TRUE(parts);
  const auto holds = [&](double x, double y) {
    for (const Trapezoid& t : *parts)
      if (t.x0 < x && x < t.x1 && height_at(t.lower, x) < y && y < height_at(t.upper, x)) return true;
    return false;
  };
  EXPECT_TRUE(holds(11, 25));
  EXPECT_FALSE(holds(17, 25));
  EXPECT_FALSE(holds(13, 23));
  EXPECT_FALSE(holds(17, 23));
  EXPECT_TRUE(holds(17, 21));
  const std::string checkers =
      write("c.asc", "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 0 1\n0 1 0\n1 0 1\n");
  EXPECT_EQ(area(read_mask(checkers, {}).edges), 5);
  const std::string nothing = write("n.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n0 0\n");
  EXPECT_THROW((void)read_mask(nothing, {}), InputError);
}

}  // namespace
}  // namespace isopach
